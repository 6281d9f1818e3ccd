"""Recorded simulator flights, against a naive twin of the comparison and against figures established elsewhere."""

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as dialect_of_pymavlink

from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window


def report(data, dialect, **options):
    request = Request((GradientDescent(),), **options)
    return as_json("flight", replay(TlogSource(data, dialect), request, Outputs()))


def matrices(messages):
    """Body to NED, from roll, pitch and yaw."""
    roll, pitch, yaw = (np.array([getattr(message, name) for message in messages]) for name in ("roll", "pitch", "yaw"))
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(angle), np.sin(angle)) for angle in (roll, pitch, yaw))
    rows = [
        [cp * cy, sr * sp * cy - cr * sy, cr * sp * cy + sr * sy],
        [cp * sy, sr * sp * sy + cr * cy, cr * sp * sy - sr * cy],
        [-sp, sr * cp, cr * cp],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def naive_errors(data):
    """Tilt and heading errors (degrees) of every ATTITUDE against the SIM_STATE that follows it, with pymavlink."""
    parser = dialect_of_pymavlink.MAVLink(None)
    parser.robust_parsing = True
    attitudes, truths = [], []
    offset = 0
    while offset < len(data):
        # Records of MAVLink 2 without signature: 8 bytes of time, 10 of header, payload, 2 of checksum.
        length = 8 + 12 + data[offset + 9]
        message = parser.decode(bytearray(data[offset + 8 : offset + length]))
        offset += length
        if message.get_type() == "ATTITUDE":
            attitudes.append(message)
        elif message.get_type() == "SIM_STATE":
            truths.append(message)
    ours, truth = matrices(attitudes), matrices(truths)
    tilt = np.degrees(np.arccos(np.clip(np.sum(ours[:, 2] * truth[:, 2], axis=1), -1.0, 1.0)))
    turn = ours @ truth.transpose(0, 2, 1)
    heading = np.degrees(np.arctan2(turn[:, 1, 0] - turn[:, 0, 1], turn[:, 0, 0] + turn[:, 1, 1]))
    times = np.array([message.time_boot_ms for message in attitudes])
    return times, tilt, heading


@pytest.mark.parametrize("name", ["copter_square_laps", "plane_circles_turn"])
def test_the_autopilots_figures_equal_those_of_a_naive_twin(cuts, dialect, name):
    data = (cuts / f"{name}.tlog").read_bytes()
    times, tilt, heading = naive_errors(data)
    result = report(data, dialect, window=Window(skip_s=5.0))
    own = result["autopilot"]
    chosen = slice(len(times) - own["samples"], None)
    assert own["samples"] > 600
    for figures, errors in ((own["tilt_deg"], tilt[chosen]), (own["heading_deg"], np.abs(heading[chosen]))):
        assert figures["rms"] == pytest.approx(np.sqrt(np.mean(errors**2)), abs=1e-4)
        assert figures["p95"] == pytest.approx(np.percentile(errors, 95), abs=1e-3)
        assert figures["max"] == pytest.approx(np.max(errors), abs=1e-3)


@pytest.mark.parametrize(
    ("name", "frames", "samples", "own", "ours"),
    [
        # frames: pymavlink's count. own, ours: tilt and heading rms of the study of these flights, in degrees.
        ("sitl/copter_square.tlog", 158_210, 15_580, (0.145, 0.28), (5.3, 4.3)),
        ("sitl/plane_circles.tlog", 185_668, 17_792, (0.26, 0.69), (11.0, 14.0)),
    ],
)
def test_whole_flights_show_the_known_errors(data_folder, dialect, name, frames, samples, own, ours):
    path = data_folder / name
    if not path.is_file():
        pytest.skip(f"{path} is not there")
    result = report(path.read_bytes(), dialect)
    assert (result["frames"], result["bad_bytes"]) == (frames, 0)
    assert result["imu"]["samples"] == samples
    assert result["reference"]["message"] == "SIM_STATE"
    assert result["autopilot"]["tilt_deg"]["rms"] == pytest.approx(own[0], abs=0.005)
    assert result["autopilot"]["heading_deg"]["rms"] == pytest.approx(own[1], abs=0.005)
    assert result["filters"][0]["tilt_deg"]["rms"] == pytest.approx(ours[0], rel=0.05)
    assert result["filters"][0]["heading_deg"]["rms"] == pytest.approx(ours[1], rel=0.05)


def test_an_autopilot_that_flies_on_the_truth_is_recognised(data_folder, dialect):
    path = data_folder / "public/vtol_4hz.tlog"
    if not path.is_file():
        pytest.skip(f"{path} is not there")
    data = path.read_bytes()
    result = report(data, dialect)
    assert result["frames"] == 23_894
    assert result["reference"] == {"message": "SIMSTATE", "samples": 889, "sigma": None}
    assert result["autopilot"]["tilt_deg"]["p95"] == 0.0
    assert any("simulator's truth" in note for note in result["notes"])
    # Its second estimator is not: the figures of AHRS2 against the truth are known.
    swapped = report(data, dialect, reference="AHRS2")
    assert swapped["autopilot"]["tilt_deg"]["rms"] == pytest.approx(0.38, abs=0.03)
    assert swapped["autopilot"]["heading_deg"]["rms"] == pytest.approx(0.84, abs=0.08)
