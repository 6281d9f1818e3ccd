"""Records the series of a flight while it is replayed, in memory that does not grow with the log."""

from math import asin, degrees, hypot, isfinite, nan, sqrt
from typing import Final, NamedTuple

from attest_mav.algebra import norm, q_to_euler, rotate, sub
from attest_mav.estimate import Estimate
from attest_mav.estimation.events import LaneEvent, Verdict
from attest_mav.innovation import Aid, Innovation
from attest_mav.replay.comparison import ComparedAttitude
from attest_mav.report.envelope import Envelope
from attest_mav.report.kinds import Chart
from attest_mav.report.marks import Marks
from attest_mav.report.windows import Window, Windows
from attest_mav.samples import ImuSample, PositionSample, Sample, VelocitySample
from attest_mav.types import EarthField, Quat, VelocityOrigin
from attest_mav.vehicle_reports import EstimatorStatusSample

REFERENCE: Final = "reference"
"""Name of the reference's series."""
AXES: Final = ("x", "y", "z")
NED: Final = ("north", "east", "down")
ACCEL_WINDOW_S: Final = 1.0
NIS_WINDOW_S: Final = 5.0


class Key(NamedTuple):
    """The place of a series. subject: whom it is about, a filter, the autopilot, the reference or a lane."""

    chart: Chart
    subject: str
    part: str = ""
    """An axis, or the attitude with which the subject is compared."""
    panel: str = ""
    """Charts of one kind that stand apart, by the name of the aid."""


