import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.mavlink.component.channel import PortSettings
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.component.outputs import OUTPUTS, Output
from attest_mav.mavlink.component.ports import Port
from attest_mav.mavlink.component.schedule import Schedule

SECOND = 1_000_000_000
BOTH = PortSettings(("attitude_quaternion", "attitude_quaternion_cov"))


def test_the_attitude_carries_the_sample_time_and_the_rates(bench, estimate):
    b = bench()
    b.vehicle_heartbeat(system=7)
    half = math.sqrt(0.5)
    b.publish(estimate(t_s=12.345, q_nb=(half, 0.0, 0.0, half), rates=(0.1, -0.2, 0.3)))
    (message,) = b.of_type("ATTITUDE_QUATERNION")
    assert message.time_boot_ms == 12345
    assert (message.get_srcSystem(), message.get_srcComponent()) == (7, 193)
    assert [message.q1, message.q2, message.q3, message.q4] == pytest.approx([half, 0.0, 0.0, half])
    assert [message.rollspeed, message.pitchspeed, message.yawspeed] == pytest.approx([0.1, -0.2, 0.3])
    assert list(message.repr_offset_q) == [0.0] * 4


def test_time_wraps_as_the_autopilots_clock_does(bench, estimate):
    b = bench()
    b.publish(estimate(t_s=2**32 / 1000 + 1.5))
    assert b.of_type("ATTITUDE_QUATERNION")[0].time_boot_ms == 1500


@pytest.mark.parametrize(
    "bad",
    [
        {"q_nb": (math.nan, 0.0, 0.0, 0.0)},
        {"q_nb": (math.inf, 0.0, 0.0, 0.0)},
        {"q_nb": (0.0, 0.0, 0.0, 0.0)},
        {"q_nb": (0.5, 0.0, 0.0, 0.0)},
        {"rates": (math.nan, 0.0, 0.0)},
        {"rates": (0.0, math.inf, 0.0)},
        {"rates": (0.0, 1e300, 0.0)},
    ],
)
def test_what_is_no_attitude_is_never_sent(bench, estimate, bad):
    b = bench(links=[BOTH])
    b.publish(estimate(**bad))
    assert b.sent == [[]]


def test_the_covariance_is_filled_where_it_is_known_and_marked_unknown_where_not(bench, estimate):
    b = bench(links=[PortSettings(("attitude_quaternion_cov",))])
    b.publish(estimate(t_s=1.0))
    b.publish(estimate(t_s=2.0, sigma=0.1))
    unknown, known = b.of_type("ATTITUDE_QUATERNION_COV")
    assert math.isnan(unknown.covariance[0])
    assert list(known.covariance) == pytest.approx([0.01, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.01])
    assert known.time_usec == 2_000_000
    assert b.of_type("ATTITUDE_QUATERNION") == []


def test_each_link_carries_what_it_is_told_to(bench, estimate):
    b = bench(links=[PortSettings(), PortSettings(()), BOTH])
    b.publish(estimate())
    assert [len(sent) for sent in b.sent] == [1, 0, 2]


def test_sequence_numbers_run_through_on_each_link(bench, estimate):
    b = bench(links=[PortSettings(), BOTH])
    b.vehicle_heartbeat()
    for tick in range(40):
        b.run_until(tick * 0.1)
        b.publish(estimate(t_s=tick * 0.1))
    for sent in b.sent:
        numbers = [message.get_seq() for message in sent]
        assert numbers == [(numbers[0] + step) % 256 for step in range(len(numbers))]


@settings(derandomize=True, max_examples=60)
@given(st.floats(1.0, 100.0), st.floats(1.0, 400.0), st.floats(0.0, 0.3))
def test_a_schedule_keeps_the_rate_whatever_the_samples(hz, sample_hz, jitter):
    schedule = Schedule(int(SECOND / hz))
    sent, t_s = 0, 0.0
    for number in range(2000):
        wobble = jitter * math.sin(number * 1.7) / sample_hz
        t_s = number / sample_hz + wobble
        sent += schedule.due(round(t_s * SECOND) + 5 * SECOND)
    highest = min(hz, sample_hz)
    assert sent / t_s <= highest * 1.12 + 2.0 / t_s
    if hz <= 0.5 * sample_hz:
        assert sent / t_s >= highest * 0.9 - 2.0 / t_s


