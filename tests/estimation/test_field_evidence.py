"""The magnetic field between an autopilot and us, on attitudes and readings made for it; 10 Hz."""

from math import cos, radians, sin

import pytest

from attest_mav.algebra import add, q_exp, rotate, unit
from attest_mav.estimation.field_evidence import FieldReading
from attest_mav.estimation.field_support import FieldSupport

FIELD = unit((0.24, 0.0, -0.5))
S = 1_000_000_000
LEVEL = (0.0, 0.0, 0.0)


def turn(degrees_of):
    """The rotation of NED by these angles, deg."""
    return q_exp(tuple(0.5 * radians(angle) for angle in degrees_of))


LANE = "RAW_IMU"
SECOND = "SCALED_IMU2"


class Readings:
    """Readings of a field that stays, with attitudes of both sides that are off; 3 s in which both are right first.

    second: of another magnetometer, None without one; each one's field is in NED by a right attitude. lane: the one
    whose attitude levels the readings.
    """

    def __init__(self, second=None):
        self.lane = LANE
        self.evidence = FieldSupport()
        self.tenths = 0
        self.fields = {LANE: FIELD} if second is None else {LANE: FIELD, SECOND: second}
        self.go_on(3.0, agree=True)

    def go_on(self, seconds, ours=LEVEL, theirs=LEVEL, agree=False):
        """ours, theirs: how far an attitude is off, rotation of NED, deg."""
        ours_q, theirs_q = turn(ours), turn(theirs)
        between = turn(tuple(b - a for a, b in zip(ours, theirs, strict=True)))
        assert rotate(between, rotate(ours_q, FIELD)) == pytest.approx(rotate(theirs_q, FIELD))
        for _ in range(round(10 * seconds)):
            self.tenths += 1
            now_ns = self.tenths * S // 10
            readings = {
                name: FieldReading(field, LEVEL, self.lane, ours_q, now_ns) for name, field in self.fields.items()
            }
            self.evidence.take(readings, LANE, between, agree, now_ns)

    def forbids(self, by_heading=True, later_s=0.0):
        return self.evidence.forbids(self.tenths * S // 10 + round(later_s * S), by_heading)


@pytest.mark.parametrize("off", [(0.0, 0.0, 8.0), (4.0, 0.0, 0.0), (0.0, -4.0, 0.0)])
def test_the_attitude_under_which_the_field_stays_is_the_right_one(off):
    readings = Readings()
    readings.go_on(0.5, theirs=off)
    assert not readings.forbids()
    readings = Readings()
    readings.go_on(60.0, ours=off)
    assert readings.forbids()


def test_a_heading_that_nothing_supports_yet_accuses_nobody():
    readings = Readings()
    readings.go_on(0.1, ours=(0.0, 0.0, -1.0), theirs=(0.0, 0.0, 1.0))
    assert readings.forbids()


def test_a_tilt_that_the_field_does_not_show_needs_no_support():
    about_the_field = tuple(5.0 * share for share in FIELD)
    readings = Readings()
    readings.go_on(1.0, theirs=about_the_field)
    assert not readings.forbids(by_heading=False)
    assert readings.forbids(by_heading=True)


def test_a_magnetometer_that_changes_at_once_speaks_for_nobody():
    readings = Readings()
    readings.fields[LANE] = add(FIELD, (0.0, 0.2, 0.0))
    readings.go_on(0.5, agree=True)
    readings.go_on(1.0, theirs=(0.0, 0.0, 10.0))
    assert not readings.forbids()


def test_the_evidence_follows_when_the_other_side_goes_wrong():
    readings = Readings()
    readings.go_on(30.0, theirs=(5.0, 0.0, 0.0))
    readings.go_on(1.0, ours=(5.0, 0.0, 0.0))
    assert readings.forbids()


def test_without_readings_the_field_forbids_nothing():
    assert not FieldSupport().forbids(0, by_heading=True)
    readings = Readings()
    readings.go_on(1.0, ours=(0.0, 0.0, 8.0))
    assert readings.forbids(later_s=1.0)
    assert not readings.forbids(later_s=2.0)


@pytest.mark.parametrize(
    ("dip_deg", "earths_deg", "tells_none"), [(64.0, 70.0, False), (35.0, 70.0, True), (-70.0, 70.0, True)]
)
def test_a_heading_that_never_agreed_counts_only_in_a_field_that_can_be_the_earths(dip_deg, earths_deg, tells_none):
    field = (0.5 * cos(radians(dip_deg)), 0.0, 0.5 * sin(radians(dip_deg)))
    evidence = FieldSupport()
    level, apart = (1.0, 0.0, 0.0, 0.0), turn((0.0, 0.0, 40.0))
    for k in range(1, 50):
        reading = FieldReading(field, LEVEL, LANE, level, k * S // 10, radians(earths_deg))
        evidence.take({LANE: reading}, LANE, apart, False, reading.t_ns)
    assert evidence.tells_no_heading(LANE) is tells_none
    unknown = FieldReading(field, LEVEL, LANE, level, 6 * S)
    evidence.take({LANE: unknown}, LANE, apart, False, unknown.t_ns)
    assert not evidence.tells_no_heading(LANE)


def test_without_a_reading_a_heading_counts_once_it_has_agreed():
    evidence = FieldSupport()
    assert evidence.tells_no_heading(LANE)
    evidence.note_agreement()
    assert not evidence.tells_no_heading(LANE)


def test_headings_that_agreed_once_are_compared_in_any_field():
    readings = Readings()
    readings.evidence.note_agreement()
    foreign = FieldReading((0.5, 0.0, 0.0), LEVEL, LANE, (1.0, 0.0, 0.0, 0.0), 9 * S, radians(70.0))
    readings.evidence.take({LANE: foreign}, LANE, turn((0.0, 0.0, 40.0)), False, foreign.t_ns)
    assert not readings.evidence.tells_no_heading(LANE)


OFF = (0.0, 0.0, 8.0)
FOLLOWS_OURS = rotate(turn((0.0, 0.0, -8.0)), FIELD)
"""The field by a magnetometer that has led our heading away by as much as ``OFF``."""


def test_a_magnetometer_that_leads_our_heading_away_accuses_nobody_beside_another_one():
    alone, both = Readings(), Readings(second=FIELD)
    for readings in (alone, both):
        readings.fields[LANE] = FOLLOWS_OURS
        readings.go_on(3.0, ours=OFF)
    assert not alone.forbids()
    assert both.forbids()


def test_a_magnetometer_that_has_fallen_silent_has_no_say():
    readings = Readings(second=FIELD)
    readings.fields[LANE] = FOLLOWS_OURS
    readings.go_on(3.0, ours=OFF)
    del readings.fields[SECOND]
    readings.go_on(1.0, ours=OFF)
    assert readings.forbids()
    readings.go_on(1.0, ours=OFF)
    assert not readings.forbids()


def test_the_evidence_of_two_magnetometers_adds_up():
    alone, both = Readings(), Readings(second=FIELD)
    for readings in (alone, both):
        readings.go_on(2.0, theirs=(0.0, 0.0, 1.0))
    assert alone.forbids()
    assert not both.forbids()


def test_readings_levelled_by_another_lane_than_the_one_compared_tell_nothing():
    same, other = Readings(), Readings()
    other.lane = SECOND
    for readings in (same, other):
        readings.go_on(3.0, ours=OFF)
    assert same.forbids()
    assert not other.forbids()


def test_a_heading_that_was_refuted_accuses_nobody_before_both_level_the_field_alike_again():
    readings = Readings()
    readings.go_on(10.0, ours=OFF)
    readings.go_on(10.0, theirs=OFF)
    assert readings.forbids(by_heading=True)
    assert not readings.forbids(by_heading=False)
    readings.go_on(1.0, theirs=(0.0, 0.0, 5.9), agree=True)
    readings.go_on(10.0, theirs=OFF)
    assert readings.forbids(by_heading=True)
    readings.go_on(1.0, agree=True)
    readings.go_on(10.0, theirs=OFF)
    assert not readings.forbids(by_heading=True)
