"""Faults put into the samples of a clean flight: every edit is a function of samples, samples in, samples out.

Readings of integer messages stay whole counts. A fault's change is made anew for each flight, since some of them
remember what came before.
"""

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from math import inf
from typing import Final

import numpy as np

from attest_mav.algebra import add, scale
from attest_mav.evaluation.flight_study.edits import restored, truncated
from attest_mav.samples import ImuSample, PositionSample, Sample, VelocitySample
from attest_mav.types import Vec3

Change = Callable[[Sample], Sample | None]
"""The sample that comes in place of this one while the fault lasts; None where none comes."""

STUCK_ACCEL: Final = (5.0, 5.0, 5.0)
"""m/s^2: an accelerometer that is stuck, as ArduPilot's simulator makes it."""


def faulted(samples: Iterable[Sample], from_s: float, to_s: float, change: Change) -> list[Sample]:
    """The samples with a fault between two instants of the inertial sensors' clock."""
    kept: list[Sample] = []
    now_s = -inf
    for sample in samples:
        if isinstance(sample, ImuSample):
            now_s = sample.t_ns * 1e-9
        changed = change(sample) if from_s <= now_s < to_s else sample
        if changed is not None:
            kept.append(changed)
    return kept


def gyro_step(lanes: Sequence[str], rate: Vec3) -> Change:
    """The gyros of these streams are off by a constant, rad/s."""
    return _of_sensors(lanes, lambda sample: _with(sample, add(_gyro(sample), rate), sample.accel))


def gyro_scale(lanes: Sequence[str], factor: float) -> Change:
    """The gyros of these streams read so many times the rate; 0 reads nothing."""
    return _of_sensors(lanes, lambda sample: _with(sample, scale(_gyro(sample), factor), sample.accel))


def accel_step(lanes: Sequence[str], force: Vec3) -> Change:
    """The accelerometers of these streams are off by a constant, m/s^2."""
    return _of_sensors(lanes, lambda sample: _with(sample, sample.gyro, add(_accel(sample), force)))


def accel_scale(lanes: Sequence[str], factor: float) -> Change:
    """The accelerometers of these streams read so many times the specific force."""
    return _of_sensors(lanes, lambda sample: _with(sample, sample.gyro, scale(_accel(sample), factor)))


def accel_stuck(lanes: Sequence[str]) -> Change:
    """The accelerometers of these streams show one value on all axes."""
    return _of_sensors(lanes, lambda sample: _with(sample, sample.gyro, STUCK_ACCEL))


def frozen(lanes: Sequence[str]) -> Change:
    """Gyro and accelerometer of these streams repeat their first readings; the magnetometer is another device."""
    first: dict[str, ImuSample] = {}

    def repeat(sample: ImuSample) -> ImuSample:
        held = first.setdefault(sample.source, sample)
        return sample.with_readings(held.gyro, held.accel, sample.mag)

    return _of_sensors(lanes, repeat)


def compass_offset(field: Vec3) -> Change:
    """All magnetometers are off by a constant of the body, gauss."""

    def offset(sample: Sample) -> Sample:
        if not isinstance(sample, ImuSample) or sample.mag is None:
            return sample
        unit = sample.quantum.mag
        mag = _counts(add(_restored(sample.mag, unit), field), unit)
        return sample.with_readings(sample.gyro, sample.accel, mag)

    return offset


def receiver_offset(velocity: Vec3) -> Change:
    """The receiver's velocity is off by a constant, m/s."""
    return _of_receiver(lambda fix: fix.with_velocity(add(fix.v_ned, velocity)))


def receiver_ramp(acceleration: Vec3) -> Change:
    """The receiver's velocity is off by more and more, m/s^2."""
    begun: list[int] = []

    def ramp(fix: VelocitySample) -> VelocitySample:
        begun.append(fix.t_ns)
        return fix.with_velocity(add(fix.v_ned, scale(acceleration, (fix.t_ns - begun[0]) * 1e-9)))

    return _of_receiver(ramp)


def receiver_late(delay_s: float) -> Change:
    """The receiver's velocity is so much older than its time stamp says."""
    past: deque[VelocitySample] = deque()

    def late(fix: VelocitySample) -> VelocitySample:
        past.append(fix)
        while len(past) > 1 and fix.t_ns - past[1].t_ns >= int(1e9 * delay_s):
            past.popleft()
        return fix.with_velocity(past[0].v_ned)

    return _of_receiver(late)


def receiver_frozen() -> Change:
    """The receiver repeats its velocity under new time stamps."""
    first: list[Vec3] = []

    def repeat(fix: VelocitySample) -> VelocitySample:
        first.append(fix.v_ned)
        return fix.with_velocity(first[0])

    return _of_receiver(repeat)


def receiver_noise(sigma: float, seed: int = 1) -> Change:
    """The receiver's horizontal velocity is off by white noise, m/s an axis."""
    draw = partial(np.random.default_rng(seed).normal, 0.0, sigma)
    return _of_receiver(lambda fix: fix.with_velocity(add(fix.v_ned, (float(draw()), float(draw()), 0.0))))


def receiver_off() -> Change:
    """The receiver is silent."""
    return lambda sample: None if isinstance(sample, (VelocitySample, PositionSample)) else sample


def _of_sensors(lanes: Sequence[str], change: Callable[[ImuSample], ImuSample]) -> Change:
    return lambda sample: change(sample) if isinstance(sample, ImuSample) and sample.source in lanes else sample


def _of_receiver(change: Callable[[VelocitySample], VelocitySample]) -> Change:
    return lambda sample: change(sample) if isinstance(sample, VelocitySample) else sample


def _with(sample: ImuSample, gyro: Vec3, accel: Vec3) -> ImuSample:
    """The sample with these readings in whole counts."""
    quantum = sample.quantum
    return sample.with_readings(_counts(gyro, quantum.gyro), _counts(accel, quantum.accel), sample.mag)


def _gyro(sample: ImuSample) -> Vec3:
    return _restored(sample.gyro, sample.quantum.gyro)


def _accel(sample: ImuSample) -> Vec3:
    return _restored(sample.accel, sample.quantum.accel)


def _restored(v: Vec3, unit: float) -> Vec3:
    if unit <= 0.0:
        return v
    return (restored(v[0], unit), restored(v[1], unit), restored(v[2], unit))


def _counts(v: Vec3, unit: float) -> Vec3:
    if unit <= 0.0:
        return v
    return (truncated(v[0], unit), truncated(v[1], unit), truncated(v[2], unit))
