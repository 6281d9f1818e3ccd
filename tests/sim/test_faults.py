"""Each fault in the messages: those of its part and no others, in its time and no longer, by its size."""

from math import cos, inf, isnan, radians, sin

import numpy as np
import pytest

from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.faults import KINDS
from attest_mav.sim.settings import PERFECT, SimSettings

S = 1_000_000_000
START_S, DURATION_S = 8, 1
END_S = START_S + DURATION_S

TAIL_S = 0.3
"""How long the low-pass, a mean of the magnetometer or a stream of 4 Hz shows a fault that is over."""

FIRST, SECOND, THIRD, RECEIVER = "RAW_IMU", "SCALED_IMU2", "SCALED_IMU3", "GPS_RAW_INT"
WATCHED = (FIRST, SECOND, THIRD, RECEIVER, "SIM_STATE", "SYSTEM_TIME", "HEARTBEAT")
"""Everything but what carries the autopilot's attitude."""

MEASURED = {
    "gyro1-bias-x=5": {FIRST},
    "gyro2-bias-z=-5": {SECOND},
    "gyro-bias=5": {FIRST, SECOND},
    "gyro1-scale=10": {FIRST},
    "gyro2-stuck-y=20": {SECOND},
    "gyro1-stop": {FIRST},
    "gyro2-freeze": {SECOND},
    "accel1-bias-x=1": {FIRST},
    "accel2-scale-z=5": {SECOND},
    "accel2-stuck=5": {SECOND},
    "accel1-stop": {FIRST},
    "accel-freeze": {FIRST, SECOND},
    "imu1-freeze": {FIRST, THIRD},
    "imu2-freeze": {SECOND},
    "imu1-silent": {FIRST, THIRD},
    "imu2-silent": {SECOND},
    "imu1-nan": {FIRST},
    "imu2-saturated": {SECOND},
    "compass1-x=100": {FIRST, THIRD},
    "compass2-y=100": {SECOND},
    "receiver-off": {RECEIVER},
    "receiver-noise=3": {RECEIVER},
    "receiver-offset-north=5": {RECEIVER},
    "receiver-ramp-east=5": {RECEIVER},
    "receiver-wander=3": {RECEIVER},
    "receiver-late=0.5": {RECEIVER},
    "receiver-frozen": {RECEIVER},
    "trim-x=5": set(),
    "attitude-offset-north=5": set(),
    "attitude-frozen": set(),
    "vibration=20": {FIRST, SECOND},
}
"""By fault: the messages in which it is seen."""


def flown(decode, *faults, until_s=12.0, **choices):
    """Messages of a flight."""
    settings = SimSettings(**({"fast_rate_hz": 50.0} | choices), faults=parse_faults(faults))
    return decode(FakeAutopilot(settings, 1).frames_until(round(until_s * S)))


def at_s(message):
    """Time since boot."""
    return message.time_usec * 1e-6 if hasattr(message, "time_usec") else message.time_boot_ms * 1e-3


def stamped(messages, name):
    """The contents of all messages of a name by their number, or, where they have one, by their time."""
    return {
        number if name in {RECEIVER, "SIM_STATE", "SYSTEM_TIME", "HEARTBEAT"} else at_s(message): message.to_dict()
        for number, message in enumerate(messages[name])
    }


def changed(healthy, faulty, name):
    """Times or numbers of the messages that differ, or are there in one flight alone."""
    one, other = stamped(healthy, name), stamped(faulty, name)
    return [key for key in one.keys() | other.keys() if str(one.get(key)) != str(other.get(key))]


def test_every_fault_is_in_the_table():
    kinds = {fault.kind.name for fault in parse_faults(f"{fault}@0" for fault in MEASURED)}
    assert kinds | {"reboot"} == {kind.name for kind in KINDS}


@pytest.mark.parametrize("fault", MEASURED)
def test_a_fault_is_seen_in_its_own_messages_in_its_own_time(decode, fault):
    choices = {"scenario": "tumbling"}
    healthy = flown(decode, **choices)
    faulty = flown(decode, f"{fault}@{START_S}+{DURATION_S}", **choices)
    assert {name for name in WATCHED if changed(healthy, faulty, name)} == MEASURED[fault]
    for name in MEASURED[fault] - {RECEIVER}:
        times = changed(healthy, faulty, name)
        assert START_S <= min(times) < START_S + TAIL_S
        assert END_S - TAIL_S < max(times) < END_S + TAIL_S
    for number in changed(healthy, faulty, RECEIVER):
        assert START_S <= 0.25 * (number + 1) < END_S + TAIL_S  # a stream of 4 Hz


