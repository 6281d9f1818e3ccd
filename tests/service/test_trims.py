"""Vehicles whose autopilot reports its attitude turned by a trim: the daemon on virtual time.

A trim is no fault, and hides none.
"""

from math import radians

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.estimation.events import Agreement
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings

AGREE, DISAGREE, UNDECIDED = Agreement.AGREE, Agreement.DISAGREE, Agreement.UNDECIDED
PARAM_VALUE = mavlink.MAVLINK_MSG_ID_PARAM_VALUE


def trimmed(trim_deg, scenario="hover", faults=(), **settings):
    trim = (radians(trim_deg), 0.5 * radians(trim_deg), 0.0)
    return SimSettings(scenario=scenario, fast_rate_hz=50.0, trim=trim, faults=parse_faults(faults), **settings)


def verdicts(f, until_s):
    """The verdict's agreement and reason, five times a second from now on."""
    said = []
    while f.now_ns < until_s * 1e9:
        f.run_until(f.now_ns * 1e-9 + 0.2)
        standing = f.snapshot().verdict
        if standing is not None:
            said.append((standing.verdict.agreement, standing.verdict.reason))
    return said


def agreements(f, until_s):
    return {agreement for agreement, _ in verdicts(f, until_s)}


@pytest.mark.parametrize("scenario", ["still", "hover", "coordinated-turns"])
@pytest.mark.parametrize("trim_deg", [0.0, 2.0, 4.0, 8.0])
def test_a_healthy_vehicle_with_a_trim_agrees(flight, scenario, trim_deg):
    f = flight("", trimmed(trim_deg, scenario))
    assert DISAGREE not in agreements(f, 15.0)
    assert agreements(f, 40.0) == {AGREE}
    assert mavlink.MAV_STATE_CRITICAL not in f.states()


@pytest.mark.parametrize("trim_deg", [0.0, 4.0, -8.0])
@pytest.mark.parametrize("from_s", [0.0, 20.0])
def test_a_fault_beside_a_trim_is_found(flight, trim_deg, from_s):
    f = flight("", trimmed(trim_deg, faults=[f"attitude-offset-north=5@{from_s}"]))
    assert (DISAGREE in agreements(f, 19.9)) == (from_s == 0.0)
    assert verdicts(f, 26.0)[-1] == (DISAGREE, "tilt")


def test_a_trim_that_is_set_in_flight_is_taken_off_and_not_vouched_for(flight):
    f = flight("", trimmed(0.0))
    verdicts(f, 20.0)
    assert f.snapshot().frame_notes == ()
    station = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    for name, angle_deg in ((b"AHRS_TRIM_X", 6.0), (b"AHRS_TRIM_Y", -3.0)):
        change = mavlink.MAVLink_param_set_message(1, 1, name, radians(angle_deg), mavlink.MAV_PARAM_TYPE_REAL32)
        f.vehicle.handle(change.pack(station), f.now_ns)
    assert DISAGREE not in agreements(f, 30.0)
    assert f.snapshot().verdict.verdict.reason == "offset"
    assert f.snapshot().frame_notes == ("AHRS_TRIM 6.0, -3.0 deg taken off ATTITUDE",)


def test_the_trim_is_read_again_after_a_reboot(flight):
    f = flight("", trimmed(4.0, "still", faults=["reboot@15"]))
    assert DISAGREE not in agreements(f, 30.0)
    assert agreements(f, 40.0) == {AGREE}
    read = [one.param_id for one in f.of_type("PARAM_REQUEST_READ", 15.0)]
    assert {"AHRS_TRIM_X", "AHRS_TRIM_Y", "AHRS_TRIM_Z"} <= set(read)


def test_a_trim_that_cannot_be_read_is_named_as_an_offset(flight):
    f = flight("", trimmed(4.0))
    f.deaf_to = {PARAM_VALUE}
    said = verdicts(f, 30.0)
    assert DISAGREE not in {agreement for agreement, _ in said}
    assert said[-1] == (UNDECIDED, "offset")
    f.run_until(70.0)
    assert (
        "the autopilot does not tell its trim (AHRS_TRIM_X): a steady offset of its attitude is measured instead"
        in (f.texts)
    )


def test_the_trim_stands_in_the_status_and_once_in_the_log(flight):
    f = flight("", trimmed(4.0))
    f.run_until(15.0)
    text = "AHRS_TRIM 4.0, 2.0 deg taken off ATTITUDE"
    assert text in f.status()
    assert f.texts.count(text) == 1


def test_the_firmware_is_asked_for_and_decides(flight):
    f = flight("", trimmed(4.0))
    f.run_until(5.0)
    commands = [one for one in f.of_type("COMMAND_LONG") if one.command == mavlink.MAV_CMD_REQUEST_MESSAGE]
    assert [one.param1 for one in commands] == [mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION]
    assert f.snapshot().vehicle.firmware == (4, 6, 0)
