"""The check of a filter's parameters, when it is made."""

from dataclasses import fields
from typing import Any

from attest_mav.errors import ArgumentError


def check_parameters(record: Any, positive: tuple[str, ...] = ()) -> None:
    """Refuse a parameter that is NaN or negative, or zero where it is one of ``positive``.

    record: a dataclass of parameters, whose noises, times, rates and limits are none of them negative. ArgumentError
    names the parameter.
    """
    for one in fields(record):
        value = getattr(record, one.name)
        if isinstance(value, bool) or not isinstance(value, float | int):
            continue
        is_positive = one.name in positive
        if not (value > 0.0 if is_positive else value >= 0.0):
            expected = "a number above 0" if is_positive else "0 or more"
            raise ArgumentError(f"{type(record).__name__}: {one.name} = {value!r}; expected {expected}")