@pytest.mark.parametrize("fault", ["trim-x=5", "attitude-offset-north=5", "attitude-frozen"])
def test_a_fault_of_the_attitude_alone_ends_with_it(decode, fault):
    healthy = flown(decode, scenario="tumbling")
    faulty = flown(decode, f"{fault}@{START_S}+{DURATION_S}", scenario="tumbling")
    times = changed(healthy, faulty, "ATTITUDE")
    assert len(times) == pytest.approx(50, abs=1)
    assert min(times) >= START_S
    assert max(times) < END_S


@pytest.mark.parametrize(
    ("fault", "expected"),
    [
        ("gyro1-bias-x=5", {"xgyro": 87}),  # 87.27 mrad/s
        ("gyro1-bias-z=-5", {"zgyro": -87}),
        ("gyro1-stuck=10", {"xgyro": 174, "ygyro": 174, "zgyro": 174}),  # 174.5
        ("accel1-bias-y=-1", {"yacc": -102}),  # 101.97 mG
        ("accel1-stuck=5", {"xacc": 509, "yacc": 509, "zacc": 509}),  # 509.86
        ("accel1-stuck-z=5", {"zacc": 509}),
        ("accel1-stop", {"xacc": 0, "yacc": 0, "zacc": 0}),
        ("accel1-scale-z=50", {"zacc": -1499}),
        ("compass1-x=100", {"xmag": 100}),
        ("imu1-nan", {"xacc": 0, "yacc": 0, "zacc": 0, "xgyro": 0, "ygyro": 0, "zgyro": 0}),
    ],
)
def test_the_size_of_a_fault_of_an_inertial_sensor(decode, fault, expected):
    """A vehicle at rest with perfect sensors. Offsets are compared with the healthy reading, other faults with zero."""
    choices = {"scenario": "still", "errors": PERFECT, "until_s": 9.0}
    healthy, faulty = flown(decode, **choices)[FIRST][-1], flown(decode, f"{fault}@8", **choices)[FIRST][-1]
    added = "bias" in fault or "compass" in fault
    for axis in ("xacc", "yacc", "zacc", "xgyro", "ygyro", "zgyro", "xmag", "ymag", "zmag"):
        reading, before = getattr(faulty, axis), getattr(healthy, axis)
        if axis not in expected:
            assert reading == before
        else:
            assert reading - before * added == pytest.approx(expected[axis], abs=1)


def test_a_scale_error_is_a_share_of_the_motion(decode):
    choices = {"scenario": "tumbling", "errors": PERFECT}
    healthy, faulty = flown(decode, **choices)[FIRST], flown(decode, "gyro1-scale=10@8", **choices)[FIRST]
    for before, after in zip(healthy[420:], faulty[420:], strict=True):
        for axis in ("xgyro", "ygyro", "zgyro"):
            assert getattr(after, axis) == pytest.approx(1.1 * getattr(before, axis), abs=2.5)


def test_a_frozen_sensor_repeats_what_it_read_last_while_time_goes_on(decode):
    messages = flown(decode, f"imu1-freeze@{START_S}+{DURATION_S}", scenario="tumbling")
    frozen = [m for m in messages[FIRST] if START_S + 0.1 < at_s(m) < END_S]
    readings = {(m.xacc, m.yacc, m.zacc, m.xgyro, m.ygyro, m.zgyro, m.xmag, m.ymag, m.zmag) for m in frozen}
    assert len(readings) == 1
    assert np.ptp([at_s(m) for m in frozen]) == pytest.approx(0.86, abs=0.03)
    before = [m for m in messages[FIRST] if at_s(m) < START_S - 0.001][-1]
    assert 0 < abs(before.xgyro - frozen[0].xgyro) < 60  # 20 ms later, at up to 3 rad/s^2


def test_highres_imu_is_not_a_number_with_imu_nan(decode):
    messages = flown(decode, "imu1-nan@8+1", personality="px4")["HIGHRES_IMU"]
    assert {isnan(m.xgyro) and isnan(m.zacc) for m in messages if START_S < at_s(m) < END_S} == {True}
    assert {isnan(m.xgyro) or isnan(m.zacc) for m in messages if not START_S <= at_s(m) <= END_S} == {False}


def test_vibration_is_of_its_amplitude_and_without_a_mean(decode):
    """PX4's sensors have no low-pass, which would take most of the vibration away."""
    choices = {"personality": "px4", "scenario": "still", "errors": PERFECT}
    imu = [m for m in flown(decode, "vibration=20@8", **choices)["SCALED_IMU"] if at_s(m) > START_S]
    for axis, rest in (("xacc", -17), ("yacc", -35), ("zacc", -999)):
        force = np.array([getattr(m, axis) for m in imu]) - rest
        assert np.max(np.abs(force)) == pytest.approx(2039, rel=0.02)
        assert abs(np.mean(force)) < 60


