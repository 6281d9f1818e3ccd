"""Compiles the core ahead of time when a wheel is built; everything else is in pyproject.toml.

An editable install is never compiled, so that no stale binary can shadow a source. Where no C compiler works, or it
fails halfway, nothing is compiled and the very same files run interpreted.
"""

import sys
from pathlib import Path

from setuptools import setup
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

UNITS = ("estimation", "mavlink", "logs", "replay")
"""Folders of the core that are one C file each. All else is in one with the filters: their small functions of vectors
and matrices are inlined there, which makes a step faster by a fifth."""


def core_extensions():
    """The extension modules of the core, or none when this is not a wheel build."""
    if "bdist_wheel" not in sys.argv:
        return []
    from mypyc.build import mypycify

    package = Path("attest_mav")
    sources = []
    for entry in CORE:
        path = package / entry
        sources += sorted(path.rglob("*.py")) if path.is_dir() else [path]
    # __init__ files hold no code; left interpreted, they keep the packages ordinary folders.
    modules = [str(source) for source in sources if source.name != "__init__.py"]
    arguments = ["--config-file", "pyproject.toml", *modules]
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
        extension.extra_compile_args = [*extension.extra_compile_args, *flags]
    return extensions


def in_units(sources):
    """One C file for each unit, which includes those of its modules; a source on its own stays as it is."""
    if len(sources) == 1:
        return sources
    parts = {}
    for source in sources:
        unit = next((name for name in UNITS if f"attest_mav___{name}___" in source), "filters")
        parts.setdefault(unit, []).append(Path(source).resolve())
    units = []
    for unit, paths in parts.items():
        path = Path("build") / f"core_{unit}.c"
        path.write_text("".join(f'#include "{one}"\n' for one in paths))
        units.append(str(path))
    return units


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


setup(ext_modules=core_extensions(), cmdclass={"build_ext": WholeOrNone})
