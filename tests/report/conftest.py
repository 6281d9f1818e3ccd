"""Recordings and reports without a log behind them."""

import pytest

from attest_mav.estimate import Estimate
from attest_mav.innovation import Aid, Fusion, Innovation
from attest_mav.replay.comparison import Attitude, ComparedAttitude
from attest_mav.report.recorder import FlightRecorder
from attest_mav.samples import ImuSample
from attest_mav.types import EarthField, North

FILTER = "velocity-aided"
LEVEL = (1.0, 0.0, 0.0, 0.0)


def imu(k, accel=(0.0, 0.0, -9.8), lane="RAW_IMU", saturated=False):
    """The sample of log time 0.02 k, s."""
    t_ns = 1_000_000_000 + 20_000_000 * k
    return ImuSample(lane, 1, 1, t_ns, t_ns, (0.03, 0.02, 0.01), accel, (0.3, 0.0, 0.4), saturated)


@pytest.fixture
def recorder():
    """Twelve seconds of a level vehicle with a gyro bias of 0.01 rad/s about x."""
    made = FlightRecorder()
    made.begin(EarthField(0.0, 0.9))
    for k in range(600):
        sample, t_s = imu(k, saturated=k in (55, 60)), 0.02 * k
        made.imu(sample, t_s)
        estimate = Estimate(
            "RAW_IMU",
            FILTER,
            sample.t_ns,
            sample.rx_ns,
            LEVEL,
            (0.02, 0.02, 0.01),
            North.TRUE,
            1,
            1,
            0.02,
            accel_bias=(0.05, 0.0, -0.1),
        )
        made.estimate(FILTER, estimate, sample)
        innovations = (Innovation(Aid.VELOCITY, Fusion.USED, 0, (0.0, 0.0), (0.2, -0.4), (0.04, 0.04)),)
        attitude = Attitude(sample.t_ns, t_s, LEVEL, North.TRUE, 0.01, 0.02, True, innovations)
        made.write(ComparedAttitude(FILTER, attitude, 0.01, -0.02))
        made.reference(LEVEL, t_s)
    made.finish()
    return made


@pytest.fixture
def report():
    """A report with one disagreement."""
    interval = {
        "state": "disagree",
        "reason": "tilt",
        "start_s": 3.0,
        "end_s": 5.0,
        "peak_tilt_deg": 12.0,
        "peak_heading_deg": None,
        "sensors": ["RAW_IMU used"],
        "autopilot_reports": [],
    }
    error = {"rms": 1.0, "p95": 2.0, "max": 3.0}
    error |= {"max_at_s": 7.2, "max_at_unix_s": 1_700_000_007.4, "max_phase": "climb"}
    fault = {"kind": "frozen", "text": "repeats one reading", "start_s": 4.0, "end_s": None}
    return {
        "log": "flight.tlog",
        "format": "tlog",
        "frames": 10,
        "bad_bytes": 0,
        "duration_s": 12.0,
        "vehicle": {"system": 1, "component": 1},
        "imu": {"message": "RAW_IMU", "samples": 600, "rate_hz": 50.0, "gaps": 0},
        "lanes": [{"message": "RAW_IMU", "samples": 600, "rate_hz": 50.0, "gaps": 0, "faults": [fault]}],
        "north": {"reference": "true", "declination_deg": 1.0, "source": "a table"},
        "window": {"start_s": 0.0, "end_s": None, "skip_s": 30.0},
        "reference": {"message": "SIM_STATE", "samples": 600, "sigma": None},
        "smoothed": None,
        "filters": [{"name": FILTER, "samples": 600, "tilt_deg": error, "heading_deg": None, "consistency": None}],
        "autopilot": None,
        "verdict": {
            "filter": FILTER,
            "thresholds": {"tilt_deg": 10.0, "proven_tilt_deg": 3.0, "hold_s": 0.6},
            "agree_s": 0.0,
            "disagree_s": 2.0,
            "undecided_s": 0.0,
            "intervals": [interval],
        },
        "notes": [],
    }