def velocities(messages, from_s, to_s=inf):
    """Velocity north and east, m/s, of the fixes in that time, each once."""
    fixes = {m.time_usec: m for m in messages[RECEIVER] if from_s <= at_s(m) < to_s and m.fix_type == 3}
    return {
        t_us * 1e-6: (0.01 * m.vel * cos(radians(0.01 * m.cog)), 0.01 * m.vel * sin(radians(0.01 * m.cog)))
        for t_us, m in fixes.items()
    }


def test_a_receiver_that_is_off_has_no_fix_and_comes_back(decode):
    messages = flown(decode, "receiver-off@5+4", scenario="square")
    types = [m.fix_type for m in messages[RECEIVER]]
    assert types == [1] * 12 + [3] * 7 + [1] * 17 + [3] * 12  # first fix at 3.07 s; each value is for a quarter second
    assert all(m.time_unix_usec > 0 for m in messages["SYSTEM_TIME"][20:])  # the clock has been set
    assert all(m.lat != 0 for m in messages["GLOBAL_POSITION_INT"][20:])  # the autopilot goes on by itself


def test_an_offset_of_the_receiver_is_declared_by_nothing(decode):
    messages = flown(decode, "receiver-offset-east=5@8", scenario="still")
    north, east = np.array(list(velocities(messages, 8.5).values())).T
    assert np.mean(north) == pytest.approx(0.0, abs=0.05)
    assert np.mean(east) == pytest.approx(5.0, abs=0.05)
    assert {m.vel_acc for m in messages[RECEIVER]} == {0}


def test_noise_of_the_receiver_is_declared(decode):
    messages = flown(decode, "receiver-noise=3@8+50", scenario="still", until_s=65.0)
    noisy = np.array(list(velocities(messages, 8.5, 57.9).values()))
    assert len(noisy) > 180
    assert np.std(noisy) == pytest.approx(3.0, rel=0.12)
    assert {m.vel_acc for m in messages[RECEIVER] if 8.5 < at_s(m) < 57.9} == {3000}
    after = [m for m in messages[RECEIVER] if at_s(m) > 59.0]
    assert {m.vel_acc for m in after} == {0}
    assert max(m.vel for m in after) < 20


def test_a_ramp_of_the_receiver_grows_with_time(decode):
    found = velocities(flown(decode, "receiver-ramp-north=0.5@8", scenario="still", until_s=30.0), 9.0)
    for t_s, (north, east) in found.items():
        assert north == pytest.approx(0.5 * (t_s - 0.1 - 8.0), abs=0.2)  # a fix tells of 0.1 s before
        assert east == pytest.approx(0.0, abs=0.2)


def test_a_late_receiver_tells_of_earlier(decode):
    settings = SimSettings(scenario="coordinated-turns", faults=parse_faults(["receiver-late=0.5@40"]))
    vehicle = FakeAutopilot(settings, 1)
    found = velocities(decode(vehicle.frames_until(55 * S)), 41.0)
    assert len(found) > 50
    for t_s, (north, east) in found.items():
        v = vehicle.truth(round((t_s - 0.6) * 1e9)).v_ned
        assert (north, east) == pytest.approx((v[0], v[1]), abs=0.25)


def test_a_frozen_receiver_repeats_one_fix_with_new_times(decode):
    messages = flown(decode, "receiver-frozen@40+5", scenario="coordinated-turns", until_s=50.0)[RECEIVER]
    frozen = [m for m in messages if 40.1 < at_s(m) < 45.0]
    assert len({(m.lat, m.lon, m.alt, m.vel, m.cog) for m in frozen}) == 1
    assert len({m.time_usec for m in frozen}) > 15
    moving = [m for m in messages if at_s(m) > 45.1]
    assert len({(m.lat, m.lon) for m in moving}) == len({m.time_usec for m in moving})


def test_a_trim_turns_the_reported_attitude_in_the_body(decode):
    choices = {"scenario": "still", "attitude_error": (0.0, 0.0, 0.0)}
    last = flown(decode, "trim-x=5@8", **choices)["ATTITUDE"][-1]
    assert (last.roll, last.pitch, last.yaw) == pytest.approx([radians(a) for a in (2.0 + 5.0, -1.0, 60.0)], abs=1e-6)


def test_faults_of_one_part_add_up(decode):
    choices = {"scenario": "still", "errors": PERFECT}
    last = flown(decode, "gyro1-bias-x=5@8", "gyro-bias-x=2@8", **choices)[FIRST][-1]
    assert last.xgyro == 122  # 7 deg/s are 122.2 mrad/s
