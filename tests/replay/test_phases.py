"""The phases of a flight, and the instants of its largest errors."""

import pytest

from attest_mav.replay.log_time import LogTime
from attest_mav.replay.peaks import Peak, WallClock, time_of_day
from attest_mav.replay.phases import FlightPhases, Phase
from attest_mav.samples import VelocitySample
from attest_mav.types import VelocityOrigin
from attest_mav.vehicle_reports import ClockSample, HeartbeatSample, LandedSample


def flown(*stretches):
    """The phases of stretches of (seconds, armed, on ground, velocity, turn rate)."""
    phases, at_s = FlightPhases(), 0.0
    for seconds, armed, on_ground, velocity, rate in stretches:
        phases.take(HeartbeatSample("HEARTBEAT", 1, 1, 0, 2, 3, armed, 4), at_s)
        phases.take(LandedSample("EXTENDED_SYS_STATE", 1, 1, 0, on_ground), at_s)
        for _ in range(int(seconds * 10)):
            fix = VelocitySample("GPS", 1, 1, 0, 0, velocity, True, VelocityOrigin.RECEIVER)
            phases.take(fix, at_s)
            phases.turn(rate, at_s)
            at_s += 0.1
    return phases


STILL = (0.0, 0.0, 0.0)


def test_a_flight_has_its_phases_in_order():
    phases = flown(
        (20.0, False, True, STILL, 0.0),
        (20.0, True, False, (0.0, 0.0, -3.0), 0.0),
        (20.0, True, False, (8.0, 0.0, 0.0), 0.0),
        (20.0, True, False, (8.0, 0.0, 0.0), 0.4),
        (20.0, True, False, STILL, 0.0),
        (20.0, True, False, (0.0, 0.0, 2.0), 0.0),
        (5.0, True, True, STILL, 0.0),
    )
    told = [phases.at(at_s) for at_s in (5.0, 25.0, 35.0, 50.0, 70.0, 95.0, 105.0, 115.0, 123.0)]
    assert told == [
        Phase.GROUND,
        Phase.TAKE_OFF,
        Phase.CLIMB,
        Phase.CRUISE,
        Phase.TURN,
        Phase.HOVER,
        Phase.DESCENT,
        Phase.LANDING,
        Phase.GROUND,
    ]
    assert [one.words for one in told[:2]] == ["ground", "take-off"]


def test_nothing_told_is_no_phase():
    phases = FlightPhases()
    assert phases.at(3.0) == Phase.UNKNOWN
    phases.turn(0.0, 1.0)
    assert phases.at(3.0) == Phase.UNKNOWN


def test_a_velocity_of_long_ago_tells_nothing():
    phases = flown((5.0, True, False, (8.0, 0.0, 0.0), 0.0))
    phases.turn(0.0, 9.0)
    assert (phases.at(4.0), phases.at(9.5)) == (Phase.CRUISE, Phase.UNKNOWN)


def test_a_peak_is_the_first_of_the_largest():
    peak = Peak()
    for value, at_s in ((0.1, 1.0), (-0.4, 2.0), (0.4, 3.0), (0.2, 4.0)):
        peak.take(value, at_s)
    assert (peak.size, peak.at_s) == (0.4, 2.0)


def test_utc_follows_the_first_time_that_was_set():
    clock, time = WallClock(), LogTime()
    clock.take(ClockSample("SYSTEM_TIME", 1, 1, 1_000_000_000, 0, 5))
    clock.take(ClockSample("SYSTEM_TIME", 1, 1, 4_000_000_000, 0, 1_700_000_000_000_000))
    time.advance(3_000_000_000)
    assert clock.unix_s(0.0) is None
    clock.settle(time)
    assert clock.unix_s(10.0) == pytest.approx(1_700_000_009.0)


def test_the_time_of_day_is_utc():
    assert time_of_day(1_700_000_000.0) == "22:13:20.0"
    assert time_of_day(86_399.97) == "00:00:00.0"
