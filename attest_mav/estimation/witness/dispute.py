"""A dispute between two lanes, and the evidence by which one of them is found at fault.

Differences open a dispute and keep it open; guilt is found by the receiver and by the magnetic field, which know
nothing of the inertial sensors.
"""

from typing import Final

from attest_mav.algebra import sub
from attest_mav.estimation.witness.flight_state import accel_bias
from attest_mav.estimation.witness.lane_watch import LaneWatch
from attest_mav.estimation.witness.pair import (
    Contrast,
    Difference,
    PairedReading,
    RunningDifference,
    contrast,
    contrast_of_states,
)
from attest_mav.types import Vec3

HOLD_NS: Final = 2_000_000_000
"""A dispute ends this long after the last difference."""
FRESH_NS: Final = 500_000_000
"""Evidence counts for this long after a difference."""
GUILT: Final = 6.0
"""Evidence from which on a lane is at fault."""
INNOCENT_NIS: Final = 4.0
"""The other lane's fix must fit this well."""
LARGEST_NIS: Final = 18.0
"""One fix counts for no more."""
READING_APART_NS: Final = 60_000_000
"""Readings of the field in two lanes belong together when they are no further apart."""
WELL_NS: Final = 3_000_000_000
"""A lane that stands aside is well again after this long without a difference."""
PAIRED_S: Final = 0.6
"""Samples of two lanes belong together when they are apart by less than this share of a step."""


class Dispute:
    """One dispute. Every change makes a new one.

    opened_ns: its beginning. seen_ns: the last difference. evidence: against the first lane; below zero against the
    second. fix_ns, reading_ns: the newest fix and reading that were weighed. gyro_offset, accel_offset: biases of the
    first lane less those of the second as they were when it was opened.
    """

    def __init__(
        self,
        opened_ns: int,
        seen_ns: int,
        evidence: float,
        fix_ns: int,
        reading_ns: int,
        gyro_offset: Vec3,
        accel_offset: Vec3,
    ) -> None:
        self.opened_ns: Final = opened_ns
        self.seen_ns: Final = seen_ns
        self.evidence: Final = evidence
        self.fix_ns: Final = fix_ns
        self.reading_ns: Final = reading_ns
        self.gyro_offset: Final = gyro_offset
        self.accel_offset: Final = accel_offset

    def seen(self, now_ns: int) -> "Dispute":
        """There is a difference now."""
        return Dispute(
            self.opened_ns, now_ns, self.evidence, self.fix_ns, self.reading_ns, self.gyro_offset, self.accel_offset
        )

    def weighed(self, evidence: float, fix_ns: int, reading_ns: int) -> "Dispute":
        """More evidence, from this fix or reading."""
        return Dispute(self.opened_ns, self.seen_ns, evidence, fix_ns, reading_ns, self.gyro_offset, self.accel_offset)


