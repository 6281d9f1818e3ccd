"""The filters by the names users type."""

from attest_mav.errors import UsageError
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.gradient_descent import GradientDescent


def filter_names() -> tuple[str, ...]:
    """All names, in the order in which they are shown."""
    return ("gradient-descent",)


def default_filter(name: str) -> AttitudeFilter:
    """The filter of that name with its default parameters; UsageError lists the names if there is none."""
    if name == "gradient-descent":
        return GradientDescent()
    raise UsageError(f"unknown filter {name!r}; known filters: {', '.join(filter_names())}")
