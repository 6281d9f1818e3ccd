"""Texts for people are few, and tell the present condition."""

import pytest

from attest_mav.mavlink.component.announcer import Announcement, Announcer
from attest_mav.mavlink.component.channel import PortSettings

SECOND = 1_000_000_000
CRITICAL, WARNING, NOTICE = 2, 4, 5


def say(announcer, topic="verdict", severity=WARNING, text="x"):
    announcer.announce(Announcement(topic, severity, text))


def sent(announcer, until_s, every=lambda _: None):
    """Times (s) and texts that are taken, asked 20 times a second. every: called before each."""
    taken = []
    for step in range(20 * until_s):
        every(step / 20)
        one = announcer.take(step * SECOND // 20)
        if one is not None:
            taken.append((step / 20, one.text))
    return taken


def test_one_text_a_second_the_worst_first():
    announcer = Announcer()
    say(announcer, "a", NOTICE, "notice")
    say(announcer, "b", WARNING, "warning")
    say(announcer, "c", CRITICAL, "critical")
    assert sent(announcer, 5) == [(0.0, "critical"), (1.0, "warning"), (2.0, "notice")]


def test_a_newer_text_of_the_topic_replaces_one_that_waits():
    announcer = Announcer()
    say(announcer, "other", CRITICAL, "first")
    announcer.take(0)
    say(announcer, "verdict", WARNING, "off")
    say(announcer, "verdict", NOTICE, "agrees")
    assert [text for _, text in sent(announcer, 5)] == ["agrees"]


def test_a_text_is_not_repeated_within_ten_seconds():
    announcer = Announcer()
    times = [t_s for t_s, _ in sent(announcer, 31, lambda _: say(announcer))]
    assert times == [0.0, 10.0, 20.0, 30.0]


def test_a_flood_is_cut_to_six_a_minute_and_critical_texts_still_come():
    announcer = Announcer()

    def flood(t_s):
        say(announcer, "lane", WARNING, f"fault at {t_s}")
        if t_s == 30.0:
            say(announcer, "verdict", CRITICAL, "wrong")

    taken = sent(announcer, 60, flood)
    assert [t_s for t_s, _ in taken] == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 30.0]
    assert taken[-1] == (30.0, "wrong")
    assert announcer.take(60 * SECOND).text == "fault at 59.95"


def test_the_deadline_is_when_a_text_may_be_sent():
    announcer = Announcer()
    assert announcer.next_deadline_ns is None
    for number in range(6):
        say(announcer, f"{number}")
        assert announcer.next_deadline_ns <= number * SECOND
        assert announcer.take(number * SECOND) is not None
    say(announcer, "one too many")
    assert announcer.take(10 * SECOND) is None
    assert announcer.next_deadline_ns == 60 * SECOND
    say(announcer, "c", CRITICAL)
    assert announcer.next_deadline_ns == 6 * SECOND


@pytest.mark.parametrize(
    ("text", "chunks"),
    [
        ("x" * 50, ["x" * 50]),
        ("y" * 51, ["y" * 50, "y"]),
        ("z" * 100, ["z" * 50, "z" * 50, ""]),
    ],
)
def test_a_text_goes_out_in_chunks_on_the_links_that_carry_texts(bench, text, chunks):
    b = bench(links=[PortSettings(), PortSettings(("attitude_quaternion",)), PortSettings(("statustext",))])
    b.vehicle_heartbeat()
    b.companion.announcer.announce(Announcement("topic", WARNING, text))
    b.run_until(0.5)
    assert b.of_type("STATUSTEXT", 1) == []
    for link in (0, 2):
        got = b.of_type("STATUSTEXT", link)
        assert [one.text for one in got] == chunks
        assert [one.chunk_seq for one in got] == list(range(len(chunks)))
        assert {one.severity for one in got} == {WARNING}
        assert {one.id for one in got} == ({0} if len(chunks) == 1 else {1})
