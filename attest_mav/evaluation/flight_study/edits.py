"""Edits of a recording before it is flown: every edit is a pure function, samples in, samples out.

``imu`` names the inertial message in use. Times are seconds from its first sample, on the sensor's clock; samples
without a time of their own belong to the last inertial sample before them. Readings are taken for those of an integer
message (RAW_IMU, SCALED_IMU).
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from math import floor, inf, trunc
from typing import Final

from attest_mav.mavlink.decode.units import MILLI
from attest_mav.replay.log_time import LogTime
from attest_mav.samples import AirDataSample, AttitudeSample, ImuSample, PositionSample, Sample, VelocitySample

Edit = Callable[[Sequence[Sample], str], list[Sample]]
"""Samples and the name of the inertial message in, samples out."""

TRUTH_LEAD_S: Final = 1.0
"""Attitudes from so long before a cut are kept: the first sample behind it must have something to compare with."""


def clocked(samples: Sequence[Sample], imu: str) -> Iterator[tuple[float, Sample]]:
    """Each sample with the time, s; that of the first inertial sample (0) before there is one."""
    time = LogTime()
    now_s = 0.0
    for sample in samples:
        if isinstance(sample, ImuSample) and sample.source == imu:
            now_s = time.advance(sample.t_ns)
        yield now_s, sample


def between(samples: Sequence[Sample], imu: str, *, from_s: float, to_s: float) -> list[Sample]:
    """The samples that arrive between two times: a listener begins at the first one and knows nothing from before."""
    kept: list[Sample] = []
    for now_s, sample in clocked(samples, imu):
        lead_s = TRUTH_LEAD_S if isinstance(sample, AttitudeSample) else 0.0
        if now_s > to_s:
            break
        if now_s >= from_s - lead_s:
            kept.append(sample)
    return kept


WHOLE: Final = partial(between, from_s=0.0, to_s=inf)
"""The recording as it is."""


def without_velocity(
    samples: Sequence[Sample], imu: str, *, from_s: float, to_s: float, airspeed: bool = True
) -> list[Sample]:
    """The GPS receiver is silent between the times; without ``airspeed``, VFR_HUD is too."""
    lost = (VelocitySample, PositionSample) if airspeed else (VelocitySample, PositionSample, AirDataSample)
    return [
        sample for now_s, sample in clocked(samples, imu) if not (isinstance(sample, lost) and from_s <= now_s < to_s)
    ]


def decimated(samples: Sequence[Sample], imu: str, *, rate_hz: float) -> list[Sample]:
    """The inertial message at a lower rate: the sample nearest to each due time, with its own time and readings."""
    kept: list[Sample] = []
    due_s = last_s = 0.0
    for now_s, sample in clocked(samples, imu):
        if isinstance(sample, ImuSample) and sample.source == imu:
            # Half a step: the next sample would be further from the due time.
            is_due = now_s + 0.5 * (now_s - last_s) >= due_s
            last_s = now_s
            if not is_due:
                continue
            due_s += (floor(max(0.0, now_s - due_s) * rate_hz) + 1.0) / rate_hz
        kept.append(sample)
    return kept


def with_iron(samples: Sequence[Sample], imu: str, *, from_s: float, to_s: float, gauss: float) -> list[Sample]:
    """A field that turns with the vehicle is added to the magnetometer's x axis between the times."""
    return [
        _with_field(sample, gauss) if from_s <= now_s < to_s and _has_field(sample, imu) else sample
        for now_s, sample in clocked(samples, imu)
    ]


def _has_field(sample: Sample, imu: str) -> bool:
    return isinstance(sample, ImuSample) and sample.source == imu and sample.mag is not None


def _with_field(sample: Sample, gauss: float) -> Sample:
    if not isinstance(sample, ImuSample) or sample.mag is None:
        return sample
    x, y, z = sample.mag
    return sample.with_readings(sample.gyro, sample.accel, (truncated(restored(x, MILLI) + gauss, MILLI), y, z))


def truncated(value: float, unit: float) -> float:
    """The value as an integer message carries it: whole units, cut off toward zero."""
    return trunc(value / unit) * unit


def restored(value: float, unit: float) -> float:
    """The middle of what was cut off to this value. Zero stays zero: it stands for both sides of it."""
    if value == 0.0:
        return value
    return value + (0.5 * unit if value > 0.0 else -0.5 * unit)
