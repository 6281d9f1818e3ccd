"""The filters by the names users type. Each is loaded when it is first made."""

from attest_mav.errors import UsageError
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.own import own_filter


def filter_names() -> tuple[str, ...]:
    """All names, in the order in which they are shown."""
    return ("gradient-descent", "robust-adaptive", "leveling", "velocity-aided")


def default_filter(name: str) -> AttitudeFilter:
    """The filter of that name with its default parameters, or of the class MODULE:CLASS.

    UsageError lists the names if there is none.
    """
    if name == "gradient-descent":
        from attest_mav.filters.gradient_descent.filter import GradientDescent  # noqa: PLC0415

        return GradientDescent()
    if name == "robust-adaptive":
        from attest_mav.filters.robust_adaptive.filter import RobustAdaptive  # noqa: PLC0415

        return RobustAdaptive()
    if name == "leveling":
        from attest_mav.filters.leveling.filter import Leveling  # noqa: PLC0415

        return Leveling()
    if name == "velocity-aided":
        from attest_mav.filters.velocity_aided.filter import VelocityAided  # noqa: PLC0415

        return VelocityAided()
    if ":" in name:
        return own_filter(name, {})
    raise unknown_filter(name)


def unknown_filter(name: str) -> UsageError:
    """The error that lists the names."""
    return UsageError(f"unknown filter {name!r}; known filters: {', '.join(filter_names())}, and MODULE:CLASS")
