"""Outputs of the pipeline: events of a lane, and verdicts. Estimates are events too."""

from enum import IntEnum
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.estimate import Estimate


class LaneEventKind(IntEnum):
    """Kind of a lane's event."""

    ALIGNED = 0
    """Alignment succeeded; estimates follow."""
    GAP = 1
    """Samples are missing (0.1 to 1 s); the filter goes on across the gap."""
    RESTARTED = 2
    """More than 1 s of samples is missing, or the filter failed: alignment starts again."""
    REBOOTED = 3
    """The sensor clock went back: the autopilot restarted, and so does alignment."""
    STOPPED = 4
    """No usable sample for the configured time: nothing is published."""
    FROZEN = 5
    """The sensor repeats one reading while it claims to turn: its samples are ignored until they change."""
    HEADING_LOST = 6
    """No magnetometer for 10 s: the heading is dead-reckoned."""
    HEADING_FOUND = 7
    """The magnetometer is back."""
    DISPUTED = 8
    """Two inertial sensors, or the attitudes on them, differ by more than they should."""
    FAULTY = 9
    """The sensor is at fault and set aside; the text names the fault."""
    RETURNED = 10
    """A sensor that was set aside reads like the others again, and is used."""
    CONTRADICTED = 11
    """A velocity fix contradicts all lanes: none is used until an explanation is found."""
    EXPLAINED = 12
    """The explanation that is believed: a receiver that makes no sense, is off or late, or sensors that stepped."""
    RECEIVER_USED = 13
    """The receiver makes sense again."""
    DELAYED = 14
    """Samples come, but later than the configured time: nothing is published."""
    IN_TIME = 15
    """They come in time again."""
    CALIBRATED = 16
    """The filter begins with the sensor's errors by earlier flights."""
    UNCALIBRATED = 17
    """This flight contradicts them, or the sensor is another one: they count as unknown."""
    RECALIBRATED = 18
    """The autopilot's own calibration of the sensor has changed: the errors are taken less that change."""


@mypyc_attr(acyclic=True)  # as Sample
class LaneEvent:
    """Something a person may want to know about a lane. ``text`` is one line for the log."""

    def __init__(self, lane: str, kind: LaneEventKind, t_ns: int, rx_ns: int, text: str) -> None:
        self.lane: Final = lane
        self.kind: Final = kind
        self.t_ns: Final = t_ns
        self.rx_ns: Final = rx_ns
        self.text: Final = text


class Agreement(IntEnum):
    """The verdict on the autopilot's attitude."""

    UNDECIDED = 0
    AGREE = 1
    DISAGREE = 2


@mypyc_attr(acyclic=True, free_list_len=1)  # as Sample
class Verdict:
    """Whether the autopilot's attitude agrees with ours, and the reason.

    reason: a code for machines, one of ``attest_mav.estimation.verdict.REASONS``. tilt, heading: the differences,
    rad, NaN where they cannot be compared. source: the message judged. offset: roll and pitch of a steady offset that
    was found where the autopilot's trim is not known, rad; None without one.
    """

    def __init__(
        self,
        agreement: Agreement,
        reason: str,
        tilt: float,
        heading: float,
        source: str,
        t_ns: int,
        rx_ns: int,
        offset: tuple[float, float] | None = None,
    ) -> None:
        self.agreement: Final = agreement
        self.reason: Final = reason
        self.tilt: Final = tilt
        self.heading: Final = heading
        self.source: Final = source
        self.t_ns: Final = t_ns
        self.rx_ns: Final = rx_ns
        self.offset: Final = offset


Event = Estimate | LaneEvent | Verdict
