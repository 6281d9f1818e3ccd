"""The magnetic field between an autopilot and us, on attitudes and readings made for it; 10 Hz."""

from math import cos, radians, sin

import pytest

from attest_mav.algebra import add, q_exp, rotate, unit
from attest_mav.estimation.field_evidence import FieldEvidence, FieldReading

FIELD = unit((0.24, 0.0, -0.5))
S = 1_000_000_000
LEVEL = (0.0, 0.0, 0.0)


def turn(degrees_of):
    """The rotation of NED by these angles, deg."""
    return q_exp(tuple(0.5 * radians(angle) for angle in degrees_of))


class Readings:
    """Readings of a field that stays, with attitudes of both sides that are off; 3 s in which both are right first."""

    def __init__(self):
        self.evidence = FieldEvidence()
        self.tenths = 0
        self.field = FIELD
        self.go_on(3.0, agree=True)

    def go_on(self, seconds, ours=LEVEL, theirs=LEVEL, agree=False):
        """ours, theirs: how far an attitude is off, rotation of NED, deg."""
        ours_q, theirs_q = turn(ours), turn(theirs)
        between = turn(tuple(b - a for a, b in zip(ours, theirs, strict=True)))
        assert rotate(between, rotate(ours_q, FIELD)) == pytest.approx(rotate(theirs_q, FIELD))
        for _ in range(round(10 * seconds)):
            self.tenths += 1
            reading = FieldReading(self.field, LEVEL, ours_q, self.tenths * S // 10)
            self.evidence.take(reading, between, agree)

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
    readings.field = add(FIELD, (0.0, 0.2, 0.0))
    readings.go_on(0.5, agree=True)
    readings.go_on(1.0, theirs=(0.0, 0.0, 10.0))
    assert not readings.forbids()


def test_the_evidence_follows_when_the_other_side_goes_wrong():
    readings = Readings()
    readings.go_on(30.0, theirs=(5.0, 0.0, 0.0))
    readings.go_on(1.0, ours=(5.0, 0.0, 0.0))
    assert readings.forbids()


def test_without_readings_the_field_forbids_nothing():
    assert not FieldEvidence().forbids(0, by_heading=True)
    readings = Readings()
    readings.go_on(1.0, ours=(0.0, 0.0, 8.0))
    assert readings.forbids(later_s=1.0)
    assert not readings.forbids(later_s=2.0)


@pytest.mark.parametrize(
    ("dip_deg", "earths_deg", "tells_none"), [(64.0, 70.0, False), (35.0, 70.0, True), (-70.0, 70.0, True)]
)
def test_a_heading_that_never_agreed_counts_only_in_a_field_that_can_be_the_earths(dip_deg, earths_deg, tells_none):
    field = (0.5 * cos(radians(dip_deg)), 0.0, 0.5 * sin(radians(dip_deg)))
    evidence = FieldEvidence()
    level, apart = (1.0, 0.0, 0.0, 0.0), turn((0.0, 0.0, 40.0))
    for k in range(1, 50):
        evidence.take(FieldReading(field, (0.0, 0.0, 0.0), level, k * S // 10, radians(earths_deg)), apart, agree=False)
    assert evidence.tells_no_heading is tells_none
    unknown = FieldReading(field, (0.0, 0.0, 0.0), level, 6 * S)
    evidence.take(unknown, apart, agree=False)
    assert not evidence.tells_no_heading


def test_without_a_reading_a_heading_counts_once_it_has_agreed():
    evidence = FieldEvidence()
    assert evidence.tells_no_heading
    evidence.note_agreement()
    assert not evidence.tells_no_heading


def test_headings_that_agreed_once_are_compared_in_any_field():
    readings = Readings()
    readings.evidence.note_agreement()
    foreign = FieldReading((0.5, 0.0, 0.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), 9 * S, radians(70.0))
    readings.evidence.take(foreign, turn((0.0, 0.0, 40.0)), agree=False)
    assert not readings.evidence.tells_no_heading
