"""Robust weighting of innovations: the equivalent variance, and the running power that a noise is estimated from.

The equivalent variance is eqs. (15) and (16) of paper 2: a measurement whose residual is k times as large as its own
standard deviation, beyond a knee c, counts with k / c times its variance. A hard gate would lock a filter out that is
wrong itself.
"""

from attest_mav.algebra import square


def inflation(normalised_residual: float, knee: float) -> float:
    """Factor on a measurement's variance, 1 up to the knee. normalised_residual: its size over its sigma."""
    return max(1.0, normalised_residual / knee)


def variance_on_gate(residual: float, state_variance: float, gate: float) -> float:
    """The measurement variance that puts the residual on the gate (in sigmas); below zero where it lies inside."""
    return square(residual / gate) - state_variance


def averaged_power(power: float, square: float, share: float, largest_step: float, floor: float) -> float:
    """The running mean square of innovations after one more.

    share: weight of the new one. largest_step: a new one counts for at most this many times the mean. floor: added to
    that limit, so that a mean of zero can grow.
    """
    return power + share * (min(square, largest_step * power + floor) - power)