class LanePair:
    """Two lanes side by side."""

    def __init__(self, first: LaneWatch, second: LaneWatch) -> None:
        self.first: Final = first
        self.second: Final = second
        self.recent: Final = RunningDifference(0.5)
        self.second_long: Final = RunningDifference(1.0)
        self.longer: Final = RunningDifference(2.0)
        self.dispute: Dispute | None = None
        self.contrast: Contrast | None = None
        """The newest comparison of two lanes in good standing."""
        self.has_scale = False
        """Whether the sizes of the accelerometers' biases have been compared."""
        self._paired_ns = (-1, -1)
        self._differed_ns = -1

    def has(self, lane: LaneWatch) -> bool:
        """Whether the lane is one of the two."""
        return lane is self.first or lane is self.second

    def other(self, lane: LaneWatch) -> LaneWatch:
        """The lane beside this one."""
        return self.second if lane is self.first else self.first

    def pair_up(self) -> bool:
        """Take the newest sample of each lane if both are new and belong together."""
        a, b = self.first.moments.newest, self.second.moments.newest
        if a is None or b is None or a.t_ns == self._paired_ns[0] or b.t_ns == self._paired_ns[1]:
            return False
        if abs(a.t_ns - b.t_ns) * 1e-9 > PAIRED_S * max(a.dt_s, b.dt_s):
            return False
        self._paired_ns = (a.t_ns, b.t_ns)
        reading = PairedReading(a.t_ns, sub(a.sample.gyro, b.sample.gyro), sub(a.sample.accel, b.sample.accel))
        self.recent.take(reading)
        self.second_long.take(reading)
        self.longer.take(reading)
        return True

    def compare(self, now_ns: int) -> None:
        """Compare two lanes in good standing: opens, prolongs and ends the dispute."""
        a, b = self.first.state, self.second.state
        if a is None or b is None or not self.recent.spans:
            return
        self.contrast = contrast_of_states(self.recent.difference(), a, b)
        dispute = self.dispute
        if self.contrast.differs:
            if dispute is None:
                gyro, accel = sub(a.gyro_bias, b.gyro_bias), sub(accel_bias(a), accel_bias(b))
                fix_ns = -1 if self.first.fix is None else self.first.fix.t_ns
                dispute = Dispute(now_ns, now_ns, 0.0, fix_ns, now_ns, gyro, accel)
            self.dispute = dispute.seen(now_ns)
        elif dispute is not None and now_ns - dispute.seen_ns > HOLD_NS:
            self.dispute = None

    def end(self) -> None:
        """The dispute is over: one of the lanes is no longer in good standing."""
        self.dispute = self.contrast = None

    def weigh(self, now_ns: int, receiver_used: bool) -> None:
        """Add what the newest fix and reading of both lanes tell."""
        dispute = self.dispute
        if dispute is None or now_ns - dispute.seen_ns > FRESH_NS:
            return
        evidence, fix_ns, reading_ns = dispute.evidence, dispute.fix_ns, dispute.reading_ns
        a, b = self.first.fix, self.second.fix
        if receiver_used and a is not None and b is not None and a.t_ns == b.t_ns != fix_ns:
            evidence += min(a.nis, LARGEST_NIS) - min(b.nis, LARGEST_NIS)
            fix_ns = a.t_ns
        f, g = self.first.field, self.second.field
        if min(f.t_ns, g.t_ns) > reading_ns and abs(f.t_ns - g.t_ns) < READING_APART_NS:
            evidence += 0.5 * (f.score - g.score)
            reading_ns = max(f.t_ns, g.t_ns)
        self.dispute = dispute.weighed(evidence, fix_ns, reading_ns)

    def guilty(self, now_ns: int, receiver_used: bool) -> LaneWatch | None:
        """The lane at fault, None while that is not clear."""
        dispute = self.dispute
        if dispute is None or abs(dispute.evidence) <= GUILT or now_ns - dispute.seen_ns > FRESH_NS:
            return None
        lane = self.first if dispute.evidence > 0.0 else self.second
        other = self.other(lane).fix
        if receiver_used and other is not None and other.nis >= INNOCENT_NIS:
            return None
        return lane

    def excess_of(self, lane: LaneWatch) -> tuple[Vec3, Vec3]:
        """Readings of this lane minus the other's, rad/s and m/s^2, with the biases from before the dispute."""
        dispute, difference = self.dispute, self.recent.difference()
        gyro, accel = difference.gyro, difference.accel
        if dispute is not None:
            gyro, accel = sub(gyro, dispute.gyro_offset), sub(accel, dispute.accel_offset)
        if lane is self.first:
            return gyro, accel
        return (-gyro[0], -gyro[1], -gyro[2]), (-accel[0], -accel[1], -accel[2])

    def aside_is_well(self, aside: LaneWatch, now_ns: int) -> bool:
        """True once a lane that stands aside has read like the other one, by its old biases, for long enough."""
        healthy = self.other(aside).state
        if healthy is None or not self.recent.spans or aside.dead.reason:
            self._differed_ns = now_ns
            return False
        gyro, accel = sub(aside.gyro_bias, healthy.gyro_bias), sub(aside.accel_bias, accel_bias(healthy))
        if aside is self.second:
            gyro, accel = (-gyro[0], -gyro[1], -gyro[2]), (-accel[0], -accel[1], -accel[2])
        if contrast(self.recent.difference(), gyro, accel).differs:
            self._differed_ns = now_ns
        return now_ns - self._differed_ns > WELL_NS

    def begin_watching(self, now_ns: int) -> None:
        """A lane has been set aside: its time without a difference begins now."""
        self._differed_ns = now_ns

    def reads_more(self, aside: LaneWatch) -> Difference:
        """The difference over the longer time, as what the lane that stands aside reads more."""
        found = self.longer.difference()
        if aside is self.first:
            return found
        gyro, accel = found.gyro, found.accel
        return Difference(
            (-gyro[0], -gyro[1], -gyro[2]),
            (-accel[0], -accel[1], -accel[2]),
            found.accel_scatter,
            found.count,
        )
