"""Our parameters over MAVLink, with pymavlink as the ground station, on virtual time."""

import struct
from itertools import pairwise
from math import inf, nan

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.config.parsing import parse_config
from attest_mav.errors import ConfigError
from attest_mav.mavlink.component.channel import PortSettings
from attest_mav.mavlink.component.companion_settings import CompanionSettings
from attest_mav.mavlink.component.own_parameters import OWN_PARAMETERS, ParameterChange
from attest_mav.service.assembly import service_settings

NAMES = ["ATT_RATE", "ATT_MAX_SIG", "ATT_TILT_LIM", "ATT_HOLD"]
VALUES = [20.0, 3.0, 0.0, 0.6]
REAL32 = mavlink.MAV_PARAM_TYPE_REAL32
OPEN = PortSettings(parameters=True)


def float32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


@pytest.fixture
def desk(bench):
    """A companion of vehicle 1 whose first link allows parameters and whose second does not."""
    settings = CompanionSettings(parameters=dict(zip(NAMES, VALUES, strict=True)))
    b = bench(settings, [OPEN, PortSettings()])
    b.vehicle_heartbeat()
    b.run_until(0.5)
    return b


def request_list(desk, system=1, component=193, link=0):
    desk.hear(mavlink.MAVLink_param_request_list_message(system, component), 255, 190, link)


def request(desk, name, index=-1, component=193, link=0):
    desk.hear(mavlink.MAVLink_param_request_read_message(1, component, name, index), 255, 190, link)


def set_to(desk, name, value, kind=REAL32, component=193, link=0):
    desk.hear(mavlink.MAVLink_param_set_message(1, component, name, value, kind), 255, 190, link)


def answers(desk, link=0):
    return [(one.param_id, one.param_value) for one in desk.of_type("PARAM_VALUE", link)]


def arm(desk, armed=True):
    mode = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else 0
    desk.hear(mavlink.MAVLink_heartbeat_message(2, 3, mode, 0, 4, 3))


@pytest.mark.parametrize(("system", "component"), [(1, 193), (1, 0), (0, 0)])
def test_a_list_has_every_parameter_once_with_its_index(desk, system, component):
    request_list(desk, system, component)
    desk.run_until(2.0)
    got = desk.of_type("PARAM_VALUE")
    assert [(one.param_id, one.param_index) for one in got] == [(name, i) for i, name in enumerate(NAMES)]
    assert {(one.param_count, one.param_type) for one in got} == {(4, REAL32)}
    assert [one.param_value for one in got] == [float32(value) for value in VALUES]
    assert {(one.get_srcSystem(), one.get_srcComponent()) for one in got} == {(1, 193)}
    assert answers(desk, link=1) == []


def test_a_list_goes_out_at_a_pace_however_often_it_is_requested(desk):
    times = []
    for now_ns in range(1_000_000_000, 3_000_000_000, 1_000_000):
        desk.now_ns = now_ns
        request_list(desk)
        desk.companion.poll(now_ns)
        before = len(answers(desk))
        desk._collect()
        times += [now_ns] * (len(answers(desk)) - before)
    assert 38 <= len(times) <= 40
    assert min(b - a for a, b in pairwise(times)) >= 50_000_000


@pytest.mark.parametrize(("name", "index"), [(b"ATT_HOLD", -1), (b"", 3), (b"ATT_RATE", 3)])
def test_one_is_read_by_name_or_by_index(desk, name, index):
    request(desk, name, index)
    assert answers(desk) == [("ATT_HOLD", float32(0.6))]


@pytest.mark.parametrize(("name", "index"), [(b"ATT_NONE", -1), (b"", 4), (b"", 32767), (b"\xff" * 16, -1), (b"", -5)])
def test_what_does_not_exist_is_not_answered(desk, name, index):
    request(desk, name, index)
    set_to(desk, name, 1.0)
    assert answers(desk) == []


@pytest.mark.parametrize("component", [0, 1, 154])
def test_what_is_not_for_us_alone_is_neither_answered_nor_obeyed(desk, component):
    request(desk, b"ATT_HOLD", component=component)
    set_to(desk, b"ATT_HOLD", 3.0, component=component)
    assert answers(desk) == []
    assert desk.companion.own_parameters.value("ATT_HOLD") == 0.6


