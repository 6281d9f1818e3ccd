"""One vehicle on several links, copies of its frames, and two senders with one id."""

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.mavlink.component.channel import PortSettings
from attest_mav.mavlink.component.companion_settings import CompanionSettings

RAW_IMU = 27
TWO = [PortSettings(), PortSettings()]


def raw_imu(t_ns):
    return mavlink.MAVLink_raw_imu_message(t_ns // 1000, 0, 0, -1000, 0, 0, 0, 200, 0, 400)


class Sender:
    """An autopilot on one of our links: RAW_IMU at 50 Hz and a heartbeat, with numbers and a clock of its own."""

    def __init__(self, bench, link=0, sequence=0, clock_ns=0, component=1):
        self.bench, self.link, self.sequence, self.clock_ns = bench, link, sequence, clock_ns
        self.component = component

    def say(self, message, links=None):
        """The same frame on each of these links; how many of them gave data."""
        taken = 0
        for link in links or [self.link]:
            taken += self.bench.hear(message, 1, self.component, link, self.sequence % 256)
        self.sequence += 1
        return taken

    def beat(self, links=None):
        self.say(mavlink.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3), links)

    def sample(self, links=None):
        t_ns = self.bench.now_ns + self.clock_ns
        taken = self.say(raw_imu(t_ns), links)
        if taken:
            self.bench.companion.imu_taken("RAW_IMU", t_ns, self.bench.now_ns)
        return taken


def acknowledge(b, counts):
    """The autopilot accepts what was requested on each link since the last call."""
    for link, count in enumerate(counts):
        asked = len(b.interval_requests(link))
        if asked > count:
            counts[link] = asked
            b.companion.data.stream_manager.acknowledged(mavlink.MAV_RESULT_ACCEPTED, b.now_ns)


def fly(b, until_s, act):
    """50 calls a second, with the companion polled; what it requests is accepted."""
    counts = [0] * len(b.sent)
    taken = 0
    tick = b.now_ns // 20_000_000
    while tick * 0.02 < until_s - 1e-9:
        tick += 1
        b.run_until(tick * 0.02)
        acknowledge(b, counts)
        taken += act(tick)
    return taken


def beats(tick, *senders):
    if tick % 50 == 0:
        for sender in senders:
            sender.beat()


def test_a_copy_by_another_link_is_dropped_and_fills_in_what_was_lost(bench):
    b = bench(links=TWO)
    sender = Sender(b)
    sender.beat([0, 1])

    def act(tick):
        if tick % 50 == 0:
            sender.beat([0, 1])
        return sender.sample([1] if tick % 4 == 0 else [0, 1])

    assert fly(b, 10.0, act) == 500, "each sample once, although the first link loses a quarter"
    assert b.companion.remarks(b.now_ns) == []


def test_streams_of_two_ports_are_not_mixed_and_the_second_takes_over(bench):
    b = bench(links=TWO)
    one, two = Sender(b, 0), Sender(b, 1, sequence=99)
    one.beat()

    def act(tick):
        beats(tick, one, two)
        return one.sample() + two.sample()

    assert fly(b, 10.0, act) == 500
    assert b.companion.remarks(b.now_ns) == []

    def second_alone(tick):
        beats(tick, two)
        return two.sample()

    assert fly(b, 15.0, second_alone) >= 250 - 16, "a third of a second is missing"
    assert b.companion.discovery.vehicle.link == 1


def test_heartbeats_on_one_link_and_samples_on_another(bench):
    b = bench(links=TWO)
    router, cable = Sender(b, 1), Sender(b, 0, sequence=70)
    router.beat()

    def act(tick):
        beats(tick, router)
        return cable.sample()

    assert fly(b, 20.0, act) == 1000
    assert b.companion.discovery.vehicle.link == 0
    assert sum("samples come on link0" in note for note in b.notes) == 1


def test_a_link_without_samples_gives_the_vehicle_up_to_the_next_one(bench):
    """The cable answers requests; the network has heartbeats alone, and was first."""
    b = bench(CompanionSettings(), links=TWO)
    router, cable = Sender(b, 1), Sender(b, 0, sequence=70)
    router.beat()

    def act(tick):
        beats(tick, router, cable)
        asked = any(message == RAW_IMU for message, _, _ in b.interval_requests(0))
        return cable.sample() if asked else 0

    fly(b, 60.0, act)
    assert b.companion.data.primary_imu == "RAW_IMU"
    assert b.companion.discovery.vehicle.link == 0
    assert "no inertial message comes; trying link0" in b.notes


