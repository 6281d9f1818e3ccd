"""Sensor errors that a flight has shown outlast a restart of the service."""

import pytest

from attest_mav.config.parsing import parse_config
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.service.kept_state import KeptState, parse_state, state_text
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings

from .conftest import Flight

NOW_NS = 1_790_000_000 * 10**9
MONTH_NS = 30 * 86400 * 10**9
LINK = "[[link]]\nurl = 'udpin::0'\n"
SQUARE = SimSettings(scenario="square")
BEGINS = "begins with the accelerometer bias and hard iron of earlier flights"


def said(flight, text):
    return [note.text for note in flight.notes if text in note.text]


@pytest.fixture(scope="module")
def flown(dialect):
    """The first flight of 45 s; then the autopilot reboots."""
    first = Flight(
        dialect, parse_config(LINK, "test"), SimSettings(scenario="square", faults=parse_faults(["reboot@46"]))
    )
    first.service.persistence.restore(KeptState(), NOW_NS, 0)
    first.run_until(45.0)
    assert not said(first, BEGINS)
    return first


@pytest.fixture(scope="module")
def kept(flown):
    """The state after the first flight."""
    return parse_state(state_text(flown.service.persistence.state))


def test_the_next_start_begins_with_what_the_last_flight_has_shown(flight, kept):
    assert kept.calibrations.keys() == {"1/RAW_IMU", "1/SCALED_IMU2"}
    assert kept.calibrations["1/RAW_IMU"].learned_unix_s == NOW_NS * 1e-9
    second = flight("", SQUARE)
    second.service.persistence.restore(kept, NOW_NS + MONTH_NS, 0)
    second.run_until(15.0)
    assert said(second, BEGINS) == [f"RAW_IMU: {BEGINS}", f"SCALED_IMU2: {BEGINS}"]
    assert second.service.persistence.state.calibrations == kept.calibrations, "it has not moved yet"


def test_what_was_learned_holds_for_its_sensors_alone(flight, kept):
    known = kept.calibrations["1/RAW_IMU"]
    assert (known.accelerometer.device, known.magnetometer.device) == (2753028, 2753029)
    assert kept.calibrations["1/SCALED_IMU2"].accelerometer.device == 2753030
    second = flight("", SQUARE)
    table = second.vehicle.commands.parameters
    table.set(table.index_of("INS_ACC_ID"), 3000000.0)
    second.service.persistence.restore(kept, NOW_NS, 0)
    second.run_until(10.0)
    told = "INS_ACC_ID is 3000000 instead of 2753028: the accelerometer bias of before counts as unknown"
    assert said(second, "instead of") == [f"RAW_IMU: {told}"]
    assert second.service.persistence.state.calibrations == kept.calibrations, "the sensor may come back"


def test_a_stranger_who_tells_of_another_sensor_is_not_believed(flight, kept):
    second = flight("", SQUARE)
    second.service.persistence.restore(kept, NOW_NS, 0)
    second.run_until(5.0)
    values = {"param_id": b"INS_ACC_ID", "param_value": 3000000.0, "param_type": 6}
    for _ in range(20):
        frame = Encoder(second.vehicle.dialect, 1, 1).message("PARAM_VALUE", values)
        second.service.receive(0, frame, second.now_ns)
        second.run_until(second.now_ns * 1e-9 + 0.1)
    second.run_until(10.0)
    assert said(second, "instead of") == []
    assert [lane.is_calibrated for lane in second.snapshot().lanes] == [True, True]


def test_a_service_that_must_not_learn_keeps_what_is_there_and_uses_none(flight, kept):
    second = flight("[state]\ncalibration = false\n", SQUARE)
    second.service.persistence.restore(kept, NOW_NS, 0)
    second.run_until(45.0)
    assert not said(second, BEGINS)
    assert second.service.persistence.state.calibrations == kept.calibrations


def test_another_vehicle_begins_without_them(flight, kept):
    others = {name.replace("1/", "2/"): one for name, one in kept.calibrations.items()}
    second = flight("", SQUARE)
    second.service.persistence.restore(KeptState(calibrations=others), NOW_NS, 0)
    second.run_until(15.0)
    assert second.snapshot().published_lane is not None
    assert not said(second, BEGINS)


def test_a_vehicle_that_reboots_begins_with_what_it_has_shown_before(flown, kept):
    assert kept.calibrations
    flown.run_until(60.0)
    assert said(flown, BEGINS) == [f"RAW_IMU: {BEGINS}", f"SCALED_IMU2: {BEGINS}"]
