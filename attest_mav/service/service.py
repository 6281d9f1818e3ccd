"""The daemon's work without its waiting: bytes of links in, frames for links out, time as an argument.

Framer, companion, decoder and pipeline are put together here. ``attest_mav.runtime.daemon`` gives it the real links
and the real clock; tests give it a simulated vehicle and a counter.
"""

import logging
from collections.abc import Callable, Sequence
from math import degrees, isfinite, nan, radians

from attest_mav.config.records import Config
from attest_mav.estimation.events import Agreement, Event, LaneEvent, LaneEventKind, Verdict
from attest_mav.estimation.pipeline import Pipeline
from attest_mav.mavlink.component.companion import ACTIVE, BOOT, CALIBRATING, CRITICAL, Companion
from attest_mav.mavlink.decode.autopilot_parameters import facts_of_firmware
from attest_mav.mavlink.decode.decoder import Decoder, of_message
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.framer import Framer
from attest_mav.service.assembly import companion_settings, port_settings
from attest_mav.service.status import verdict_text
from attest_mav.types import (
    EarthField,
    Estimate,
    HeartbeatSample,
    ImuSample,
    ParameterSample,
    PositionSample,
    Sample,
    VehicleSettings,
)

log = logging.getLogger("attest_mav.service")

FieldFinder = Callable[[float, float, float], tuple[EarthField, str]]
"""Latitude, longitude (degrees) and altitude (m) to the Earth's field and where it is known from."""

FAR_DEG = 0.5
"""The field is looked up again after so many degrees of latitude or longitude: it hardly changes sooner."""

REPORT_NS = 1_000_000_000
"""How often refusals of the decoder are looked for."""

_WARNINGS = {LaneEventKind.STOPPED, LaneEventKind.FROZEN, LaneEventKind.REBOOTED, LaneEventKind.HEADING_LOST}


