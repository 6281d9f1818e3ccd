from pathlib import Path

import pytest

from attest_mav.samples import AttitudeSample, ImuSample, PositionSample, VelocitySample
from attest_mav.types import G_MPS2, AttitudeRole, Quantum, VehicleKind, VelocityOrigin
from attest_mav.vehicle_reports import HeartbeatSample

MS = 1_000_000
START_MS = 5000
"""The sensor's clock at the first sample; the host's runs 100 s ahead."""
AHEAD_MS = 100_000
AUTOPILOT = AttitudeRole.AUTOPILOT


def imu(t_ms, gyro=(0.0, 0.0, 0.0), accel=(0.0, 0.0, -9.80665), mag=(0.2, 0.0, 0.44)):
    quantum = Quantum(1e-3, 1e-3 * G_MPS2, 1e-3)
    return ImuSample("RAW_IMU", 1, 1, t_ms * MS, (t_ms + AHEAD_MS) * MS, gyro, accel, mag, quantum=quantum)


def fix(t_ms, v_ned=(10.0, 0.0, 0.0), stamp_ms=None):
    return VelocitySample(
        "GPS_RAW_INT", 1, 1, (stamp_ms or t_ms) * MS, (t_ms + AHEAD_MS) * MS, v_ned, False, VelocityOrigin.RECEIVER
    )


def place(t_ms):
    return PositionSample("GPS_RAW_INT", 1, 1, t_ms * MS, (t_ms + AHEAD_MS) * MS, 51.0, 0.0, 100.0)


def attitude(t_ms):
    return AttitudeSample("ATTITUDE", 1, 1, t_ms * MS, (t_ms + AHEAD_MS) * MS, (1.0, 0.0, 0.0, 0.0), None, AUTOPILOT)


def heartbeat(t_ms):
    return HeartbeatSample("HEARTBEAT", 1, 1, (t_ms + AHEAD_MS) * MS, 1, 3, True, 4, VehicleKind.WING)


@pytest.fixture(scope="session")
def stream():
    """Ten seconds: inertial samples at 50 Hz, attitudes at 10, fixes with positions at 5, heartbeats at 1."""
    samples = []
    for k in range(500):
        t_ms = START_MS + 20 * k
        samples.append(imu(t_ms))
        if k % 5 == 0:
            samples.append(attitude(t_ms))
        if k % 10 == 0:
            samples += [fix(t_ms), place(t_ms)]
        if k % 50 == 0:
            samples.append(heartbeat(t_ms))
    return samples


@pytest.fixture(scope="session")
def data():
    """Folder of pieces of the shared simulator flights."""
    return Path(__file__).parent.parent.parent / "data"


@pytest.fixture(scope="session")
def plane(data):
    """40 s of circles: RAW_IMU at 50 Hz, SIM_STATE and GPS_RAW_INT at 10, a new fix at 5."""
    return (data / "plane_circles_gps.tlog").read_bytes()
