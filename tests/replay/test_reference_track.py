from math import radians

import pytest

from attest_mav.algebra import heading_between, q_exp, q_from_euler, q_heading, q_mul
from attest_mav.replay.reference_track import ReferenceTrack, half_rotation_vector

MS = 1_000_000


def test_halfway_without_rates_is_half_the_turn():
    track = ReferenceTrack()
    track.add(0, q_heading(radians(10.0)), None)
    track.add(100 * MS, q_heading(radians(30.0)), None)
    q = track.at(50 * MS)
    assert q is not None
    assert heading_between(q, q_heading(0.0)) == pytest.approx(radians(20.0))


def test_the_short_way_round_when_the_quaternion_changes_sign():
    track = ReferenceTrack()
    track.add(0, q_heading(radians(10.0)), None)
    w, x, y, z = q_heading(radians(20.0))
    track.add(100 * MS, (-w, -x, -y, -z), None)
    q = track.at(50 * MS)
    assert q is not None
    assert heading_between(q, q_heading(0.0)) == pytest.approx(radians(15.0))


def test_rates_bend_the_path_as_the_vehicle_did():
    # A yaw of psi = a t^3 is a cubic, which the interpolation holds exactly: psi(0.25 s) of psi = 8 t^3 is 0.125.
    track = ReferenceTrack()
    track.add(0, q_heading(0.0), (0.0, 0.0, 0.0))
    track.add(250 * MS, q_heading(8.0 * 0.25**3), (0.0, 0.0, 24.0 * 0.25**2))
    q = track.at(100 * MS)
    assert q is not None
    assert heading_between(q, q_heading(0.0)) == pytest.approx(8.0 * 0.1**3)


def test_a_steady_turn_about_a_slanted_axis_is_kept():
    rates = (0.8, -0.6, 1.0)
    start = q_from_euler(0.3, -0.2, 2.0)

    def turned(seconds):
        return q_mul(start, q_exp(tuple(0.5 * seconds * rate for rate in rates)))

    track = ReferenceTrack()
    track.add(0, start, rates)
    track.add(200 * MS, turned(0.2), rates)
    q = track.at(70 * MS)
    assert q is not None
    assert q == pytest.approx(turned(0.07), abs=1e-12)


def test_a_stamp_stands_for_its_whole_millisecond():
    track = ReferenceTrack()
    first = q_heading(1.0)
    track.add(8484 * MS, first, None)
    assert track.reaches(8484 * MS + 105_000)
    assert track.at(8484 * MS + 105_000) == first
    assert not track.reaches(8485 * MS)
    assert track.at(8485 * MS) is None


def test_nothing_is_said_outside_or_in_a_gap():
    track = ReferenceTrack()
    for t_ms in (1000, 1350, 1701):
        track.add(t_ms * MS, q_heading(0.0), None)
    assert track.at(999 * MS) is None
    assert track.at(1200 * MS) is not None  # 350 ms between samples: the longest that is bridged
    assert track.at(1500 * MS) is None  # 351 ms
    assert track.at(1702 * MS) is None


def test_out_of_order_samples_are_dropped():
    track = ReferenceTrack()
    track.add(100 * MS, q_heading(0.1), None)
    track.add(200 * MS, q_heading(0.2), None)
    track.add(150 * MS, q_heading(3.0), None)
    q = track.at(150 * MS)
    assert q is not None
    assert heading_between(q, q_heading(0.15)) == pytest.approx(0.0, abs=1e-12)


def test_a_restarted_clock_forgets_everything_before():
    track = ReferenceTrack()
    track.add(900_000 * MS, q_heading(0.1), None)
    track.add(2000 * MS, q_heading(0.2), None)
    assert track.at(900_000 * MS) is None
    assert track.at(2000 * MS) == q_heading(0.2)


def test_memory_is_bounded_and_recent_times_stay():
    track = ReferenceTrack()
    for k in range(100_000):
        track.add(k * 10 * MS, q_heading(0.0), None)
    assert len(track._times) <= 801
    assert track.at((99_999 * 10 - 3999) * MS) is not None


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-3, 1.0, 3.0])
def test_half_rotation_vector_inverts_the_exponential(angle):
    u = (0.5 * angle * 0.6, 0.0, 0.5 * angle * -0.8)
    w, x, y, z = q_exp(u)
    assert half_rotation_vector((w, x, y, z)) == pytest.approx(u, abs=1e-15)
    assert half_rotation_vector((-w, -x, -y, -z)) == pytest.approx(u, abs=1e-15)