def test_attitude_is_held_back_while_another_onboard_computer_is_heard(bench, estimate):
    b = bench(links=[BOTH, PortSettings()])
    b.vehicle_heartbeat()
    b.hear(onboard_heartbeat(), system=1, component=191, link=0)
    b.publish(estimate(t_s=1.0))
    assert b.of_type("ATTITUDE_QUATERNION", 0) == []
    assert len(b.of_type("ATTITUDE_QUATERNION_COV", 0)) == 1, "nobody mistakes that one"
    assert len(b.of_type("ATTITUDE_QUATERNION", 1)) == 1, "not heard there"
    b.run_until(6.0)
    b.publish(estimate(t_s=6.0))
    assert len(b.of_type("ATTITUDE_QUATERNION", 0)) == 1
    assert any("held back: component 191" in note for note in b.notes)
    assert any("sent again" in note for note in b.notes)


def test_who_is_not_to_yield_does_not(bench, estimate):
    b = bench(links=[PortSettings(yields=False)])
    b.vehicle_heartbeat()
    b.hear(onboard_heartbeat(), system=1, component=191)
    b.publish(estimate())
    assert len(b.of_type("ATTITUDE_QUATERNION")) == 1


def test_another_system_holds_nothing_back(bench, estimate):
    b = bench()
    b.vehicle_heartbeat()
    b.hear(onboard_heartbeat(), system=42, component=191)
    b.publish(estimate())
    assert len(b.of_type("ATTITUDE_QUATERNION")) == 1


def test_a_ground_station_holds_it_back_where_the_vehicle_is_heard_too(bench, estimate):
    b = bench(links=[BOTH, PortSettings(), PortSettings(yields_to_stations=False)])
    b.vehicle_heartbeat(link=0)
    station = onboard_heartbeat(vehicle_type=6)
    for link in (0, 1, 2):
        b.hear(station, system=255, component=190, link=link)
    b.publish(estimate(t_s=1.0))
    assert [len(b.of_type("ATTITUDE_QUATERNION", link)) for link in (0, 1, 2)] == [0, 1, 1]
    assert len(b.of_type("ATTITUDE_QUATERNION_COV", 0)) == 1
    b.run_until(6.0)
    b.publish(estimate(t_s=6.0))
    assert len(b.of_type("ATTITUDE_QUATERNION", 0)) == 1
    assert any("held back: component 190 is a ground station here too" in note for note in b.notes)
    assert any("the ground station is gone" in note for note in b.notes)


