"""Series in constant memory: no peak is lost, however long the flight; windows have the figures of their readings."""

from math import nan, sqrt
from statistics import pvariance

import pytest

from attest_mav.report.envelope import Envelope
from attest_mav.report.windows import Windows


def test_a_short_series_is_kept_whole():
    points = [(0.02 * k, float(k % 7)) for k in range(1500)]
    envelope = Envelope()
    for point in points:
        envelope.add(*point)
    assert envelope.points == points


def test_a_long_series_keeps_its_peaks_within_its_bound():
    envelope = Envelope(most=100)
    for k in range(50_000):
        envelope.add(0.02 * k, {31_234: 90.0, 44_001: -80.0}.get(k, 0.001 * (k % 5)))
    points = envelope.points
    assert 100 <= len(points) <= 200
    assert (0.02 * 31_234, 90.0) in points
    assert (0.02 * 44_001, -80.0) in points
    assert points == sorted(points, key=lambda point: point[0])
    assert points[0][0] < 20.0
    assert points[-1][0] > 980.0


def test_a_pause_stays_a_pause():
    envelope = Envelope(most=50)
    for k in range(4000):
        envelope.add(0.02 * k + (300.0 if k >= 2000 else 0.0), float(k))
    times = [t_s for t_s, _ in envelope.points]
    assert not [t_s for t_s in times if 40.0 <= t_s < 340.0]


@pytest.mark.parametrize("bad", [(1.0, nan), (nan, 1.0), (0.5, 2.0)])
def test_what_is_no_point_is_left_out(bad):
    envelope = Envelope()
    envelope.add(1.0, 3.0)
    envelope.add(*bad)
    assert envelope.points == [(1.0, 3.0)]


def test_windows_have_the_spread_of_their_readings():
    readings = [(0.1 * k, -9.81 + 0.3 * (k % 3), 1.0) for k in range(10)]
    windows = Windows(1.0)
    ended = [windows.add(0.1 * k, reading) for k, reading in enumerate(readings)]
    assert ended == [None] * 10
    window = windows.add(1.05, (0.0, 0.0, 0.0))
    assert window.middle_s == 0.5
    assert window.spread == pytest.approx(sqrt(sum(pvariance(axis) for axis in zip(*readings, strict=True))))
    assert window.mean == pytest.approx(0.45)
    assert window.total == pytest.approx(4.5)
    assert windows.finish().middle_s == 1.5
    assert windows.finish() is None
