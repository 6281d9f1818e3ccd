"""Filters of one's own: a class in any module, named MODULE:CLASS."""

import sys
from collections.abc import Mapping
from importlib import import_module
from inspect import Parameter as SignatureParameter
from inspect import signature
from typing import Any

from attest_mav.errors import UsageError
from attest_mav.filters.base import AttitudeFilter

Parameter = bool | int | float | str
"""A value that a configuration can give."""


def own_filter(name: str, parameters: Mapping[str, Parameter]) -> AttitudeFilter:
    """An instance of the class MODULE:CLASS with these parameters, which must be an ``AttitudeFilter``.

    UsageError says which part of the name, or which parameter, is wrong. Errors in the module itself pass through.
    """
    found = _class_of(name)
    try:
        made = found(**parameters)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{name}: {error}") from None
    if not isinstance(made, AttitudeFilter):
        raise UsageError(f"{name}: it makes {type(made).__name__}; expected a filter")
    return made


def own_parameters(name: str) -> dict[str, Any]:
    """The parameters that the class MODULE:CLASS is made with, and their defaults; None for one without.

    UsageError as for ``own_filter``.
    """
    try:
        named = signature(_class_of(name)).parameters.values()
    except ValueError:
        raise UsageError(f"{name}: the class does not tell its parameters; expected one written in Python") from None
    kinds = (SignatureParameter.POSITIONAL_OR_KEYWORD, SignatureParameter.KEYWORD_ONLY)
    empty = SignatureParameter.empty
    return {one.name: None if one.default is empty else one.default for one in named if one.kind in kinds}


def _class_of(name: str) -> type[AttitudeFilter]:
    """The class MODULE:CLASS."""
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
    return found


def search_here(folder: str) -> None:
    """Let modules of a folder be found, behind all others: no file in it can stand in for an installed module."""
    if folder not in sys.path:
        sys.path.append(folder)
