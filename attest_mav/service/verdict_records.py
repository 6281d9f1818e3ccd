"""The verdict as records of a snapshot: the newest one, its intervals, and the attitude that is judged."""

from dataclasses import dataclass

from attest_mav.estimation.events import Agreement, Verdict
from attest_mav.types import Quat


@dataclass(frozen=True)
class VerdictStanding:
    """The newest verdict, and how long its agreement has stood."""

    verdict: Verdict
    """Agreement, reason and differences."""
    since_ns: int
    """When the agreement became this one, ns of the host's clock."""


@dataclass(frozen=True)
class VerdictSpan:
    """One interval of equal verdicts."""

    agreement: Agreement
    """The verdict."""
    reason: str
    """The reason given with most of its verdicts."""
    begin_ns: int
    """Its first verdict, ns of the host's clock."""
    end_ns: int
    """The first verdict of the next interval, or the newest one so far."""
    peak_tilt: float | None
    """Largest difference in tilt, rad; None where nothing was compared."""
    peak_heading: float | None
    """Largest difference in heading, rad; None where no heading was compared."""


@dataclass(frozen=True)
class AutopilotAttitude:
    """The newest attitude of the autopilot that was compared."""

    source: str
    """The message."""
    q_nb: Quat
    """The attitude in the frame of the inertial sensor: without the trim, as far as that is known."""
    rx_ns: int
    """When it was received, ns of the host's clock."""
