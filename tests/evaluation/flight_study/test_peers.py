import numpy as np
import pytest

from attest_mav.algebra import q_heading, tilt_between
from attest_mav.earth_field import LocalField
from attest_mav.evaluation.flight_study.flying import recorded
from attest_mav.evaluation.flight_study.peers import CARRIER, PEERS, _steps, installed_peers, peer_flown, with_peer
from attest_mav.logs.source import Plan
from attest_mav.replay.engine import Recording
from attest_mav.samples import AttitudeSample
from attest_mav.vehicle_reports import ParameterSample
from attest_mav.vehicle_settings import Setting, VehicleSettings

AT_REST = Plan((1, 1), "RAW_IMU", "SIM_STATE", None, "RAW_IMU")


@pytest.mark.parametrize("name", PEERS)
def test_at_rest_a_peer_is_level_and_looks_to_true_north(stream, name):
    recording = Recording(AT_REST, LocalField(10.0, 60.0, "given"), VehicleSettings(), stream)
    samples = with_peer(recording, _steps(name, 50.0))
    carried = [sample for sample in samples if isinstance(sample, AttitudeSample) and sample.source == CARRIER]
    assert len(carried) == 500
    expected = q_heading(np.radians(10.0))
    assert np.degrees(tilt_between(carried[-1].q_nb, expected)) < 0.1
    assert abs(np.dot(carried[-1].q_nb, expected)) > np.cos(np.radians(0.1))


def test_no_trim_of_the_autopilot_is_taken_off_a_peers_attitude(stream):
    trim = ParameterSample("PARAM_VALUE", 1, 1, 0, "AHRS_TRIM_X", Setting.TRIM_X, 0.1)
    recording = Recording(AT_REST, None, VehicleSettings(), [trim, *stream])
    assert not [one for one in with_peer(recording, _steps("vqf", 50.0)) if isinstance(one, ParameterSample)]


def test_peers_are_compared_with_the_truth_of_the_log(plane):
    assert installed_peers() == list(PEERS)
    errors = peer_flown((plane, "vqf"))
    assert len(errors.t_s) == pytest.approx(len([s for s in recorded(plane).samples if s.source == "RAW_IMU"]), abs=10)
    # In a turn at 45 degrees of bank the accelerometer shows a level vehicle.
    assert 5.0 < np.nanmax(errors.tilt) < 60.0
