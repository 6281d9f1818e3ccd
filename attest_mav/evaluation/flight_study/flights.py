"""Turns and airborne times of a recorded flight, by its true attitude and velocity."""

from collections.abc import Iterator
from math import acos, degrees, hypot
from typing import Final

import numpy as np

from attest_mav.algebra import clamp, down_in_body
from attest_mav.evaluation.flight_study.edits import clocked
from attest_mav.evaluation.flight_study.flying import Column
from attest_mav.replay.engine import Recording
from attest_mav.samples import AttitudeSample, ImuSample, VelocitySample
from attest_mav.types import Quat
from attest_mav.vehicle_reports import HeartbeatSample

AEROPLANE: Final = 1
"""MAV_TYPE."""
VTOL: Final = (19, 20, 21, 22, 23, 24, 25)
"""MAV_TYPE of all VTOL kinds."""
MOVING: Final = 2.0
"""m/s over ground: what goes this fast has left the ground."""
FAST_HZ: Final = 20.0
"""From this rate on the motion between samples is small: what is required of fast logs can be met."""
LEARNT_S: Final = 60.0
"""No disturbance begins sooner: the filter has learnt its biases by then."""


def turn_tilt_deg(recording: Recording) -> float:
    """From which tilt on this vehicle is in a turn: 20 degrees for a plane, 10 for a VTOL, 8 for a copter."""
    types = [sample.vehicle_type for sample in recording.samples if isinstance(sample, HeartbeatSample)]
    vehicle = types[-1] if types else 0
    return 20.0 if vehicle == AEROPLANE else 10.0 if vehicle in VTOL else 8.0


def turning_times(recording: Recording, tilt_deg: float, before_s: float) -> Column:
    """Times of the attitudes of the reference that are tilted by more, s; those in the last ``before_s`` left out."""
    end_s = last_time(recording) - before_s
    return np.array([now_s for now_s, q_nb in _truths(recording) if now_s < end_s and tilt_of(q_nb) > tilt_deg])


def evenly(times: Column, count: int) -> list[float]:
    """So many of the times, evenly spread over them; all when there are fewer."""
    if len(times) <= count:
        return [float(now_s) for now_s in times]
    places = (np.arange(count) + 0.5) * len(times) / count
    return [float(times[int(place)]) for place in places]


def flying_interval(recording: Recording) -> tuple[float, float]:
    """First and last time at which the vehicle went fast over ground, s; (0, 0) if it never did."""
    times = [
        now_s
        for now_s, sample in clocked(recording.samples, recording.plan.imu)
        if isinstance(sample, VelocitySample) and hypot(*sample.v_ned) > MOVING
    ]
    return (times[0], times[-1]) if times else (0.0, 0.0)


def last_time(recording: Recording) -> float:
    """Time of the last inertial sample, s."""
    return max((now_s for now_s, _ in clocked(recording.samples, recording.plan.imu)), default=0.0)


def rate_hz(recording: Recording) -> float:
    """Usual rate of the inertial message, Hz; 0 when there are fewer than two samples."""
    stamps = np.array(
        [
            sample.t_ns
            for sample in recording.samples
            if isinstance(sample, ImuSample) and sample.source == recording.plan.imu
        ]
    )
    return float(1e9 / np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0


def is_fast(recording: Recording) -> bool:
    """Whether the limits for usual rates hold."""
    return rate_hz(recording) >= FAST_HZ


def tilt_of(q_nb: Quat) -> float:
    """Angle between the body's down and the vertical, degrees."""
    return degrees(acos(clamp(down_in_body(q_nb)[2], -1.0, 1.0)))


def _truths(recording: Recording) -> Iterator[tuple[float, Quat]]:
    """The reference's attitudes, each with the time of the inertial sample before it, s."""
    for now_s, sample in clocked(recording.samples, recording.plan.imu):
        if isinstance(sample, AttitudeSample) and sample.source == recording.plan.reference:
            yield now_s, sample.q_nb