def test_an_autopilot_that_is_not_component_1_is_kept_and_the_claim_is_named(bench):
    b = bench(links=TWO)
    own, forged = Sender(b, 0, component=2), Sender(b, 1, sequence=50)

    def alone(tick):
        beats(tick, own)
        return own.sample()

    fly(b, 6.0, alone)
    assert b.companion.sender == (1, 2, 3)

    def besieged(tick):
        beats(tick, own, forged)
        return own.sample()

    assert fly(b, 20.0, besieged) == 700
    assert b.companion.sender == (1, 2, 3)
    assert sum("component 1 of system 1 is an autopilot too; component 2 is kept" in note for note in b.notes) == 1


@pytest.mark.parametrize(
    ("other", "evidence"),
    [({"sequence": 128}, "two runs of sequence numbers"), ({"sequence": 20, "clock_ns": 90 * 10**9}, "two clocks")],
)
def test_two_vehicles_with_one_id_are_named_once_a_minute(bench, other, evidence):
    b = bench()
    one, two = Sender(b), Sender(b, **other)
    one.beat()

    def act(tick):
        beats(tick, one, two)
        return one.sample() + two.sample()

    fly(b, 30.0, act)
    text = f"two vehicles use system 1 ({evidence}): give each a system id of its own"
    assert b.companion.remarks(b.now_ns) == [text]
    assert b.notes.count(text) == 1
    fly(b, 45.0, lambda _: one.sample())
    assert b.companion.remarks(b.now_ns) == []


def test_two_vehicles_are_told_by_their_clocks_after_the_first_one_has_set_its_own(bench):
    b = bench()
    one, two = Sender(b), Sender(b, sequence=20, clock_ns=90 * 10**9)

    def alone(tick):
        beats(tick, one)
        return one.sample()

    fly(b, 10.0, alone)
    one.clock_ns = -5 * 10**9
    fly(b, 20.0, alone)
    assert b.companion.remarks(b.now_ns) == []
    fly(b, 22.0, lambda _: one.sample() + two.sample())
    assert b.companion.traffic.identity.are_two_clocks(b.now_ns)


@pytest.mark.parametrize("late_by", [1, 3, 15])
def test_late_frames_are_no_second_vehicle(bench, late_by):
    b = bench()
    sender = Sender(b)
    sender.beat()
    late = []

    def act(tick):
        beats(tick, sender)
        if tick % 5 == 0:
            late.append((tick + late_by, sender.sequence, b.now_ns))
            sender.sequence += 1
            return 0
        taken = sender.sample()
        while late and late[0][0] <= tick:
            _, sequence, t_ns = late.pop(0)
            taken += b.hear(raw_imu(t_ns), 1, 1, 0, sequence % 256)
            b.companion.imu_taken("RAW_IMU", t_ns, b.now_ns)
        return taken

    fly(b, 30.0, act)
    assert b.companion.remarks(b.now_ns) == []


def test_losses_and_a_reboot_are_no_second_vehicle(bench):
    b = bench()
    sender = Sender(b)
    sender.beat()

    def act(tick):
        beats(tick, sender)
        if tick % 7 == 0:
            sender.sequence += 100
        if tick == 700:
            sender.sequence, sender.clock_ns = 0, -13 * 10**9
        return sender.sample()

    fly(b, 30.0, act)
    assert b.companion.remarks(b.now_ns) == []


def test_a_router_that_loops_is_named(bench):
    b = bench()
    sender = Sender(b)
    sender.beat()

    def act(tick):
        beats(tick, sender)
        return sender.sample([0, 0, 0])

    assert fly(b, 20.0, act) == 1000
    text = "link0 brings frames more than once: a router loops, or forwards twice"
    assert b.companion.remarks(b.now_ns) == [text]
    assert b.notes.count(text) == 1


def test_nothing_is_asked_while_the_vehicle_is_away(bench):
    b = bench()
    sender = Sender(b)
    sender.beat()
    fly(b, 1.0, lambda _: sender.sample())
    before = len(b.of_type("COMMAND_LONG"))
    b.run_until(3.1)
    asked = len(b.of_type("COMMAND_LONG")) - before
    b.run_until(30.0)
    assert len(b.of_type("COMMAND_LONG")) - before == asked <= 2
    assert not any("no answer" in note for note in b.notes)
