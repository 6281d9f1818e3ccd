from math import cos, pi, radians, sin

import pytest

from attest_mav.algebra import heading_between, q_exp, q_from_euler, q_heading, q_mul
from attest_mav.replay.bridge import half_rotation_vector
from attest_mav.replay.reference_track import MAX_ERROR, Lack, ReferenceTrack

MS = 1_000_000


def attitude_at(track, t_ns):
    knot = track.at(t_ns)
    return None if knot is None else knot.q_nb


def test_halfway_without_rates_is_half_the_turn():
    track = ReferenceTrack()
    track.add(0, q_heading(radians(10.0)), None)
    track.add(100 * MS, q_heading(radians(12.0)), None)
    q = attitude_at(track, 50 * MS)
    assert q is not None
    assert heading_between(q, q_heading(0.0)) == pytest.approx(radians(11.0))


def test_the_short_way_round_when_the_quaternion_changes_sign():
    track = ReferenceTrack()
    track.add(0, q_heading(radians(10.0)), None)
    w, x, y, z = q_heading(radians(12.0))
    track.add(100 * MS, (-w, -x, -y, -z), None)
    q = attitude_at(track, 50 * MS)
    assert q is not None
    assert heading_between(q, q_heading(0.0)) == pytest.approx(radians(11.0))


def test_rates_bend_the_path_as_the_vehicle_did():
    # A yaw of psi = a t^3 is a cubic, which the interpolation holds exactly.
    track = ReferenceTrack()
    track.add(0, q_heading(0.0), (0.0, 0.0, 0.0))
    track.add(250 * MS, q_heading(0.5 * 0.25**3), (0.0, 0.0, 1.5 * 0.25**2))
    q = attitude_at(track, 100 * MS)
    assert q is not None
    assert heading_between(q, q_heading(0.0)) == pytest.approx(0.5 * 0.1**3)


def test_a_steady_turn_about_a_slanted_axis_is_kept():
    rates = (0.8, -0.6, 1.0)
    start = q_from_euler(0.3, -0.2, 2.0)

    def turned(seconds):
        return q_mul(start, q_exp(tuple(0.5 * seconds * rate for rate in rates)))

    track = ReferenceTrack()
    track.add(0, start, rates)
    track.add(200 * MS, turned(0.2), rates)
    q = attitude_at(track, 70 * MS)
    assert q is not None
    assert q == pytest.approx(turned(0.07), abs=1e-12)


def test_a_stamp_stands_for_its_whole_millisecond():
    track = ReferenceTrack()
    first = q_heading(1.0)
    track.add(8484 * MS, first, None)
    assert track.reaches(8484 * MS + 105_000)
    assert attitude_at(track, 8484 * MS + 105_000) == first
    assert not track.reaches(8485 * MS)
    assert attitude_at(track, 8485 * MS) is None


def test_outside_there_is_nothing_and_inside_a_standing_reference_is_known():
    track = ReferenceTrack()
    for t_ms in (1000, 1350, 3700):
        track.add(t_ms * MS, q_heading(0.0), (0.0, 0.0, 0.0))
    for t_ms in (999, 3702):
        assert attitude_at(track, t_ms * MS) is None
        assert track.lack(t_ms * MS) == Lack.OUTSIDE
    for t_ms in (1200, 2500, 3699):
        assert attitude_at(track, t_ms * MS) == pytest.approx(q_heading(0.0))


def swinging(hz, seconds, period_s, amplitude):
    """Times (ms), headings (rad) and yaw rates (rad/s) of a vehicle that swings about the vertical."""
    pulse = 2.0 * pi / period_s
    for k in range(int(seconds * hz) + 1):
        t = k / hz
        yield round(1000 * t), amplitude * sin(pulse * t), amplitude * pulse * cos(pulse * t)


def swing_track(reference_hz, gyro_hz=0):
    """A track of a reference that swings by 30 degrees in 4 s, and the gyro of the vehicle."""
    track = ReferenceTrack()
    knots = {t: (angle, rate) for t, angle, rate in swinging(reference_hz, 8.0, 4.0, radians(30.0))}
    gyro = {t: rate for t, _, rate in swinging(gyro_hz, 8.0, 4.0, radians(30.0))} if gyro_hz else {}
    for t_ms in sorted({*knots, *gyro}):
        if t_ms in gyro:
            track.add_rates(t_ms * MS, (0.0, 0.0, gyro[t_ms]))
        if t_ms in knots:
            angle, rate = knots[t_ms]
            track.add(t_ms * MS, q_heading(angle), (0.0, 0.0, rate))
    return track


