"""Compiles the core ahead of time when a wheel is built; everything else is in pyproject.toml.

An editable install is never compiled, so that no stale binary can shadow a source. Where no C compiler works, or it
fails halfway, nothing is compiled: the very same files run interpreted, and the wheel is one for every machine
(py3-none-any).
"""

import json
import os
import shlex
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_ext import build_ext
from setuptools.errors import BaseError, CCompilerError

LITTLE_MEMORY = ["--param", "ggc-min-expand=5", "--param", "ggc-min-heapsize=16384"]
"""gcc collects its garbage more often: the same code from half the memory."""

WITHOUT_STUBS = ["-fno-plt"]
"""Python's own functions are called through their address in a table, without a jump in between."""

WITHOUT_EXPORTS = ["-fvisibility=hidden"]
"""The core's constants and classes are read at their own address, and not through a table that the start fills in."""


def core_extensions():
    """The extension modules of the core, or none when this is not a wheel build."""
    if "bdist_wheel" not in sys.argv:
        return []
    if not compiler_takes([]):
        print("no C compiler with the headers of Python: the core runs interpreted", file=sys.stderr)
        return []
    described = sources_of_core()
    # Without the first, position-independent code calls every small function through a table instead of inlining it:
    # steps of the filters then take twice as long. The second keeps compiled equal to interpreted.
    flags = ["-fno-semantic-interposition", "-ffp-contract=off"]
    for more in (LITTLE_MEMORY, WITHOUT_STUBS, WITHOUT_EXPORTS):
        if compiler_takes(more):
            flags += more
    # The files of the core call each other directly, too, instead of through a table.
    link_flags = ["-Wl,-Bsymbolic-functions"] if sys.platform.startswith("linux") else []
    for one in described:
        one["extra_compile_args"] += flags
    return [Extension(**one, extra_link_args=link_flags) for one in described]


def sources_of_core():
    """The extension modules of the core, whose C another process writes; none where it was ended from outside."""
    Path("build").mkdir(exist_ok=True)
    description = Path("build") / "core.json"
    done = subprocess.run([sys.executable, "tools/core_sources.py", str(description)], check=False)
    if done.returncode < 0:
        print(f"the core was not compiled, so it runs interpreted: signal {-done.returncode}", file=sys.stderr)
        return []
    if done.returncode > 0:
        sys.exit(done.returncode)
    return json.loads(description.read_text(encoding="utf-8"))


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