class FlightRecorder:
    """A ``FlightObserver`` that keeps series and marks."""

    def __init__(self) -> None:
        self.series: Final[dict[Key, Envelope]] = {}
        self.marks: Final = Marks()
        self.inclination_deg = nan
        """Of the Earth's field, NaN if not known."""
        self.duration_s = 0.0
        """Log time of the newest inertial sample, s."""
        self.proven: Final[set[str]] = set()
        """Filters with an estimate whose sigma is proven."""
        self._last_s: Final[dict[str, float]] = {}
        self._windows: Final[dict[Key, Windows]] = {}

    def begin(self, field: EarthField) -> None:
        """The flight begins, in this magnetic field of the Earth."""
        self.inclination_deg = degrees(field.inclination)

    def imu(self, sample: ImuSample, elapsed_s: float) -> None:
        """Take the next inertial sample of a lane."""
        lane = sample.source
        self.duration_s = max(self.duration_s, elapsed_s)
        last_s = self._last_s.get(lane)
        if last_s is not None:
            self._add(Key(Chart.INTERVAL, lane), elapsed_s, 1e3 * (elapsed_s - last_s))
        self._last_s[lane] = elapsed_s
        self._window(Key(Chart.VIBRATION, lane), elapsed_s, sample.accel)
        self._window(Key(Chart.CLIPPING, lane), elapsed_s, (float(sample.saturated),))
        if sample.mag is not None:
            self._add(Key(Chart.FIELD_STRENGTH, lane), elapsed_s, norm(sample.mag))

    def estimate(self, name: str, estimate: Estimate, sample: ImuSample) -> None:
        """Take the next estimate of the selected lane, beside the inertial sample that ``imu`` took last."""
        elapsed_s = self._last_s[sample.source]
        if estimate.sigma_is_proven:
            self.proven.add(name)
        bias = sub(sample.gyro, estimate.rates)
        for axis, value in zip(AXES, bias, strict=True):
            self._add(Key(Chart.GYRO_BIAS, name, axis), elapsed_s, degrees(value))
        if estimate.accel_bias is not None:
            for axis, value in zip(AXES, estimate.accel_bias, strict=True):
                self._add(Key(Chart.ACCEL_BIAS, name, axis), elapsed_s, value)
        mag = sample.mag
        if mag is not None and norm(mag) > 0.0:
            down = rotate(estimate.q_nb, mag)[2] / norm(mag)
            self._add(Key(Chart.INCLINATION, name), elapsed_s, degrees(asin(min(1.0, max(-1.0, down)))))

    def verdict(self, name: str, verdict: Verdict, elapsed_s: float) -> None:
        """Take the next verdict on the autopilot's attitude."""
        self._add(Key(Chart.TILT, "autopilot", name), elapsed_s, degrees(verdict.tilt))
        self._add(Key(Chart.HEADING, "autopilot", name), elapsed_s, abs(degrees(verdict.heading)))

    def lane_event(self, name: str, event: LaneEvent, elapsed_s: float) -> None:
        """Take the next event of a lane."""
        self.marks.take_lane(name, event, elapsed_s)

    def reference(self, q_nb: Quat, elapsed_s: float) -> None:
        """Take the next attitude of the reference."""
        self._attitude(REFERENCE, q_nb, elapsed_s)

    def vehicle(self, sample: Sample, elapsed_s: float) -> None:
        """Take the next sample that is neither inertial nor an attitude; it came at this log time."""
        self.marks.take_vehicle(sample, elapsed_s)
        if isinstance(sample, VelocitySample):
            is_receiver = sample.origin == VelocityOrigin.RECEIVER
            subject = "receiver" if is_receiver else "autopilot"
            self._add(Key(Chart.SPEED, subject), elapsed_s, hypot(sample.v_ned[0], sample.v_ned[1]))
            if sample.sigma is not None:
                self._add(Key(Chart.SPEED_SIGMA, subject), elapsed_s, sample.sigma)
        elif isinstance(sample, PositionSample):
            if sample.satellites is not None:
                self._add(Key(Chart.SATELLITES, "receiver"), elapsed_s, float(sample.satellites))
            if sample.dilution is not None:
                self._add(Key(Chart.DILUTION, "receiver"), elapsed_s, sample.dilution)
        elif isinstance(sample, EstimatorStatusSample):
            self._test_ratios(sample, elapsed_s)

    def write(self, compared: ComparedAttitude) -> None:
        """Take the next attitude with its errors."""
        name, attitude = compared.name, compared.attitude
        t_s = attitude.elapsed_s
        self._attitude(name, attitude.q_nb, t_s)
        if compared.tilt is not None:
            self._add(Key(Chart.TILT, name, REFERENCE), t_s, degrees(compared.tilt))
        if compared.heading is not None:
            self._add(Key(Chart.HEADING, name, REFERENCE), t_s, abs(degrees(compared.heading)))
        self._add(Key(Chart.TILT, name, "sigma"), t_s, degrees(attitude.tilt_sigma))
        self._add(Key(Chart.HEADING, name, "sigma"), t_s, degrees(attitude.heading_sigma))
        for innovation in attitude.innovations:
            self._innovation(name, innovation, t_s)

    def finish(self) -> None:
        """The flight has ended."""
        for key, windows in self._windows.items():
            self._add_window(key, windows.finish())

    def _attitude(self, name: str, q_nb: Quat, t_s: float) -> None:
        for chart, angle in zip((Chart.ROLL, Chart.PITCH, Chart.YAW), q_to_euler(q_nb), strict=True):
            self._add(Key(chart, name), t_s, degrees(angle))

    def _innovation(self, name: str, innovation: Innovation, t_s: float) -> None:
        """The innovation in units of its sigma, and its normalised square."""
        if not innovation.variance:
            return
        panel = innovation.aid.name.lower().replace("_", " ")
        axes: tuple[str, ...] = NED if innovation.aid == Aid.VELOCITY else AXES
        if len(innovation.variance) == 1:
            axes = ("",)
        for axis, residual, variance in zip(axes, innovation.residual, innovation.variance, strict=False):
            if variance > 0.0:
                self._add(Key(Chart.INNOVATION, name, axis, panel), t_s, residual / sqrt(variance))
        self._window(Key(Chart.NIS, name, panel), t_s, (innovation.nis,))

    def _test_ratios(self, sample: EstimatorStatusSample, t_s: float) -> None:
        for part in ("velocity", "position", "height", "compass", "airspeed"):
            self._add(Key(Chart.TEST_RATIO, "autopilot", part), t_s, getattr(sample, part) / sample.limit)

    def _window(self, key: Key, t_s: float, reading: tuple[float, ...]) -> None:
        if not all(isfinite(value) for value in reading):
            return
        windows = self._windows.get(key)
        if windows is None:
            length_s = NIS_WINDOW_S if key.chart == Chart.NIS else ACCEL_WINDOW_S
            windows = self._windows[key] = Windows(length_s)
        self._add_window(key, windows.add(t_s, reading))

    def _add_window(self, key: Key, ended: Window | None) -> None:
        if ended is None:
            return
        values = {Chart.VIBRATION: ended.spread, Chart.CLIPPING: ended.total}
        self._add(key, ended.middle_s, values.get(key.chart, ended.mean))

    def _add(self, key: Key, t_s: float, value: float) -> None:
        envelope = self.series.get(key)
        if envelope is None:
            envelope = self.series[key] = Envelope()
        envelope.add(t_s, value)