class Service:
    """One vehicle's attitude, from the bytes of its links to the frames that are sent on them."""

    def __init__(
        self, config: Config, links: Sequence[str], dialect: Dialect, find_field: FieldFinder, now_ns: int
    ) -> None:
        """``links``: the names of the links, one for each of ``config.link``."""
        self.config = config
        ports = [(name, port_settings(link)) for name, link in zip(links, config.link, strict=True)]
        self.companion = Companion(dialect, companion_settings(config), ports, now_ns)
        self._dialect = dialect
        self.framers = [Framer(dialect, self.companion.wanted) for _ in links]
        self.decoder = Decoder(dialect, config.raw_imu.scales())
        self.pipeline: Pipeline | None = None
        self.samples = 0
        self.due_ns = now_ns
        """When ``poll`` is due; a time in the past is at once."""
        self._find_field = find_field
        self._field = EarthField()
        self._field_place: tuple[float, float] | None = None
        self._sample_ns = now_ns - 10 * self._stale_ns
        self._sender = self.companion.sender
        self._heartbeat: HeartbeatSample | None = None
        self._facts = VehicleSettings()
        self._told: dict[str, str] = {}
        self._agreement: Agreement | None = None
        self._next_report_ns = now_ns + REPORT_NS
        if config.estimate.declination_deg != "auto":
            self._field = EarthField(radians(config.estimate.declination_deg))

    @property
    def estimate(self) -> Estimate | None:
        """The newest estimate, None while there is none that holds."""
        return None if self.pipeline is None else self.pipeline.estimate

    def fresh(self, now_ns: int) -> bool:
        """Whether the newest estimate is recent enough to be called one."""
        estimate = self.estimate
        return estimate is not None and now_ns - estimate.rx_ns < self._stale_ns

    def receive(self, link: int, data: bytes, now_ns: int) -> None:
        """Take bytes that arrived on a link."""
        companion = self.companion
        for frame in self.framers[link].feed(data, now_ns):
            is_data = companion.handle(link, frame, now_ns)
            if companion.sender != self._sender:
                self._begin_anew()
            if is_data:
                for sample in self.decoder.decode(frame):
                    self._take(sample, now_ns)
            else:
                self.due_ns = now_ns  # a heartbeat, an answer, a command: something may follow from it

    def link_restarted(self, link: int) -> None:
        """A link was opened again: whatever was half received is lost."""
        self.framers[link].reset()
        self.companion.link_broken(link)
        self.due_ns = 0

    def poll(self, now_ns: int) -> None:
        """Do what is due."""
        if self.pipeline is not None:
            self._act(self.pipeline.poll(now_ns), now_ns)
        if now_ns >= self._next_report_ns:
            self._next_report_ns = now_ns + REPORT_NS
            self._report_refusals()
        self.companion.state = self._state(now_ns)
        self.companion.poll(now_ns)
        for note in self.companion.notebook.take():
            log.log(note.level, "%s", note.text)
        self.due_ns = min(self.companion.next_deadline_ns, self._next_report_ns)
        pipeline_ns = None if self.pipeline is None else self.pipeline.next_deadline_ns
        if pipeline_ns is not None:
            self.due_ns = min(self.due_ns, pipeline_ns)

    def take_frames(self, link: int) -> list[bytes]:
        """The frames to be written to a link."""
        return self.companion.ports[link].take()

    def stop(self) -> None:
        """Leave the last words to ``take_frames``."""
        self.companion.stop()

    @property
    def _stale_ns(self) -> int:
        return int(self.config.estimate.stale_s * 1e9)

    def _take(self, sample: Sample, now_ns: int) -> None:
        if isinstance(sample, ImuSample):
            if not self.companion.imu_taken(sample.source, now_ns):
                return
            self.samples += 1
            self._sample_ns = now_ns
            if self.pipeline is None or self.pipeline.primary != sample.source:
                self._begin_pipeline(sample.source)
        elif isinstance(sample, HeartbeatSample):
            self._heartbeat = sample
        elif isinstance(sample, PositionSample):
            self._look_field_up(sample)
        elif isinstance(sample, ParameterSample):
            self._facts = self._facts.updated(sample.setting, sample.value)
            self.companion.parameter_taken(sample)
            self.due_ns = now_ns  # there may be a note of it
        if self.pipeline is not None:
            self._act(self.pipeline.handle(sample), now_ns)

    def _begin_anew(self) -> None:
        """Another vehicle, another part of it, or none: what the last one sent says nothing about this one."""
        self._sender = self.companion.sender
        self.decoder = Decoder(self._dialect, self.config.raw_imu.scales())
        self.pipeline = self._heartbeat = None
        self._facts = facts_of_firmware(self._sender[2])
        self._agreement = None
        self.companion.tell_verdict(nan, nan, nan)

    def _begin_pipeline(self, source: str) -> None:
        config = self.config
        self.pipeline = Pipeline(config.pipeline_settings(), config.filter.build(), [source])
        self.pipeline.set_vehicle_settings(self._facts)
        self.pipeline.set_field(self._field)
        if self._heartbeat is not None:
            self.pipeline.handle(self._heartbeat)  # whether it is armed counts from the first sample on
        note = self.decoder.notes.get(source, "")
        log.info("using %s with the filter %s%s", source, config.filter.chosen, f" ({note})" if note else "")

    def _act(self, events: list[Event], now_ns: int) -> None:
        """Do what the pipeline's events mean."""
        for event in events:
            if isinstance(event, Estimate):
                if event is self.estimate:  # one that came too late to hold is not sent
                    self.companion.publish(event, now_ns)
            elif isinstance(event, Verdict):
                self.due_ns = now_ns
                self._take_verdict(event)
            elif isinstance(event, LaneEvent):
                self.due_ns = now_ns
                log.log(logging.WARNING if event.kind in _WARNINGS else logging.INFO, "%s: %s", event.lane, event.text)
                if event.kind == LaneEventKind.REBOOTED:
                    self.companion.ask_again(now_ns)
        if events and self.estimate is None:
            self.companion.withdraw()

    def _take_verdict(self, verdict: Verdict) -> None:
        """Pass the verdict on; log it when it changes."""
        codes = {Agreement.AGREE: 1.0, Agreement.DISAGREE: 0.0, Agreement.UNDECIDED: -1.0}
        self.companion.tell_verdict(codes[verdict.agreement], verdict.tilt, verdict.heading)
        if verdict.agreement != self._agreement:
            self._agreement = verdict.agreement
            level = logging.WARNING if verdict.agreement == Agreement.DISAGREE else logging.INFO
            log.log(level, "verdict: %s", verdict_text(verdict))

    def _state(self, now_ns: int) -> int:
        """MAV_STATE, true to life: a filter that is too unsure for a verdict has not converged."""
        estimate = self.estimate
        if estimate is not None and self.fresh(now_ns):
            if self._agreement == Agreement.DISAGREE:
                return CRITICAL
            unsure = estimate.tilt_sigma > radians(self.config.verdict.max_sigma_deg)
            return CALIBRATING if unsure else ACTIVE
        return CALIBRATING if now_ns - self._sample_ns < self._stale_ns else BOOT

    def _look_field_up(self, position: PositionSample) -> None:
        """Look the Earth's field up at the first position, and again far from there; a configured declination stays."""
        place = (position.latitude_deg, position.longitude_deg)
        known = self._field_place
        if known is not None and max(abs(place[0] - known[0]), abs(place[1] - known[1])) < FAR_DEG:
            return
        self._field_place = place
        found, source = self._find_field(*place, position.altitude_m)
        if not isfinite(found.declination):
            return
        if self.config.estimate.declination_deg != "auto":
            found = EarthField(self._field.declination, found.inclination)
        else:
            log.info("headings are true: declination %+.2f degrees by %s", degrees(found.declination), source)
        self._field = found
        if self.pipeline is not None:
            self.pipeline.set_field(found)

    def _report_refusals(self) -> None:
        """Say once why the inertial message gives no samples, or none with a magnetometer."""
        stream = self.companion.data.imu
        if stream is None:
            return
        for source, reason in self.decoder.refusals.items():
            if source in of_message(stream.name) and self._told.get(source) != reason:
                self._told[source] = reason
                log.warning("%s", reason)
