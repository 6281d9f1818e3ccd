"""Whole flights on virtual time: the fake autopilot's bytes through framer, decoder and pipeline, against its truth.

Each row is a disturbance and the limits that must hold. Figures are the worst after alignment, in degrees; the limits
are about 1.5 times what was measured (seed 1), except in the plane's turns, where the filters without a velocity
are known to fail and only the one with it has a limit.
"""

from math import inf

import pytest

from attest_mav.estimation.events import Agreement, LaneEventKind
from attest_mav.types import North

from .flying import fly


@pytest.mark.parametrize(
    ("personality", "scenario", "filter_name", "tilt_limit", "heading_limit"),
    [
        ("ardupilot", "still", "gradient-descent", 0.8, 1.6),
        ("px4", "still", "gradient-descent", 0.8, 1.6),
        ("ardupilot", "hover", "gradient-descent", 9.0, 7.0),
        ("ardupilot", "hover", "robust-adaptive", 2.5, 2.5),
        ("ardupilot", "hover", "leveling", 1.5, 2.0),
        ("ardupilot", "square", "gradient-descent", 14.0, 6.0),
        ("px4", "square", "robust-adaptive", 1.5, 2.0),
        ("ardupilot", "tumbling", "gradient-descent", 7.0, 4.0),
        ("ardupilot", "coordinated-turns", "leveling", 4.0, 4.0),
        ("ardupilot", "hover", "velocity-aided", 0.6, 1.2),
        ("px4", "square", "velocity-aided", 0.4, 1.5),
        ("ardupilot", "coordinated-turns", "velocity-aided", 0.6, 1.2),
    ],
)
def test_a_flight_without_faults(personality, scenario, filter_name, tilt_limit, heading_limit):
    flight = fly(
        40.0 if scenario == "coordinated-turns" else 25.0, filter_name, personality=personality, scenario=scenario
    )
    tilt, heading = flight.worst()
    assert tilt < tilt_limit
    assert heading < heading_limit
    assert flight.kinds() == [LaneEventKind.ALIGNED]
    assert flight.estimates[0].rx_ns < 2e9
    assert {e.north for e in flight.estimates} == {North.TRUE}
    assert flight.first_disagreement_s() == inf
    assert flight.verdicts[-1].agreement is Agreement.AGREE


def test_the_gradient_descent_filter_takes_a_long_turn_for_level_flight():
    # Not a limit but a fact to be known: in a coordinated turn its reference, the specific force, is along the body's
    # own down axis, so it slowly levels an attitude that is banked by 30 degrees.
    flight = fly(50.0, scenario="coordinated-turns")
    assert 15.0 < flight.worst(from_s=26.0)[0] < 35.0


@pytest.mark.parametrize(
    ("fault", "reason"),
    [("attitude-offset-north=20", "tilt"), ("attitude-offset-down=40", "heading")],
)
def test_a_jump_of_the_autopilots_attitude_is_told(fault, reason):
    flight = fly(16.0, faults=[f"{fault}@10"])
    assert 10.5 <= flight.first_disagreement_s() < 10.8  # held for 0.6 s first
    assert flight.verdicts[-1].agreement is Agreement.DISAGREE
    assert flight.verdicts[-1].reason == reason


def test_with_a_velocity_half_of_that_is_told():
    flight = fly(16.0, "velocity-aided", faults=["attitude-offset-north=5@10"])
    assert 10.5 <= flight.first_disagreement_s() < 10.8
    assert flight.verdicts[-1].reason == "tilt"


@pytest.mark.parametrize("scenario", ["coordinated-turns", "square"])
def test_without_one_an_honest_autopilot_is_not_accused(scenario):
    flight = fly(50.0, "velocity-aided", scenario=scenario, first_fix_s=1e6)
    assert flight.first_disagreement_s() == inf


@pytest.mark.parametrize("scenario", ["coordinated-turns", "square"])
def test_a_first_fix_in_flight_is_no_shock(scenario):
    flight = fly(50.0, "velocity-aided", scenario=scenario, first_fix_s=30.0)
    tilt, heading = flight.worst(from_s=31.0)
    assert tilt < 0.6
    assert heading < 1.2
    assert flight.kinds() == [LaneEventKind.ALIGNED]
    assert flight.first_disagreement_s() == inf