def found(track, angles):
    """Errors (rad) of the track at these times where it has an attitude, and the reasons where it has none."""
    errors, lacks = [], []
    for t_ms, angle, _ in angles:
        q = attitude_at(track, t_ms * MS)
        if q is None:
            lacks.append(track.lack(t_ms * MS))
        else:
            errors.append(abs(heading_between(q, q_heading(angle))))
    return errors, lacks


def recent():
    return [one for one in swinging(50, 8.0, 4.0, radians(30.0)) if one[0] >= 4000]


@pytest.mark.parametrize(("hz", "share"), [(10.0, 1.0), (4.0, 1.0), (2.0, 0.45)])
def test_a_slow_reference_is_bridged_as_far_as_its_rates_allow(hz, share):
    errors, lacks = found(swing_track(hz), recent())
    assert len(errors) >= share * (len(errors) + len(lacks))
    assert max(errors) < MAX_ERROR


def test_a_reference_that_turns_between_its_samples_is_bridged_by_the_gyro():
    without, lacks = found(swing_track(1.0), recent())
    assert set(lacks) == {Lack.UNEVEN}
    assert len(lacks) > len(without)
    errors, lacks = found(swing_track(1.0, gyro_hz=25.0), recent())
    assert lacks == []
    assert max(errors) < radians(0.05)


def test_the_gyros_bias_does_not_turn_the_bridge():
    track = ReferenceTrack()
    for k in range(101):
        track.add_rates(20 * k * MS, (0.0, 0.0, 0.02))
    for t_ms in (0, 1000, 2000):
        track.add(t_ms * MS, q_heading(0.4 if t_ms else 0.0), None)
    q = attitude_at(track, 1500 * MS)
    assert q is not None
    assert heading_between(q, q_heading(0.4)) == pytest.approx(0.0, abs=1e-9)


def test_a_reference_without_rates_that_turned_far_is_not_bridged_without_a_gyro():
    track = ReferenceTrack()
    track.add(0, q_heading(0.0), None)
    track.add(500 * MS, q_heading(radians(20.0)), None)
    assert attitude_at(track, 250 * MS) is None
    assert track.lack(250 * MS) == Lack.UNEVEN
    for t_ms in range(0, 501, 20):
        track.add_rates(t_ms * MS, (0.0, 0.0, radians(40.0)))
    track.add(1000 * MS, q_heading(radians(20.0)), None)
    q = attitude_at(track, 125 * MS)
    assert q is not None
    assert heading_between(q, q_heading(radians(5.0))) == pytest.approx(0.0, abs=1e-9)


def test_out_of_order_samples_are_dropped():
    track = ReferenceTrack()
    track.add(100 * MS, q_heading(0.1), None)
    track.add(200 * MS, q_heading(0.12), None)
    track.add(150 * MS, q_heading(3.0), None)
    q = attitude_at(track, 150 * MS)
    assert q is not None
    assert heading_between(q, q_heading(0.11)) == pytest.approx(0.0, abs=1e-12)


def test_a_restarted_clock_forgets_everything_before():
    track = ReferenceTrack()
    track.add(900_000 * MS, q_heading(0.1), None)
    track.add(2000 * MS, q_heading(0.2), None)
    assert attitude_at(track, 900_000 * MS) is None
    assert attitude_at(track, 2000 * MS) == q_heading(0.2)


def test_memory_is_bounded_and_recent_times_stay():
    track = ReferenceTrack()
    for k in range(100_000):
        track.add(k * 10 * MS, q_heading(0.0), None)
    assert len(track._times) <= 801
    assert attitude_at(track, (99_999 * 10 - 3999) * MS) is not None


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-3, 1.0, 3.0])
def test_half_rotation_vector_inverts_the_exponential(angle):
    u = (0.5 * angle * 0.6, 0.0, 0.5 * angle * -0.8)
    w, x, y, z = q_exp(u)
    assert half_rotation_vector((w, x, y, z)) == pytest.approx(u, abs=1e-15)
    assert half_rotation_vector((-w, -x, -y, -z)) == pytest.approx(u, abs=1e-15)
