"""The filters by the names users type."""

from attest_mav.errors import UsageError
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.leveling.filter import Leveling
from attest_mav.filters.own import own_filter
from attest_mav.filters.robust_adaptive.filter import RobustAdaptive
from attest_mav.filters.velocity_aided.filter import VelocityAided


def filter_names() -> tuple[str, ...]:
    """All names, in the order in which they are shown."""
    return ("gradient-descent", "robust-adaptive", "leveling", "velocity-aided")


def default_filter(name: str) -> AttitudeFilter:
    """The filter of that name with its default parameters, or of the class MODULE:CLASS.

    UsageError lists the names if there is none.
    """
    if name == "gradient-descent":
        return GradientDescent()
    if name == "robust-adaptive":
        return RobustAdaptive()
    if name == "leveling":
        return Leveling()
    if name == "velocity-aided":
        return VelocityAided()
    if ":" in name:
        return own_filter(name, {})
    raise unknown_filter(name)


def unknown_filter(name: str) -> UsageError:
    """The error that lists the names."""
    return UsageError(f"unknown filter {name!r}; known filters: {', '.join(filter_names())}, and MODULE:CLASS")
