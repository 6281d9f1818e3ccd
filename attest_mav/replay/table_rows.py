"""The rows of a table of compared attitudes, made while a flight is replayed.

An attitude is compared when the reference has passed it, later than it was estimated. What stood beside the estimate
waits for it meanwhile, in order.
"""

from collections import deque
from collections.abc import Sequence
from math import degrees, isfinite
from typing import Final, Protocol

from attest_mav.algebra import q_to_euler, sub
from attest_mav.estimate import Estimate
from attest_mav.estimation.events import LaneEvent, Verdict
from attest_mav.innovation import Aid, Innovation
from attest_mav.replay.columns import Row, residual_names
from attest_mav.replay.comparison import ComparedAttitude
from attest_mav.samples import ImuSample, Sample, VelocitySample
from attest_mav.types import EarthField, Quat, Vec3, VelocityOrigin

SIZES: Final[list[int]] = [len(residual_names(aid)) for aid in Aid]
"""Columns of each aid's residual."""


class RowSink(Protocol):
    """Takes rows, for example a file of a table."""

    def write(self, row: Row) -> None:
        """Take the next row."""


class Beside:
    """What stood beside one estimate."""

    def __init__(self, estimate: Estimate, sample: ImuSample, fix: VelocitySample | None, verdict: Row) -> None:
        self.estimate: Final = estimate
        self.sample: Final = sample
        self.fix: Final = fix
        """The velocity that has come since the estimate before; None for none."""
        self.verdict: Final = verdict


class TableRows:
    """A ``FlightObserver`` that gives the rows of one log to tables."""

    def __init__(self, log: str, sinks: Sequence[RowSink]) -> None:
        self._log: Final = log
        self._sinks: Final = list(sinks)
        self._waiting: Final[dict[str, deque[Beside]]] = {}
        self._verdicts: Final[dict[str, Row]] = {}
        self._fixes: Final[dict[str, VelocitySample]] = {}
        """The newest fix that each filter has had a row for."""
        self._fix: VelocitySample | None = None

    def begin(self, field: EarthField) -> None:
        """The flight begins."""

    def imu(self, sample: ImuSample, elapsed_s: float) -> None:
        """Take the next inertial sample; it comes again with its estimate."""

    def lane_event(self, name: str, event: LaneEvent, elapsed_s: float) -> None:
        """Take the next event of a lane; no column shows it."""

    def reference(self, q_nb: Quat, elapsed_s: float) -> None:
        """Take the next attitude of the reference; it comes again with the attitude that is compared."""

    def vehicle(self, sample: Sample, elapsed_s: float) -> None:
        """Take a velocity of a receiver."""
        if isinstance(sample, VelocitySample) and sample.origin == VelocityOrigin.RECEIVER:
            self._fix = sample

    def verdict(self, name: str, verdict: Verdict, elapsed_s: float) -> None:
        """Take the next verdict beside a filter."""
        angles = [_finite_degrees(verdict.tilt), _finite_degrees(verdict.heading)]
        self._verdicts[name] = [verdict.agreement.name.lower(), verdict.reason, *angles]

    def estimate(self, name: str, estimate: Estimate, sample: ImuSample) -> None:
        """Keep what stands beside an estimate until it is compared."""
        fix = self._fix
        is_new = fix is not None and fix is not self._fixes.get(name)
        if fix is not None:
            self._fixes[name] = fix
        beside = Beside(estimate, sample, fix if is_new else None, self._verdicts.get(name, [None] * 4))
        self._waiting.setdefault(name, deque()).append(beside)

    def write(self, compared: ComparedAttitude) -> None:
        """Give the row of a compared attitude to the tables."""
        waiting = self._waiting.get(compared.name)
        beside = waiting.popleft() if waiting else None
        attitude = compared.attitude
        row: Row = [
            self._log,
            compared.name,
            attitude.elapsed_s,
            attitude.t_ns * 1e-9,
            *_euler(attitude.q_nb),
            *attitude.q_nb,
            attitude.north.name.lower(),
            _finite_degrees(compared.tilt),
            _finite_degrees(compared.heading),
            _finite_degrees(attitude.tilt_sigma),
            _finite_degrees(attitude.heading_sigma),
            int(attitude.counted and compared.tilt is not None),
            *_aid_columns(attitude.innovations),
        ]
        truth = compared.reference
        row += [None] * 7 if truth is None else [*_euler(truth), *truth]
        row += _beside(beside)
        row += _residuals(attitude.innovations)
        row += [None] * 4 if beside is None else beside.verdict
        row.append(attitude.unix_s)
        for sink in self._sinks:
            sink.write(row)


def _beside(beside: Beside | None) -> Row:
    """Lane, rates, gyro bias, accelerometer, magnetometer and fix."""
    if beside is None:
        return [None] * 16
    estimate, sample, fix = beside.estimate, beside.sample, beside.fix
    row: Row = [sample.source, *_degrees(estimate.rates), *_degrees(sub(sample.gyro, estimate.rates)), *sample.accel]
    row += [None] * 3 if sample.mag is None else [*sample.mag]
    if fix is None:
        return [*row, None, None, None]
    north, east, down = fix.v_ned
    return [*row, north, east, down if fix.vertical_known else None]


def _euler(q_nb: Quat) -> Row:
    return [*_degrees(q_to_euler(q_nb))]


def _degrees(vector: Vec3) -> Vec3:
    x, y, z = vector
    return degrees(x), degrees(y), degrees(z)


def _finite_degrees(angle: float | None) -> float | None:
    """None for an angle that is not known."""
    return None if angle is None or not isfinite(angle) else degrees(angle)


def _aid_columns(innovations: tuple[Innovation, ...]) -> Row:
    """Fusion and normalised innovation squared of each aid, None for those without a record."""
    columns: Row = [None] * (2 * len(Aid))
    for innovation in innovations:
        columns[2 * innovation.aid] = innovation.fusion.name.lower()
        nis = innovation.nis
        columns[2 * innovation.aid + 1] = nis if isfinite(nis) else None
    return columns


def _residuals(innovations: tuple[Innovation, ...]) -> Row:
    """The residual of each aid, None for those without one."""
    columns: Row = [None] * sum(SIZES)
    for innovation in innovations:
        first = sum(SIZES[: innovation.aid])
        for index, value in enumerate(innovation.residual[: SIZES[innovation.aid]]):
            columns[first + index] = value if isfinite(value) else None
    return columns