def test_a_link_without_parameters_answers_nothing_and_obeys_nobody(desk):
    request_list(desk, link=1)
    request(desk, b"ATT_HOLD", link=1)
    set_to(desk, b"ATT_HOLD", 3.0, link=1)
    desk.run_until(2.0)
    assert answers(desk, 1) == answers(desk, 0) == []
    assert desk.companion.own_parameters.changes == {}


def test_without_such_a_link_the_messages_are_not_even_wanted(bench, dialect):
    b = bench(CompanionSettings(parameters={"ATT_RATE": 20.0}))
    names = ("PARAM_SET", "PARAM_REQUEST_LIST", "PARAM_REQUEST_READ")
    assert not {dialect.id_of(name) for name in names} & b.companion.wanted


def test_a_value_is_set_answered_and_told_with_its_sender(desk):
    set_to(desk, b"ATT_HOLD", 2.5)
    assert answers(desk) == [("ATT_HOLD", 2.5)]
    assert desk.companion.own_parameters.changes == {"ATT_HOLD": ParameterChange(2.5, "255/190 on link0")}
    assert "link0: 255/190 has set ATT_HOLD to 2.5 (was 0.6)" in desk.notes
    set_to(desk, b"ATT_HOLD", float32(0.6))
    assert desk.companion.own_parameters.changes == {}, "the configured value needs no keeping"


@pytest.mark.parametrize(
    ("name", "value", "answer"),
    [
        (b"ATT_RATE", 1e9, 1000.0),
        (b"ATT_RATE", -1.0, float32(0.01)),
        (b"ATT_MAX_SIG", 0.0, float32(0.01)),
        (b"ATT_MAX_SIG", 500.0, 180.0),
        (b"ATT_TILT_LIM", 91.0, 90.0),
        (b"ATT_TILT_LIM", -5.0, 0.0),
        (b"ATT_HOLD", 61.0, 60.0),
        (b"ATT_HOLD", nan, float32(0.6)),
        (b"ATT_HOLD", inf, float32(0.6)),
        (b"ATT_RATE", -inf, 20.0),
    ],
)
def test_a_value_out_of_range_is_moved_into_it_and_no_number_is_refused(desk, name, value, answer):
    set_to(desk, name, value)
    assert answers(desk) == [(name.decode(), answer)]


@pytest.mark.parametrize("kind", [1, 2, 6, 10, 200])
def test_another_type_is_refused_and_answered_with_the_value_in_force(desk, kind):
    set_to(desk, b"ATT_HOLD", 5.0, kind)
    assert answers(desk) == [("ATT_HOLD", float32(0.6))]
    assert f"link0: 255/190 may not set ATT_HOLD: its type is {kind}, and REAL32 was expected" in desk.notes


def test_while_the_vehicle_is_armed_only_the_rate_can_be_set(desk):
    arm(desk)
    for name in NAMES:
        set_to(desk, name.encode(), 7.0)
    assert answers(desk) == [("ATT_RATE", 7.0), *zip(NAMES[1:], map(float32, VALUES[1:]), strict=True)]
    assert "link0: 255/190 may not set ATT_HOLD: the vehicle is armed" in desk.notes
    arm(desk, armed=False)
    set_to(desk, b"ATT_HOLD", 7.0)
    assert answers(desk)[-1] == ("ATT_HOLD", 7.0)


def test_a_flood_is_answered_twenty_times_a_second(desk):
    for number in range(500):
        set_to(desk, b"ATT_HOLD", 1.0 + number % 2)
    assert len(answers(desk)) == 20
    assert len([one for one in desk.notes if "has set" in one]) <= 10


def test_names_fit_and_ranges_are_those_of_the_configuration():
    keys = {
        "ATT_RATE": ("output", "rate_hz"),
        "ATT_MAX_SIG": ("output", "max_sigma_deg"),
        "ATT_TILT_LIM": ("verdict", "tilt_deg"),
        "ATT_HOLD": ("verdict", "hold_s"),
    }
    assert list(keys) == [one.name for one in OWN_PARAMETERS]
    for one in OWN_PARAMETERS:
        assert len(one.name) <= 16
        table, key = keys[one.name]
        for value in (one.low or 0.1, one.high):
            config = parse_config(f"[{table}]\n{key} = {value}\n[[link]]\nurl = 'sim:'\nparameters = true", "x")
            assert service_settings(config).companion.parameters[one.name] == value
        with pytest.raises(ConfigError, match=key):
            parse_config(f"[{table}]\n{key} = {one.high * 1.01}", "x")
