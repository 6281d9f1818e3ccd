"""Errors of real sensors, added to what a simulator's nearly perfect ones sent.

The readings of a log are whole units cut off toward zero; the errors are added to the middle of what was cut off, and
the sum is cut off again. Each set has, 1-sigma or size:

========  ===========  ==========  ==========  =======  =======  =========  ==========  ==============  =======
          gyro white   gyro bias   acc. white  bias     mag.     hard iron  GPS white   GPS correlated  latency
========  ===========  ==========  ==========  =======  =======  =========  ==========  ==============  =======
good      0.1 deg/s    0.2 deg/s   0.1 m/s^2   5 mg     2 mG     5 mG       0.05 m/s    0.05 m/s        0
typical   0.2          0.4         0.3         10       4        10         0.1         0.1             30 ms
poor      0.5          1.0         1.0         30       10       25         0.2         0.2             80 ms
========  ===========  ==========  ==========  =======  =======  =========  ==========  ==============  =======

White errors are drawn for each axis of each sample, whatever the rate; those of the magnetometer for each new reading
(its compass runs at 10 Hz and RAW_IMU repeats it), those of the receiver for each fix, however often it is sent. Biases
last for the whole flight, and every axis has the full size with a sign of its own: the vector is larger than its size
by the root of three. The correlated part of the GPS velocity forgets in 5 s. The latency is none that any message
tells: the fix arrives, and is stamped, later. Airspeed and climb keep what errors they have.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import atan2, degrees, exp, hypot, radians, sqrt
from typing import Final

import numpy as np

from attest_mav.algebra import add
from attest_mav.evaluation.flight_study.edits import clocked, restored, truncated
from attest_mav.evaluation.flight_study.flying import Column
from attest_mav.mavlink.decode.units import MILLI, MILLI_G
from attest_mav.samples import ImuSample, PositionSample, Sample, VelocitySample
from attest_mav.types import Vec3

READING_NS: Final = 100_000_000
"""A field that has been repeated for so long was read again: it has only not changed."""
CORRELATION_S: Final = 5.0
"""Time constant of the correlated part of the GPS velocity."""
CENTI: Final = 0.01
"""GPS_RAW_INT counts centimetres per second, and hundredths of a degree."""


@dataclass(frozen=True)
class SensorErrors:
    """1-sigma of the white errors, sizes of the biases; rad/s, m/s^2, gauss, m/s, s."""

    gyro: float
    gyro_bias: float
    accel: float
    accel_bias: float
    mag: float
    hard_iron: float
    velocity: float
    velocity_correlated: float
    latency_s: float


NO_ERRORS: Final = SensorErrors(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
SETS: Final = {
    "good": SensorErrors(radians(0.1), radians(0.2), 0.1, 5 * MILLI_G, 0.002, 0.005, 0.05, 0.05, 0.0),
    "typical": SensorErrors(radians(0.2), radians(0.4), 0.3, 10 * MILLI_G, 0.004, 0.010, 0.1, 0.1, 0.03),
    "poor": SensorErrors(radians(0.5), radians(1.0), 1.0, 30 * MILLI_G, 0.010, 0.025, 0.2, 0.2, 0.08),
}

_POOR: Final = SETS["poor"]
ALONE: Final = {
    "small noise, poor biases": replace(_POOR, gyro=0.0, accel=0.0, mag=0.0, velocity=0.0, velocity_correlated=0.0),
    "30 mg alone": replace(NO_ERRORS, accel_bias=_POOR.accel_bias),
    "25 mG of iron alone": replace(NO_ERRORS, hard_iron=_POOR.hard_iron),
    "poor receiver alone": replace(
        NO_ERRORS,
        velocity=_POOR.velocity,
        velocity_correlated=_POOR.velocity_correlated,
        latency_s=_POOR.latency_s,
    ),
}
"""Single errors of the poor set: those that noise does not give away are the hardest for a sigma."""


def with_sensor_errors(samples: Sequence[Sample], imu: str, *, errors: SensorErrors, seed: int) -> list[Sample]:
    """The samples as worse sensors would have sent them; equal seeds give equal errors."""
    inertial = _Inertial(errors, np.random.default_rng([seed, 0]))
    receiver = _Receiver(errors, np.random.default_rng([seed, 1]))
    late: deque[tuple[float, Sample]] = deque()
    out: list[Sample] = []
    for now_s, sample in clocked(samples, imu):
        while late and late[0][0] <= now_s:
            out.append(late.popleft()[1])
        if isinstance(sample, ImuSample) and sample.source == imu:
            out.append(inertial.spoilt(sample))
        elif isinstance(sample, VelocitySample):
            late.append((now_s + errors.latency_s, receiver.spoilt(sample)))
        elif isinstance(sample, PositionSample):
            late.append((now_s + errors.latency_s, receiver.delayed(sample)))
        else:
            out.append(sample)
    return [*out, *(sample for _, sample in late)]


class _Inertial:
    """Gyro, accelerometer and magnetometer of one flight."""

    def __init__(self, errors: SensorErrors, rng: np.random.Generator) -> None:
        self._errors = errors
        self._rng = rng
        self._gyro_bias = self._bias(errors.gyro_bias)
        self._accel_bias = self._bias(errors.accel_bias)
        self._hard_iron = self._bias(errors.hard_iron)
        self._mag: Vec3 | None = None
        self._mag_error = self._hard_iron
        self._read_ns = 0

    def spoilt(self, sample: ImuSample) -> ImuSample:
        """The sample with errors."""
        errors = self._errors
        gyro = _sent(sample.gyro, add(self._gyro_bias, self._white(errors.gyro)), MILLI)
        accel = _sent(sample.accel, add(self._accel_bias, self._white(errors.accel)), MILLI_G)
        mag = sample.mag
        if mag is not None:
            if mag != self._mag or sample.t_ns - self._read_ns >= READING_NS:
                self._mag, self._read_ns = mag, sample.t_ns
                self._mag_error = add(self._hard_iron, self._white(errors.mag))
            mag = _sent(mag, self._mag_error, MILLI)
        return sample.with_readings(gyro, accel, mag)

    def _white(self, sigma: float) -> Vec3:
        x, y, z = sigma * self._rng.standard_normal(3)
        return (float(x), float(y), float(z))

    def _bias(self, size: float) -> Vec3:
        x, y, z = size * self._rng.choice((-1.0, 1.0), 3)
        return (float(x), float(y), float(z))


class _Receiver:
    """The GPS receiver of one flight."""

    def __init__(self, errors: SensorErrors, rng: np.random.Generator) -> None:
        self._errors = errors
        self._rng = rng
        self._correlated = errors.velocity_correlated * rng.standard_normal(3)
        self._last_ns = -1
        self._last_error = np.zeros(3)

    def spoilt(self, sample: VelocitySample) -> VelocitySample:
        """The fix with errors, later; a velocity without its vertical keeps it so."""
        north, east, down = (float(v) for v in np.array(sample.v_ned) + self._error(sample.t_ns))
        if not sample.vertical_known:
            north, east = _sent_course(north, east)
            down = sample.v_ned[2]
        late_ns = self._late_ns
        return VelocitySample(
            sample.source,
            sample.system,
            sample.component,
            sample.t_ns + late_ns,
            sample.rx_ns + late_ns,
            (north, east, down),
            sample.vertical_known,
            sample.origin,
        )

    def delayed(self, sample: PositionSample) -> PositionSample:
        """The position that comes with a fix."""
        return PositionSample(
            sample.source,
            sample.system,
            sample.component,
            sample.t_ns + self._late_ns,
            sample.rx_ns + self._late_ns,
            sample.latitude_deg,
            sample.longitude_deg,
            sample.altitude_m,
        )

    @property
    def _late_ns(self) -> int:
        return round(self._errors.latency_s * 1e9)

    def _error(self, t_ns: int) -> Column:
        """Of the fix of that time, m/s; x(t + dt) = k x(t) + sqrt(1 - k^2) n with k = exp(-dt / 5 s).

        A fix that is sent again has the error that it had.
        """
        if t_ns == self._last_ns:
            return self._last_error
        if self._last_ns >= 0 and t_ns > self._last_ns:
            kept = exp(-(t_ns - self._last_ns) * 1e-9 / CORRELATION_S)
            fresh = self._errors.velocity_correlated * sqrt(1.0 - kept * kept)
            self._correlated = kept * self._correlated + fresh * self._rng.standard_normal(3)
        self._last_ns = t_ns
        self._last_error = self._correlated + self._errors.velocity * self._rng.standard_normal(3)
        return self._last_error


def _sent(reading: Vec3, error: Vec3, unit: float) -> Vec3:
    """The reading with an error added, as the message carries it."""
    return (
        truncated(restored(reading[0], unit) + error[0], unit),
        truncated(restored(reading[1], unit) + error[1], unit),
        truncated(restored(reading[2], unit) + error[2], unit),
    )


def _sent_course(north: float, east: float) -> tuple[float, float]:
    """A horizontal velocity as speed and course, each in whole units."""
    speed = truncated(hypot(north, east), CENTI)
    course = radians(truncated(degrees(atan2(east, north)) % 360.0, CENTI))
    return (speed * float(np.cos(course)), speed * float(np.sin(course)))
