"""Filters of one's own: a class in any module, named MODULE:CLASS."""

import sys
from collections.abc import Mapping
from importlib import import_module

from attest_mav.errors import UsageError
from attest_mav.filters.base import AttitudeFilter

Parameter = bool | int | float | str
"""A value that a configuration can give."""


def own_filter(name: str, parameters: Mapping[str, Parameter]) -> AttitudeFilter:
    """An instance of the class MODULE:CLASS with these parameters, which must be an ``AttitudeFilter``.

    UsageError says which part of the name, or which parameter, is wrong. Errors in the module itself pass through.
    """
    module_name, _, class_name = name.partition(":")
    if not module_name or not class_name.isidentifier():
        raise UsageError(f"{name!r} names no filter; expected MODULE:CLASS, for example my_filters:Complementary")
    try:
        module = import_module(module_name)
    except ModuleNotFoundError as error:
        raise UsageError(
            f"{name}: no module {error.name}; expected one that is installed, in PYTHONPATH or in the current folder"
        ) from None
    found = getattr(module, class_name, None)
    if not isinstance(found, type) or not issubclass(found, AttitudeFilter):
        has = "no such class" if found is None else "it is no AttitudeFilter"
        raise UsageError(f"{name}: {has}; expected a subclass of attest_mav.AttitudeFilter")
    try:
        made = found(**parameters)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{name}: {error}") from None
    if not isinstance(made, AttitudeFilter):
        raise UsageError(f"{name}: it makes {type(made).__name__}; expected a filter")
    return made


def search_here(folder: str) -> None:
    """Let modules of a folder be found, behind all others: no file in it can stand in for an installed module."""
    if folder not in sys.path:
        sys.path.append(folder)
