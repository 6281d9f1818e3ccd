"""Other people's filters over the same samples, for the same table: VQF and Fusion (the packages vqf and imufusion).

They run with their defaults, Fusion with a gain of 0.1, at the usual rate of the log; neither takes a time step. Their
attitudes are put among the samples as ATTITUDE_QUATERNION, so that they are compared as the autopilot's own is.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from math import sqrt
from typing import Any, Final

import numpy as np

from attest_mav.algebra import q_heading, q_mul
from attest_mav.evaluation.flight_study.flights import rate_hz
from attest_mav.evaluation.flight_study.flying import Chosen, Errors, fly, recorded
from attest_mav.replay.engine import Recording
from attest_mav.replay.request import Window
from attest_mav.samples import AttitudeSample, ImuSample, Sample
from attest_mav.types import G_MPS2, AttitudeForm, AttitudeRole, Quat
from attest_mav.vehicle_reports import ParameterSample

PEERS: Final = ("vqf", "imufusion")
CARRIER: Final = "ATTITUDE_QUATERNION"
FUSION_GAIN: Final = 0.1

Step = Callable[[ImuSample], Quat]
"""The attitude after a sample, body to NED with magnetic north."""


def installed_peers() -> list[str]:
    """Those that can be imported."""
    return [name for name in PEERS if find_spec(name) is not None]


def peer_flown(task: tuple[bytes, str]) -> Errors:
    """Errors of the peer of that name over a log, after 30 s as those of all others."""
    log, name = task
    recording = recorded(log)
    plan = replace(recording.plan, autopilot=CARRIER)
    carrying = Recording(plan, recording.earth_field, recording.settings, recording.samples)
    samples = with_peer(recording, _steps(name, rate_hz(recording)))
    # The filter beside it only says from when on errors count.
    return fly(carrying, samples, Chosen("gradient-descent").build(), Window()).autopilot


def with_peer(recording: Recording, step: Step) -> list[Sample]:
    """The samples with the peer's attitude behind each inertial one, referred to true north where that is known."""
    turn = q_heading(0.0 if recording.earth_field is None else recording.earth_field.direction.declination)
    out: list[Sample] = []
    last_ns = -1
    for sample in _without_carrier(recording.samples):
        out.append(sample)
        if isinstance(sample, ImuSample) and sample.source == recording.plan.imu and sample.t_ns != last_ns:
            last_ns = sample.t_ns
            q_nb = q_mul(turn, step(sample))
            out.append(
                AttitudeSample(
                    CARRIER,
                    sample.system,
                    sample.component,
                    sample.t_ns,
                    sample.rx_ns,
                    q_nb,
                    None,
                    AttitudeRole.AUTOPILOT,
                    AttitudeForm.QUATERNION,
                )
            )
    return out


def _without_carrier(samples: Sequence[Sample]) -> list[Sample]:
    """The samples that stay. A peer's attitude is that of the IMU: no parameter may take a trim off it."""
    return [one for one in samples if one.source != CARRIER and not isinstance(one, ParameterSample)]


def _steps(name: str, rate: float) -> Step:
    """The step of a peer."""
    return _vqf(import_module("vqf"), rate) if name == "vqf" else _fusion(import_module("imufusion"), rate)


def _vqf(package: Any, rate: float) -> Step:
    """VQF gives the attitude in ENU."""
    other = package.VQF(1.0 / rate)
    ned_of_enu = (0.0, sqrt(0.5), sqrt(0.5), 0.0)

    def step(sample: ImuSample) -> Quat:
        readings = [np.array(sample.gyro), np.array(sample.accel)]
        other.update(*readings, *([] if sample.mag is None else [np.array(sample.mag)]))
        w, x, y, z = (float(part) for part in other.getQuat9D())
        return q_mul(ned_of_enu, (w, x, y, z))

    return step


def _fusion(package: Any, rate: float) -> Step:
    """In its NED convention Fusion takes the accelerometer at rest for +g along down."""
    other = package.Ahrs()
    other.set_settings(package.AhrsSettings(rate, package.CONVENTION_NED, FUSION_GAIN, 2000.0, 0.0, 0.0, 0.0))

    def step(sample: ImuSample) -> Quat:
        gyro, accel = np.degrees(sample.gyro), -np.array(sample.accel) / G_MPS2
        if sample.mag is None:
            other.update_no_magnetometer(gyro, accel)
        else:
            other.update(gyro, accel, np.array(sample.mag))
        w, x, y, z = (float(part) for part in other.get_quaternion())
        return (w, x, y, z)

    return step