def test_a_frozen_attitude_is_told():
    flight = fly(20.0, scenario="tumbling", faults=["attitude-frozen@12"])
    assert 12.0 < flight.first_disagreement_s() < 12.7
    assert "frozen" in {v.reason for v in flight.verdicts if v.agreement is Agreement.DISAGREE}


def test_an_imu_that_stops_ends_the_estimates():
    flight = fly(12.0, faults=["imu-silent@10"])
    assert flight.kinds() == [LaneEventKind.ALIGNED, LaneEventKind.STOPPED]
    assert flight.estimates[-1].rx_ns == pytest.approx(9.98e9, abs=1)
    assert flight.lane_events[-1].rx_ns == pytest.approx(10.48e9, abs=2)
    assert flight.verdicts[-1].agreement is Agreement.UNDECIDED
    assert flight.verdicts[-1].reason == "no-estimate"


def test_a_short_gap_is_bridged_and_a_long_one_starts_again():
    short = fly(20.0, scenario="square", faults=["imu-silent@14+0.4"])
    assert short.kinds() == [LaneEventKind.ALIGNED, LaneEventKind.GAP]
    assert short.worst()[0] < 20.0
    # A vehicle at rest: what a restart in flight costs is the aligner's affair, and tested there.
    long = fly(12.0, scenario="still", faults=["imu-silent@5+3"])
    assert long.kinds()[:2] == [LaneEventKind.ALIGNED, LaneEventKind.STOPPED]
    assert long.kinds()[-2:] == [LaneEventKind.RESTARTED, LaneEventKind.ALIGNED]
    assert long.worst(from_s=8.0)[0] < 0.8


def test_a_reboot_restarts_alignment_on_the_new_clock():
    flight = fly(13.0, scenario="still", faults=["reboot@6"])
    assert flight.kinds() == [
        LaneEventKind.ALIGNED,
        LaneEventKind.STOPPED,
        LaneEventKind.REBOOTED,
        LaneEventKind.ALIGNED,
    ]
    after = [e for e in flight.estimates if e.rx_ns > 8e9]
    assert after[0].t_ns < 4e9
    flight.boot_ns = 6_000_000_000
    assert flight.worst(from_s=8.0)[0] < 0.8


def test_what_is_not_a_number_never_reaches_an_estimate():
    flight = fly(16.0, personality="px4", faults=["imu-nan@10+0.5"])
    assert not [e for e in flight.estimates if 10e9 <= e.rx_ns < 10.5e9]
    for estimate in flight.estimates:
        assert sum(c * c for c in estimate.q_nb) == pytest.approx(1.0, abs=1e-9)
    assert flight.worst()[0] < 9.0


def test_a_saturated_imu_is_not_believed():
    flight = fly(30.0, scenario="still", faults=["imu-saturated@8+0.2"])
    for estimate in flight.estimates:
        assert sum(c * c for c in estimate.q_nb) == pytest.approx(1.0, abs=1e-9)
    # A gyro at 35 rad/s for 0.2 s is seven radians that did not happen; afterwards gravity and field pull it back.
    assert flight.worst(from_s=28.0)[0] < 2.0


@pytest.mark.parametrize("scenario", ["coordinated-turns", "square"])
def test_after_saturation_in_flight_it_aligns_again_and_nobody_is_accused(scenario):
    """Seven radians that did not happen are not worked off row by row: the velocity gives a new attitude."""
    flight = fly(45.0, "velocity-aided", scenario=scenario, faults=["imu-saturated@30+0.3"])
    tilt, heading = flight.worst(from_s=35.0)
    assert tilt < 1.0
    assert heading < 2.0
    assert flight.kinds() == [LaneEventKind.ALIGNED, LaneEventKind.RESTARTED, LaneEventKind.ALIGNED]
    assert flight.first_disagreement_s() == inf
