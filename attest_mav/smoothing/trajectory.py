"""The smoothed attitude at every inertial sample of a flight."""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from math import isfinite
from typing import Final

import numpy as np
from numpy.typing import NDArray

from attest_mav.filters.calibration import SensorErrors
from attest_mav.filters.velocity_aided.lags import LowPassDelay, low_pass_delay_by
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.backward import Smoothed, smoothed_of
from attest_mav.smoothing.model import FIELD_LAG, B, S
from attest_mav.smoothing.parts import INTERVALS, Part, Parts
from attest_mav.smoothing.problems import Motion
from attest_mav.smoothing.readings import Recording
from attest_mav.smoothing.rotations import (
    Array,
    from_vector,
    matrices,
    matrices_of_vectors,
    multiply,
    quaternions,
    turned,
    unit,
    vectors_of_matrices,
)
from attest_mav.smoothing.smoother import Smoother
from attest_mav.types import North


@dataclass(frozen=True)
class SmoothedSamples:
    """Arrays with a row for each of consecutive inertial samples."""

    t_ns: NDArray[np.int64]
    """Sensor clock, ns."""
    t_s: Array
    """Time from the second sample on, over restarts of that clock too, s."""
    q_nb: Array
    """Body to NED, (n, 4)."""
    rates: Array
    """Of the body, without bias, rad/s, (n, 3)."""
    tilt_sigma: Array
    """1-sigma of the angle between true and smoothed vertical, rad."""
    heading_sigma: Array
    """1-sigma of the rotation about the vertical, rad."""


@dataclass(frozen=True)
class Trajectory(SmoothedSamples):
    """The samples of a whole flight; 88 bytes a sample."""

    north: North
    """The north that headings refer to."""
    noise: str
    """The class of measurement noise under which the flight is most likely."""


class SmoothedParts:
    """A smoothed flight, whose attitudes at the samples are computed part by part when they are asked for."""

    def __init__(
        self,
        recording: Recording,
        parameters: FlightParameters,
        known: SensorErrors | None = None,
        intervals: int = INTERVALS,
    ) -> None:
        """parameters: of the live filter, with the vehicle's settings in them. intervals: of a part.

        known: errors of the sensor by earlier flights, at the start of this one; None for those of any sensor.
        """
        self._parts: Final = Parts(recording, parameters, intervals)
        self._result: Final = Smoother(self._parts, parameters, known).result()
        self._parameters: Final = parameters
        self.north: Final = North.TRUE if isfinite(recording.declination) else North.MAGNETIC
        """The north that headings refer to."""
        self.noise: Final = self._result.noise.name
        """The class of measurement noise under which the flight is most likely."""
        self.has_refuted: Final = self._result.has_refuted
        """Whether the flight contradicts what was known of the sensor, which then was not used."""

    def __iter__(self) -> Iterator[SmoothedSamples]:
        delay = self._low_pass_delay()
        for number in range(len(self._parts)):
            yield self._samples(self._result.problems.motion(number), delay)

    def whole(self) -> Trajectory:
        """All samples in arrays."""
        parts = list(self)
        columns = {
            one.name: np.concatenate([getattr(part, one.name) for part in parts]) for one in fields(SmoothedSamples)
        }
        return Trajectory(**columns, north=self.north, noise=self.noise)

    def _samples(self, motion: Motion, delay: LowPassDelay) -> SmoothedSamples:
        """The attitudes of a part but for its last reading, which is the first of the next part's."""
        part, intervals = motion.part, motion.intervals
        smoothed = smoothed_of(self._result.smoothed.rows(part.first, part.first + len(part.rows)))
        readings = part.readings
        before = np.clip(np.searchsorted(part.node_s, readings.t_s, side="right") - 1, 0, len(part.rows) - 2)
        share = np.minimum(1.0, (readings.t_s - part.node_s[before]) / intervals.dt_s[before])
        low_passed = _low_passed(motion, smoothed, before, share)
        bias, scale = smoothed.x[before][:, B], smoothed.x[before][:, S]
        rates = readings.gyro - bias - scale * readings.gyro
        q_nb, along = _turned_on(self._acceleration(part), low_passed, rates, delay)
        variances = smoothed.spread[:, :3]
        spread = variances[before] + share[:, np.newaxis] * (variances[before + 1] - variances[before])
        tilt = np.sqrt(spread[:, 0] + spread[:, 1] + along[:, 0] ** 2 + along[:, 1] ** 2)
        heading = np.sqrt(spread[:, 2] + along[:, 2] ** 2)
        mine = slice(None if part.is_last else -1)
        return SmoothedSamples(
            readings.t_ns[mine], readings.t_s[mine], q_nb[mine], rates[mine], tilt[mine], heading[mine]
        )

    def _low_pass_delay(self) -> LowPassDelay:
        """The group delay of the low-pass, by the lag of the magnetometer where its corner is only assumed."""
        smoothed, usual_s = self._result.smoothed, self._parts.recording.usual_s
        last = smoothed_of(smoothed.rows(len(smoothed) - 1, len(smoothed)))
        lag_s, variance = float(last.x[0, FIELD_LAG]), float(last.spread[0, FIELD_LAG])
        return low_pass_delay_by(lag_s, variance, usual_s, self._parameters)

    def _acceleration(self, part: Part) -> Array:
        """The angular acceleration in the step before each reading, rad/s^2; zero at the beginning of a stretch."""
        recording, end = self._parts.recording, part.begin + len(part.readings.t_s)
        readings = recording.rows(max(part.begin - 1, 0), end)
        step_s = np.diff(readings.t_s, prepend=readings.t_s[:1] - 1.0)
        out: Array = np.diff(readings.gyro, axis=0, prepend=readings.gyro[:1]) / step_s[:, np.newaxis]
        out = out[-len(part.readings.t_s) :]
        for stretch in recording.stretches:
            if part.begin <= stretch.begin < end:
                out[stretch.begin - part.begin] = 0.0
        return out


def smoothed_trajectory(recording: Recording, parameters: FlightParameters) -> Trajectory:
    """Smooth a flight. parameters: of the live filter, with the vehicle's settings in them."""
    return SmoothedParts(recording, parameters).whole()


def _low_passed(motion: Motion, smoothed: Smoothed, before: NDArray[np.int64], share: Array) -> Array:
    """The attitude that the low-passed sensors see at each reading. before: the node before it; share: of its interval.

    The turn that the gyro misses from one node to the next is spread over the time between them.
    """
    intervals, attitude = motion.intervals, smoothed.attitude
    predicted = np.matmul(attitude[:-1], intervals.turn)
    missed = vectors_of_matrices(np.matmul(np.swapaxes(predicted, 1, 2), attitude[1:]))
    missed[motion.part.is_gap] = 0.0
    carried = np.matmul(attitude[before], matrices(intervals.turn_at))
    closing = matrices_of_vectors(share[:, np.newaxis] * missed[before])
    out = quaternions(np.matmul(carried, closing))
    out[-1] = quaternions(attitude[-1])
    return out


def _turned_on(acceleration: Array, q_nb: Array, rates: Array, delay: LowPassDelay) -> tuple[Array, Array]:
    """The attitudes of now, and the rotation in NED along which an error of the delay acts times its sigma, rad."""
    lag_s = delay.delay_s
    now = unit(multiply(q_nb, from_vector(lag_s * rates + 0.5 * lag_s**2 * acceleration)))
    along = delay.sigma_s * turned(matrices(now), rates + lag_s * acceleration)
    return now, along
