"""The version of the installed package, and whether its core is compiled."""

import attest_mav.algebra


def build_kind() -> str:
    """``compiled`` when the core is machine code, else ``interpreted``."""
    origin = attest_mav.algebra.__file__ or ""
    return "interpreted" if origin.endswith(".py") else "compiled"


def version_text() -> str:
    """Version and build kind, as ``--version`` prints them."""
    from importlib import metadata  # noqa: PLC0415  (40 ms that no other command needs)

    try:
        version = metadata.version("attest-mav")
    except metadata.PackageNotFoundError:  # a source tree that was never installed
        version = "unknown"
    return f"attest-mav {version} ({build_kind()})"
