"""Compiles the core ahead of time when a wheel is built; everything else is in pyproject.toml.

An editable install is never compiled, so that no stale binary can shadow a source. Where no C compiler works, the
extensions are optional and the very same files run interpreted.
"""

import sys
from pathlib import Path

from setuptools import setup

CORE = [
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
    "logs/tlog",
    "replay",
]


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
    extensions = mypycify(["--config-file", "pyproject.toml", *modules], opt_level="3", debug_level="0")
    for extension in extensions:
        extension.optional = True
        # Without the first, position-independent code calls every small function through a table instead of
        # inlining it: steps of the filters then take twice as long. The second keeps compiled equal to interpreted.
        extension.extra_compile_args += ["-fno-semantic-interposition", "-ffp-contract=off"]
    return extensions


setup(ext_modules=core_extensions())
