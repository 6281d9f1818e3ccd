"""The noise of an accelerometer that lasts for seconds, by how much two of them differ: vibration and aliasing.

Two sensors on one vehicle see the same motion, so the mean of their difference over a second or two is theirs. Noise
from sample to sample is seen by the filter itself.
"""

from math import sqrt
from typing import Final

from attest_mav.algebra import norm, sub
from attest_mav.estimation.witness.dispute import LanePair
from attest_mav.estimation.witness.flight_state import accel_bias
from attest_mav.estimation.witness.lane_watch import LaneWatch
from attest_mav.estimation.witness.sensor_noise import SensorNoise
from attest_mav.filters.velocity_aided.filter import VelocityAided

SPACING_NS: Final = 200_000_000
"""ns. Interval between updates of the noise."""
FALL: Final = 0.9
"""Smallest factor on the noise in one update."""
MEAN_S: Final = 2.0
"""Time of the mean difference, s."""
MEAN_WEIGHT: Final = 2.5
LARGEST_MEAN: Final = 0.5
"""m/s^2: a larger mean difference is a fault and no noise."""


def noise_of(pair: LanePair, lane: LaneWatch, one: VelocityAided) -> SensorNoise | None:
    """The noise of one lane of a pair in good order; one: the filter as it is configured. None while it is unknown."""
    newest, a, b = lane.moments.newest, pair.first.state, pair.second.state
    if newest is None or a is None or b is None or not pair.longer.spans or newest.dt_s <= 0.0:
        return None
    parameters, known = one.parameters, lane.noise
    offset = sub(accel_bias(a), accel_bias(b))
    mean = max(
        norm(sub(pair.longer.difference().accel, offset)), norm(sub(pair.second_long.difference().accel, offset))
    )
    accel = MEAN_WEIGHT * min(mean, LARGEST_MEAN) * sqrt(MEAN_S / 6.0)
    return SensorNoise(max(parameters.accel_noise, accel, 0.0 if known is None else FALL * known.accel))


def is_due(lane: LaneWatch) -> bool:
    """Whether the noise of a lane was last looked at long enough ago."""
    newest = lane.moments.newest
    return newest is not None and not 0 <= newest.t_ns - lane.noise_ns < SPACING_NS


def follow_noise(pair: LanePair, lane: LaneWatch) -> None:
    """Give a lane of a pair in good order its noise, when it is due."""
    newest, one = lane.moments.newest, lane.configured
    if newest is None or one is None or not is_due(lane):
        return
    lane.noise_ns = newest.t_ns
    noise = noise_of(pair, lane, one)
    if noise is not None and not noise.is_like(lane.noise):
        lane.noise = noise
