"""Writes the C of the compiled core, and says in a file which extension modules are made of it.

    python tools/core_sources.py FILE.json

``setup.py`` runs this as a process of its own while it builds a wheel, so that the memory of mypy and mypyc is free
again before the C compiler begins.
"""

import gc
import json
import os
import sys
from pathlib import Path

from compiled_docstrings import add_docstrings
from mypy.fscache import FileSystemCache
from mypyc.build import construct_groups, get_mypy_config, mypycify, write_file
from mypyc.codegen import emitmodule
from mypyc.errors import Errors
from mypyc.irbuild.mapper import Mapper
from mypyc.options import CompilerOptions

CORE = [
    "record.py",
    "ring_buffer.py",
    "types.py",
    "samples.py",
    "vehicle_settings.py",
    "vehicle_reports.py",
    "estimate.py",
    "innovation.py",
    "algebra.py",
    "matrices.py",
    "matrices4.py",
    "low_pass.py",
    "plausible.py",
    "filters",
    "estimation",
    "mavlink",
    "logs/dataflash",
    "logs/tlog",
    "logs/ulog",
    "replay",
]

UNITS = {
    "estimation": ("estimation___",),
    "mavlink": ("mavlink___",),
    "logs": ("logs___",),
    "replay": ("replay___",),
    "setting up": (
        "filters___velocity_aided___alignment___",
        "filters___gradient_descent___options.",
        "filters___registry.",
        "filters___own.",
        "filters___parameter_check.",
        "filters___calibration.",
        "filters___velocity_aided___calibration.",
        "filters___velocity_aided___parameters.",
        "filters___velocity_aided___aids___airspeed.",
        "filters___velocity_aided___aids___gravity.",
        "filters___velocity_aided___aids___iron.",
        "filters___velocity_aided___aids___iron_fit.",
        "filters___velocity_aided___aids___zero_mean_velocity.",
    ),
    "records": ("vehicle_", "types.", "samples.", "estimate."),
}
"""C files, with how the names of their modules begin within the package; the first that fits counts. All else is in
one file with the filters: their small functions of vectors and matrices are inlined there, which makes a step faster
by a fifth. The tables that mypyc writes for all modules together are a file too."""

PREFIX = "__native_attest_mav___"
TABLES = "tables"
HOT = "filters"

# Modules outside the core may import what a build does not install, such as numpy: mypy reads them, and is silent.
# Without a cache mypyc keeps no second copy of the types, as text, until its end.
OPTIONS = ["--config-file", "pyproject.toml", "--follow-imports=silent", f"--cache-dir={os.devnull}"]


def modules_of_core():
    """The paths of the modules to compile, relative to the project's folder."""
    package = Path("attest_mav")
    sources = []
    for entry in CORE:
        path = package / entry
        sources += sorted(path.rglob("*.py")) if path.is_dir() else [path]
    # __init__ files hold no code; left interpreted, they keep the packages ordinary folders.
    return [str(source) for source in sources if source.name != "__init__.py"]


def write_c(arguments):
    """Translate to C files; their names, and mypyc's own sources that they need."""
    compiler_options = CompilerOptions(multi_file=True)
    cache = FileSystemCache()
    sources, all_sources, options = get_mypy_config(arguments, None, compiler_options, cache)
    groups = construct_groups(sources, separate=False, use_shared_lib=True, group_name_override=None)
    result = emitmodule.parse_and_typecheck(all_sources, options, compiler_options, groups, cache)
    errors = Errors(options)
    result.manager.errors.set_file("<mypyc>", module=None, scope=None, options=options)
    group_of = {source.module: name for group, name in groups for source in group}
    modules = emitmodule.compile_modules_to_ir(result, Mapper(group_of), compiler_options, errors)
    if errors.num_errors:
        sys.exit("\n".join(errors.new_messages()))
    forget_syntax(result)
    written = emitmodule.compile_ir_to_c(groups, modules, result, Mapper(group_of), compiler_options)
    files = [file for _, name in groups for file in written[name]]
    for name, text in files:
        write_file(str(Path(compiler_options.target_dir) / name), text)
    return [name for name, _ in files], emitmodule.collect_source_dependencies(modules)


def forget_syntax(result):
    """Let go of the syntax trees and the types of all expressions: from here on the intermediate code does alone.

    ``mypycify`` would keep them while it writes the C, which is when its memory is largest.
    """
    for state in result.graph.values():
        state.tree = None
    for table in (result.files, result.types, result.manager.modules):
        table.clear()
    gc.collect()


def extensions_of_core():
    """The extension modules, as ``mypycify`` describes them for C files that are there already."""
    arguments = [*OPTIONS, *modules_of_core()]
    names, needed = write_c(arguments)
    given = [(one.path, one.include_dirs, one.internal) for one in sorted(needed, key=lambda one: one.path)]
    written = [[(name, "") for name in names]]
    return mypycify(arguments, opt_level="3", debug_level="0", multi_file=True, skip_cgen_input=(written, given))


def in_units(sources):
    """One C file for each unit, which includes those of its modules; a source on its own stays as it is."""
    if len(sources) == 1:
        return sources
    parts = {}
    for source in sources:
        parts.setdefault(unit_of(Path(source).name), []).append(Path(source).resolve())
    units = []
    for unit, paths in parts.items():
        path = Path("build") / f"core_{unit.replace(' ', '_')}.c"
        path.write_text("".join(f'#include "{one}"\n' for one in paths))
        units.append(str(path))
    return units


def unit_of(name):
    """The unit of a C file; mypyc's own functions are with the filters, which inline them."""
    if not name.startswith(PREFIX):
        return TABLES if name.startswith("__native_") else HOT
    module = name.removeprefix(PREFIX)
    return next((unit for unit, beginnings in UNITS.items() if module.startswith(beginnings)), HOT)


def main():
    """Write the C, and describe the extension modules in the file that is named."""
    described = []
    for extension in extensions_of_core():
        for source in extension.sources:
            add_docstrings(Path(source))
        described.append(
            {
                "name": extension.name,
                "sources": in_units(extension.sources),
                "include_dirs": extension.include_dirs,
                "depends": extension.depends,
                "extra_compile_args": extension.extra_compile_args,
            }
        )
    Path(sys.argv[1]).write_text(json.dumps(described), encoding="utf-8")


if __name__ == "__main__":
    main()