def made_up_frames(encoder, publication):
    """An output that the package does not have: time of the estimate and the verdict, in a DEBUG message."""
    return [encoder.message("DEBUG", {"time_boot_ms": publication.estimate.t_ns // 1_000_000, "ind": 7})]


def made_up(**changes):
    output = Output("made_up", "DEBUG", made_up_frames, **changes)
    return PortSettings(("made_up",), outputs=(*OUTPUTS, output))


def fly(b, estimate, seconds=10):
    """Estimates at 50 Hz."""
    for number in range(50 * seconds):
        b.run_until(number / 50)
        b.publish(estimate(t_s=number / 50))


@pytest.mark.parametrize(("hz", "expected"), [(2.0, 20), (0.0, 200)])
def test_an_entry_is_all_that_a_new_output_needs_to_be_sent_at_its_rate(bench, estimate, hz, expected):
    b = bench(links=[made_up(hz=hz), PortSettings()])
    fly(b, estimate)
    messages = b.of_type("DEBUG")
    assert len(messages) == pytest.approx(expected, abs=1)
    assert messages[-1].time_boot_ms > 9_000
    assert b.of_type("DEBUG", 1) == []
    assert b.of_type("ATTITUDE_QUATERNION") == [], "it was not published there"


def test_a_new_output_beside_the_heartbeat_is_sent_with_it(bench, estimate):
    b = bench(links=[made_up(with_heartbeat=True)])
    fly(b, estimate)
    assert len(b.of_type("DEBUG")) == len(b.of_type("HEARTBEAT")) - 1, "there was no estimate at the first one"


def test_a_new_output_can_be_requested_and_retimed(bench, estimate):
    b = bench(links=[PortSettings((), outputs=made_up().outputs)])
    fly(b, estimate, 1)
    assert b.of_type("DEBUG") == []
    for command, value in ((512, 0), (511, 500_000)):
        message = mavlink.MAVLink_command_long_message(1, 193, command, 0, 254, value, 0, 0, 0, 0, 0)
        b.hear(message, system=255, component=190)
    assert [ack.result for ack in b.of_type("COMMAND_ACK")] == [0, 0]
    assert len(b.of_type("DEBUG")) == 1
    fly(b, estimate)
    assert len(b.of_type("DEBUG")) == pytest.approx(1 + 20, abs=1)


def test_a_new_output_that_misleads_yields(bench, estimate):
    b = bench(links=[made_up(misleads="some program")])
    b.vehicle_heartbeat()
    b.hear(onboard_heartbeat(), system=1, component=191)
    b.publish(estimate())
    assert b.of_type("DEBUG") == []
    assert any("DEBUG is held back" in note and "some program would take ours" in note for note in b.notes)


def test_an_interval_of_a_station_that_stays_ends_ten_minutes_after_its_command(bench, estimate):
    b = bench(links=[PortSettings(yields_to_stations=False)])
    b.vehicle_heartbeat()

    def station_beats():
        if b.now_ns % (10 * SECOND) == 0:
            b.hear(onboard_heartbeat(vehicle_type=6), system=255, component=190)

    def sent_at(t_s):
        b.run_until(t_s, station_beats)
        before = len(b.of_type("ATTITUDE_QUATERNION"))
        for tick in range(200):
            b.publish(estimate(t_s=t_s + tick / 50))
        return len(b.of_type("ATTITUDE_QUATERNION")) - before

    stop = mavlink.MAVLink_command_long_message(1, 193, 511, 0, 31, -1, 0, 0, 0, 0, 0)
    b.hear(stop, system=255, component=190)
    assert [sent_at(t_s) for t_s in (1.0, 100.0, 599.0)] == [0, 0, 0]
    assert sent_at(601.0) == pytest.approx(80, abs=1)
    assert any("back at its own rate, 20 Hz: set 10 minutes ago" in note for note in b.notes)


def onboard_heartbeat(vehicle_type=18):
    return mavlink.MAVLink_heartbeat_message(vehicle_type, 8, 0, 0, 4, 3)


def test_another_system_id_keeps_the_signer(dialect, notebook):
    port = Port(dialect, "link", PortSettings(), 1, 193, 20.0, notebook)
    port.encoder = Encoder(dialect, 1, 193, signer=lambda _: bytes(13))
    port.rename(7)
    port.heartbeat(4)
    (frame,) = port.take()
    assert (frame[2], frame[5], frame[-13:]) == (1, 7, bytes(13))


def test_another_rate_of_our_own_leaves_an_interval_that_a_station_has_set(bench, estimate):
    b = bench(links=[BOTH])
    b.vehicle_heartbeat()
    b.hear(mavlink.MAVLink_command_long_message(1, 193, 511, 0, 31, 1e6, 0, 0, 0, 0, 0), 255, 190)
    b.companion.ports[0].set_rate(5.0)
    for number in range(175):
        b.publish(estimate(t_s=100.0 + number * 0.02))
    assert len(b.of_type("ATTITUDE_QUATERNION")) == 4
    assert len(b.of_type("ATTITUDE_QUATERNION_COV")) == 18
