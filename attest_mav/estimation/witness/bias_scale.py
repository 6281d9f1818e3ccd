"""The accelerometer biases of two sensors that begin side by side: their scale, and whether earlier flights hold.

Two sensors on one vehicle feel the same force, so their mean difference is that of their biases. Before any manoeuvre
it shows the size of both, though not which of them has it: with three axes x of variance 2 s^2 and a prior s_0 that
weighs as much, s^2 = (3 s_0^2 + sum x^2 / 2) / 6 (inverse gamma prior: Gelman et al., Bayesian Data Analysis, 3rd ed.,
section 2.6). A small difference makes no sigma smaller, since the sensors of a board share temperature and level.

A difference that the calibrations of both do not explain refutes them, as a manoeuvre would later: both filters begin
again without, before the difference can pass for the fault of one.
"""

from typing import Final

from attest_mav.algebra import dot, square, sub
from attest_mav.estimation.witness.dispute import LanePair
from attest_mav.estimation.witness.flight_state import (
    accel_bias,
    accel_bias_variance,
    is_calibrated,
    with_accel_bias_variance,
)
from attest_mav.estimation.witness.lane_watch import LaneWatch

REFUTING_SQUARE: Final = 21.1
"""Chi-square of three axes that chance exceeds once in 10,000."""


def follow_scale(pair: LanePair) -> None:
    """Compare the biases once, when both lanes have been in good order side by side for the first time."""
    a, b, one = pair.first.state, pair.second.state, pair.first.filter
    if pair.has_scale or not pair.second_long.spans or a is None or b is None or one is None:
        return
    pair.has_scale = True
    difference = pair.second_long.difference()
    excess = sub(difference.accel, sub(accel_bias(a), accel_bias(b)))
    first, second = accel_bias_variance(a), accel_bias_variance(b)
    chi_square = 0.0
    for axis in range(3):
        noise = square(difference.accel_scatter[axis]) / difference.count
        chi_square += square(excess[axis]) / (first[axis] + second[axis] + noise)
    if chi_square > REFUTING_SQUARE and (is_calibrated(a) or is_calibrated(b)):
        pair.first.begin_uncalibrated()
        pair.second.begin_uncalibrated()
        pair.end()
        pair.has_scale = False
        return
    usual = square(one.parameters.accel_bias_sigma)
    added = (3.0 * usual + 0.5 * dot(excess, excess)) / 6.0 - usual
    for lane in (pair.first, pair.second):
        if added > 0.0 and usual > 0.0:
            _add_variance(lane, added)


def _add_variance(lane: LaneWatch, variance: float) -> None:
    state, one = lane.state, lane.filter
    if state is not None and one is not None and not is_calibrated(state):
        lane.adopt(with_accel_bias_variance(one, state, variance))
