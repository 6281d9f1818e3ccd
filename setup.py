"""Compiles the core ahead of time when a wheel is built; everything else is in pyproject.toml.

An editable install is never compiled, so that no stale binary can shadow a source. Where no C compiler works, or it
fails halfway, nothing is compiled: the very same files run interpreted, and the wheel is one for every machine
(py3-none-any).
"""

import os
import shlex
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from setuptools import setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_ext import build_ext
from setuptools.errors import BaseError, CCompilerError

CORE = [
    "record.py",
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
    "estimation": "attest_mav___estimation___",
    "mavlink": "attest_mav___mavlink___",
    "logs": "attest_mav___logs___",
    "replay": "attest_mav___replay___",
    "alignment": "attest_mav___filters___velocity_aided___alignment___",
    "vehicle": "attest_mav___vehicle_",
    "group": "__native_",
}
"""C files, with what the names of their modules contain; the first that fits counts. All else is in one with the
filters: their small functions of vectors and matrices are inlined there, which makes a step faster by a fifth. The
last one is what mypyc writes for all modules together."""

LITTLE_MEMORY = ["--param", "ggc-min-expand=5", "--param", "ggc-min-heapsize=16384"]
"""gcc collects its garbage more often: the same code from half the memory."""

WITHOUT_STUBS = ["-fno-plt"]
"""Python's own functions are called through their address in a table, without a jump in between."""


def core_extensions():
    """The extension modules of the core, or none when this is not a wheel build."""
    if "bdist_wheel" not in sys.argv:
        return []
    if not compiler_takes([]):
        print("no C compiler with the headers of Python: the core runs interpreted", file=sys.stderr)
        return []
    from mypyc.build import mypycify

    package = Path("attest_mav")
    sources = []
    for entry in CORE:
        path = package / entry
        sources += sorted(path.rglob("*.py")) if path.is_dir() else [path]
    # __init__ files hold no code; left interpreted, they keep the packages ordinary folders.
    modules = [str(source) for source in sources if source.name != "__init__.py"]
    # Modules outside the core may import what a build does not install, such as numpy: mypy reads them, and is silent.
    arguments = ["--config-file", "pyproject.toml", "--follow-imports=silent", *modules]
    extensions = mypycify(arguments, opt_level="3", debug_level="0", multi_file=True)
    sys.path.insert(0, "tools")
    from compiled_docstrings import add_docstrings

    for extension in extensions:
        for source in extension.sources:
            add_docstrings(Path(source))
        extension.sources = in_units(extension.sources)
        # Without the first, position-independent code calls every small function through a table instead of
        # inlining it: steps of the filters then take twice as long. The second keeps compiled equal to interpreted.
        flags = ["-fno-semantic-interposition", "-ffp-contract=off"]
        for more in (LITTLE_MEMORY, WITHOUT_STUBS):
            if compiler_takes(more):
                flags += more
        if sys.platform.startswith("linux"):
            # The files of the core call each other directly, too, instead of through a table.
            extension.extra_link_args = [*extension.extra_link_args, "-Wl,-Bsymbolic-functions"]
        extension.extra_compile_args = [*extension.extra_compile_args, *flags]
    return extensions


def compiler_takes(flags):
    """Whether an extension module can be compiled with these flags; without any, whether it can be at all.

    Finding out later would cost a minute.
    """
    compiler = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "tried.c"
        source.write_text("#include <Python.h>\n")
        include = sysconfig.get_path("include")
        try:
            done = subprocess.run(
                [*compiler, "-Werror", *flags, f"-I{include}", "-c", str(source), "-o", f"{source}.o"],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                check=False,
            )
        except OSError:
            return False
    return done.returncode == 0


def in_units(sources):
    """One C file for each unit, which includes those of its modules; a source on its own stays as it is."""
    if len(sources) == 1:
        return sources
    parts = {}
    for source in sources:
        unit = next((name for name, part in UNITS.items() if part in module_of(source)), "filters")
        parts.setdefault(unit, []).append(Path(source).resolve())
    units = []
    for unit, paths in parts.items():
        path = Path("build") / f"core_{unit}.c"
        path.write_text("".join(f'#include "{one}"\n' for one in paths))
        units.append(str(path))
    return units


def module_of(source):
    """The name of a C file without the beginning that the files of all modules have: that of the group keeps it."""
    name = Path(source).name
    return name.removeprefix("__native_") if "attest_mav" in name else name


class WholeOrNone(build_ext):
    """Compiles all extensions or none: one that needs another which failed could not be imported."""

    def build_extensions(self):
        """Build all of them, and remove those that are done when one fails."""
        try:
            super().build_extensions()
        except (BaseError, CCompilerError, OSError) as error:
            print(f"the core was not compiled, so it runs interpreted: {error}", file=sys.stderr)
            for extension in self.extensions:
                Path(self.get_ext_fullpath(extension.name)).unlink(missing_ok=True)
            self.extensions = []
            self.distribution.ext_modules = None


class WheelOfWhatWasBuilt(bdist_wheel):
    """Names the wheel after its content: without a compiled core it fits every Python 3 and every machine."""

    def run(self):
        """Build first, then choose."""
        self.run_command("build")
        self.root_is_pure = not self.distribution.has_ext_modules()
        super().run()


setup(ext_modules=core_extensions(), cmdclass={"build_ext": WholeOrNone, "bdist_wheel": WheelOfWhatWasBuilt})
