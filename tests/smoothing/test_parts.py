"""A flight smoothed in parts: the same attitudes as in one, from no more rows at a time."""

from dataclasses import fields
from tempfile import TemporaryFile

import numpy as np
import pytest

from attest_mav import FlightParameters, Readings
from attest_mav.estimation.sequence_rows import Columns
from attest_mav.library.running import sequence_of, stretches
from attest_mav.smoothing import tables
from attest_mav.smoothing.recorder import Recorder
from attest_mav.smoothing.tables import Scratch
from attest_mav.smoothing.trajectory import SmoothedParts, SmoothedSamples

PARAMETERS = FlightParameters()


@pytest.fixture
def recorded():
    with Scratch(TemporaryFile) as scratch:

        def record(readings):
            recorder = Recorder(PARAMETERS, scratch)
            for _ in stretches(sequence_of(recorder, readings), readings, Columns):
                pass
            return recorder.recording()

        yield record


def flight(flown, times=1):
    """Flown again and again."""
    columns = (flown.gyro, flown.accel, flown.mag, flown.velocity)
    t = np.arange(times * len(flown.t)) * 0.02
    return t, *(np.tile(one, (times, 1)) for one in columns)


def with_a_gap_and_a_magnet(flown):
    t, gyro, accel, mag, velocity = flight(flown)
    mag = mag + np.where((t > 25.0) & (t < 30.0), 0.1, 0.0)[:, np.newaxis]
    kept = (t < 12.0) | (t >= 17.0)
    return Readings(*(one[kept] for one in (t, gyro, accel, mag, velocity)), declination=0.0)


def in_the_hand_beside_iron(flown):
    """The iron comes off after a while, so that each part of the readings has its own."""
    t, gyro, accel, mag, _ = flight(flown)
    mag = mag + np.where(t < 25.0, 0.1, 0.0)[:, np.newaxis]
    return Readings(t, gyro, accel, mag, declination=0.0)


@pytest.mark.parametrize("readings", [with_a_gap_and_a_magnet, in_the_hand_beside_iron])
def test_small_parts_are_the_same_as_one(flown, readings, recorded, monkeypatch):
    readings = readings(flown)
    whole = SmoothedParts(recorded(readings), PARAMETERS).whole()
    monkeypatch.setattr(tables, "RUN", 97)
    parts = SmoothedParts(recorded(readings), PARAMETERS, intervals=17)
    assert len(list(parts)) > 8
    found = parts.whole()
    for one in fields(SmoothedSamples):
        np.testing.assert_allclose(getattr(found, one.name), getattr(whole, one.name), rtol=0.0, atol=1e-9)


def most_rows_at_once(recording, monkeypatch):
    """Of a table, while a recording is smoothed."""
    most = 0
    rows = tables.Table.rows

    def counted(table, first, end):
        nonlocal most
        most = max(most, end - first)
        return rows(table, first, end)

    with monkeypatch.context() as patch:
        patch.setattr(tables.Table, "rows", counted)
        for _ in SmoothedParts(recording, PARAMETERS, intervals=20):
            pass
    return most


def test_no_more_rows_are_held_of_a_longer_flight(flown, recorded, monkeypatch):
    monkeypatch.setattr(tables, "RUN", 150)
    short, long = (recorded(Readings(*flight(flown, times), declination=0.0)) for times in (1, 3))
    assert len(long.readings) == len(short.readings) + 2 * len(flown.t)
    most = most_rows_at_once(short, monkeypatch)
    assert 200 < most < 220  # 20 intervals of 10 readings, and the reading before them
    assert most_rows_at_once(long, monkeypatch) == most
