"""What the autopilot says of itself: the context of a verdict, never its ground.

Kept are the newest report of its estimator, the health of its sensors, the tilt between its own attitudes, and its last
text about lanes and sensors. ``remarks`` puts into words what is bad by the autopilot's own measure.
"""

from math import degrees, radians
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import q_exp, q_mul, scale, tilt_between
from attest_mav.samples import AttitudeSample, Sample
from attest_mav.types import AttitudeForm, AttitudeRole
from attest_mav.vehicle_reports import EstimatorNewsSample, EstimatorStatusSample, SensorHealthSample

FRESH_NS: Final = 5_000_000_000
"""A report older than this tells nothing of the present; reports are requested once a second."""
NEWS_NS: Final = 60_000_000_000
"""A text is quoted for this long."""
BURST_NS: Final = 2_000_000_000
"""Texts of one kind within this time are about one matter: "EKF3 lane switch 1", then "EKF primary changed:1"."""
SAME_NS: Final = 500_000_000
"""Attitudes without a time are compared where they arrive this near to each other."""
INCONSISTENT: Final = radians(10.0)
"""Tilt between two attitudes of one autopilot: ArduPilot's own limit before arming."""


@mypyc_attr(acyclic=True)  # as Sample
class _SecondAttitude:
    """A secondary attitude beside the one that the autopilot flies by."""

    def __init__(self, own: AttitudeSample, other: AttitudeSample) -> None:
        self._own: Final = own
        self._other: Final = other

    @property
    def rx_ns(self) -> int:
        """Time of its reception, ns."""
        return self._other.rx_ns

    @property
    def tilt(self) -> float:
        """The tilt between both, rad."""
        own, other = self._own, self._other
        rates = (0.0, 0.0, 0.0) if own.rates is None else own.rates
        apart_s = (other.rx_ns - own.rx_ns) * 1e-9
        return tilt_between(q_mul(own.q_nb, q_exp(scale(rates, 0.5 * apart_s))), other.q_nb)


class SelfReport:
    """The autopilot's words about itself, since its last boot. Instants are the host's, ns."""

    def __init__(self) -> None:
        self.status: EstimatorStatusSample | None = None
        self.health: SensorHealthSample | None = None
        self.news: EstimatorNewsSample | None = None
        self._own: AttitudeSample | None = None
        self._others: Final[dict[str, _SecondAttitude]] = {}

    def take(self, sample: Sample) -> None:
        """Remember a sample that tells something of the autopilot itself; others are ignored."""
        if isinstance(sample, AttitudeSample):
            self._take_attitude(sample)
        elif isinstance(sample, EstimatorStatusSample):
            self.status = sample
        elif isinstance(sample, SensorHealthSample):
            self.health = sample
        elif isinstance(sample, EstimatorNewsSample):
            self._take_news(sample)

    def remarks(self, now_ns: int) -> tuple[str, ...]:
        """What is bad, each to be read behind "the autopilot itself"; empty while all is well, or nothing is told."""
        return (*self._of_news(now_ns), *self._of_status(now_ns), *self._of_health(now_ns), *self._of_others(now_ns))

    def _take_attitude(self, sample: AttitudeSample) -> None:
        if sample.role == AttitudeRole.AUTOPILOT and sample.form == AttitudeForm.EULER:
            self._own = sample
        own = self._own
        if sample.role != AttitudeRole.SECONDARY or own is None or abs(sample.rx_ns - own.rx_ns) > SAME_NS:
            return
        self._others[sample.source] = _SecondAttitude(own, sample)

    def _take_news(self, sample: EstimatorNewsSample) -> None:
        """Keep the newest text, but of several on one matter the first."""
        last = self.news
        if last is None or sample.news != last.news or sample.rx_ns - last.rx_ns > BURST_NS:
            self.news = sample

    def _of_news(self, now_ns: int) -> list[str]:
        news = self.news
        if news is None or now_ns - news.rx_ns > NEWS_NS:
            return []
        return [f'said "{news.text}" {(now_ns - news.rx_ns) * 1e-9:.0f} s ago']

    def _of_status(self, now_ns: int) -> list[str]:
        status = self.status
        if status is None or now_ns - status.rx_ns > FRESH_NS:
            return []
        texts = [] if status.attitude_valid else ["reports no valid attitude"]
        if status.receiver_glitch:
            texts.append("reports a GPS glitch")
        if status.accel_error:
            texts.append("reports bad vertical accelerations")
        named = (
            ("velocity", status.velocity),
            ("position", status.position),
            ("height", status.height),
            ("compass", status.compass),
            ("airspeed", status.airspeed),
        )
        texts += [f"reports bad {name} variance {value:.1f}" for name, value in named if value > status.limit]
        return texts

    def _of_health(self, now_ns: int) -> list[str]:
        health = self.health
        if health is None or now_ns - health.rx_ns > FRESH_NS or not health.unhealthy:
            return []
        return [f"reports unhealthy {', '.join(health.unhealthy)}"]

    def _of_others(self, now_ns: int) -> list[str]:
        return [
            f"shows {degrees(other.tilt):.0f} deg of tilt between {source} and its own attitude"
            for source, other in self._others.items()
            if now_ns - other.rx_ns <= FRESH_NS and other.tilt > INCONSISTENT
        ]
