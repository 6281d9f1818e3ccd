"""The sending side of one link: heartbeat, outputs, answers and requests, with one run of sequence numbers."""

from typing import Final

from attest_mav.mavlink.component.channel import Channel, PortSettings
from attest_mav.mavlink.component.encoder import Encoder, Signer
from attest_mav.mavlink.component.line_limit import LineLimit
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.onboard import OnboardWatch
from attest_mav.mavlink.component.outputs import SUBSTITUTE, TEXTS, Output, Publication, is_sound
from attest_mav.mavlink.component.schedule import Station
from attest_mav.mavlink.component.stream import StreamRequest
from attest_mav.mavlink.component.timesync import AnswerLimit, TimeQuestion
from attest_mav.mavlink.constants import MAV_AUTOPILOT_INVALID, MAV_TYPE_ONBOARD_CONTROLLER
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame

LAST_TEXT_ID: Final = 0xFFFF
"""The largest STATUSTEXT.id."""
REMEMBERED_HEARTBEATS: Final = 16
"""An echo of a heartbeat comes back before this many more are sent, or it is no echo."""


class Port:
    """The sending side of one link. ``take`` fetches the frames that are to be written."""

    def __init__(
        self,
        dialect: Dialect,
        name: str,
        settings: PortSettings,
        system: int,
        component: int,
        hz: float,
        notes: Notebook,
    ) -> None:
        self.name: Final = name
        self.settings = settings
        self.encoder = Encoder(dialect, system, component)
        self.attitudes_sent = 0
        """Estimates published so far, each counted once in whichever forms; those sent on request are not counted."""
        self._channels: dict[int, Channel] = {}
        self._published: list[Output] = []
        self._text_id = 0
        self._dialect: Final = dialect
        self._notes: Final = notes
        self._out: list[bytes] = []
        self._heartbeats: list[int] = []
        self._onboard: Final = OnboardWatch()
        self._stations: Final = OnboardWatch()
        self._lines: Final = LineLimit()
        self._time_limit: Final = AnswerLimit()
        self.use(settings, hz)

    def use(self, settings: PortSettings, hz: float) -> None:
        """Send by other settings from now on, the attitude at ``hz``; signatures and stations' intervals stay."""
        self.settings = settings
        self._published = [output for output in settings.outputs if output.name in settings.publish]
        channels: dict[int, Channel] = {}
        for output in settings.outputs:
            message_id = self._dialect.id_of(output.message)
            if output.with_heartbeat or (output.only_configured and output not in self._published):
                continue
            channel = self._channels.get(message_id)
            if channel is None:
                channel = Channel(output, settings, hz)
            else:
                channel.use(settings, hz)
            channels[message_id] = channel
        self._channels = channels

    def take(self) -> list[bytes]:
        """The frames to write, oldest first; each is handed out once."""
        out = self._out
        if out:
            self._out = []
        return out

    def put(self, frame: bytes) -> None:
        """Send this frame."""
        self._out.append(frame)

    def request(self, request: StreamRequest, system: int, component: int) -> None:
        """Request a stream from the vehicle with these ids."""
        if request.group >= 0:
            frame = self.encoder.request_data_stream(system, component, request.group, max(1, round(request.hz)))
        else:
            frame = self.encoder.set_message_interval(
                system, component, request.message_id, request.interval_us, request.confirmation
            )
        self.put(frame)

    def rename(self, system: int) -> None:
        """Speak under another system id from now on."""
        if system != self.encoder.system:
            self.encoder = Encoder(self._dialect, system, self.encoder.component, self.encoder.signer)

    def sign_with(self, signer: Signer) -> None:
        """Sign every frame from now on."""
        self.encoder = Encoder(self._dialect, self.encoder.system, self.encoder.component, signer)

    def heartbeat(self, state: int) -> None:
        """HEARTBEAT with this MAV_STATE."""
        frame = self.encoder.heartbeat(MAV_TYPE_ONBOARD_CONTROLLER, MAV_AUTOPILOT_INVALID, 0, state)
        self._heartbeats.append(frame[4])
        if len(self._heartbeats) > REMEMBERED_HEARTBEATS:
            self._heartbeats.pop(0)
        self.put(frame)

    def sent_heartbeat(self, sequence: int) -> bool:
        """Whether one of our last heartbeats here had this sequence number."""
        return sequence in self._heartbeats

    def onboard_heard(self, component: int, now_ns: int) -> None:
        """Another onboard computer of the vehicle is heard: it may take our attitude for the autopilot's."""
        if self._misleading() and self.settings.yields and self._onboard.heard(component, now_ns):
            self._tell_held(f"component {component} is an onboard computer too", "yield_to_onboard", now_ns)

    def ground_station_heard(self, component: int, now_ns: int) -> None:
        """A ground station is heard beside the vehicle: it may do the same."""
        if self._misleading() and self.settings.yields_to_stations and self._stations.heard(component, now_ns):
            self._tell_held(f"component {component} is a ground station here too", "yield_to_stations", now_ns)

    def _tell_held(self, cause: str, key: str, now_ns: int) -> None:
        misled = ", ".join(dict.fromkeys([output.misleads for output in self._misleading()]))
        text = f"{self._misleading_names()} is held back: {cause} ({misled} would take ours for the autopilot's)"
        self._note(key, f"{text}; {SUBSTITUTE} goes out instead; see {key}", now_ns)

    def _misleading(self) -> list[Output]:
        """The published outputs that can be taken for the autopilot's own."""
        return [output for output in self._published if output.misleads]

    def _misleading_names(self) -> str:
        return ", ".join([output.message for output in self._misleading()])

    @property
    def held_for(self) -> int:
        """Component for which outputs that can be taken for the autopilot's own are held back, 0 for none."""
        onboard = self._onboard.component if self.settings.yields else 0
        return onboard or (self._stations.component if self.settings.yields_to_stations else 0)

    def station_heard(self, system: int, component: int, now_ns: int) -> None:
        """A station is heard: intervals that it has set may go on."""
        for channel in self._channels.values():
            interval = channel.schedule.interval
            if interval is not None and interval.station.system == system and interval.station.component == component:
                interval.heard_ns = now_ns

    def poll(self, now_ns: int) -> None:
        """End the intervals that others have set when their time has come, and what is held back likewise."""
        if self._onboard.left(now_ns):
            self._note(
                "onboard-end", f"the other onboard computer is gone; {self._misleading_names()} is sent again", now_ns
            )
        if self._stations.left(now_ns):
            self._note("station-end", f"the ground station is gone; {self._misleading_names()} is sent again", now_ns)
        for channel in self._channels.values():
            schedule = channel.schedule
            reason = "" if schedule.interval is None else schedule.interval.ended(now_ns)
            if reason and schedule.restore():
                text = f"{channel.output.message} is back at its own rate, {schedule.rate_text}: {reason}"
                self._note("interval-end", text, now_ns)

    def set_interval(self, message_id: int, period_ns: int | None, station: Station, now_ns: int) -> None:
        """Take an interval of a station for an output that has a schedule, ns; None goes back to our own."""
        channel = self._channels[message_id]
        schedule = channel.schedule
        changed = schedule.restore() if period_ns is None else schedule.set_by(station, period_ns, now_ns)
        if changed:
            self._note("interval", f"{station.name} has set {channel.output.message} to {schedule.rate_text}", now_ns)

    @property
    def changes(self) -> list[str]:
        """What other stations have changed here, each in a few words."""
        return [
            f"{channel.output.message} set to {channel.schedule.rate_text} by {channel.schedule.interval.station.name}"
            for channel in self._channels.values()
            if channel.schedule.interval is not None
        ]

    def set_rate(self, hz: float) -> None:
        """Send the attitude at this rate from now on, Hz."""
        for channel in self._channels.values():
            channel.use(self.settings, hz)

    def publish(self, publication: Publication) -> None:
        """Send the estimate in the forms and at the rates of this link."""
        holds_back = self.held_for != 0
        sent = 0
        for channel in self._channels.values():
            if publication.confidence < channel.output.least or not is_sound(publication.estimate):
                continue
            if channel.due(publication.estimate.t_ns, holds_back):
                frames = channel.output.frames(self.encoder, publication)
                sent += len(frames)
                self._out += frames
        self.attitudes_sent += 1 if sent else 0

    def publish_beside_heartbeat(self, publication: Publication) -> None:
        """Send the outputs of this link that go with the heartbeat."""
        for output in self._published:
            if output.with_heartbeat and publication.confidence >= output.least:
                self._out += output.frames(self.encoder, publication)

    def say(self, severity: int, text: str) -> None:
        """Send a text for people with this MAV_SEVERITY, on a link that carries texts."""
        if TEXTS in self.settings.publish:
            self._text_id = self._text_id % LAST_TEXT_ID + 1
            self._out += self.encoder.statustexts(severity, text, self._text_id)

    def tell_time(self, question: TimeQuestion, asker: Frame, now_ns: int) -> None:
        """Answer a question for our time. One to everybody is left to others while there are any.

        Another onboard computer takes each answer of its vehicle for the autopilot's.
        """
        if not (question.is_for_all and self._onboard.component) and self._time_limit.allows(now_ns):
            self.put(self.encoder.timesync(max(1, now_ns), question.ts1_ns, asker.system, asker.component))

    def has_output(self, message_id: int) -> bool:
        """Whether this message can be requested and retimed here, whether it is published or not."""
        return message_id in self._channels

    def put_output(self, message_id: int, publication: Publication) -> bool:
        """Send an output now that can be requested; False where the estimate is not to be believed so far."""
        output = self._channels[message_id].output
        if publication.confidence < output.least:
            return False
        if is_sound(publication.estimate):
            frames = output.frames(self.encoder, publication)
            self._out += frames
            return bool(frames)
        return True

    def _note(self, kind: str, text: str, now_ns: int) -> None:
        """Leave a warning on this link, at most one of a kind in a minute."""
        suffix = self._lines.suffix(kind, now_ns)
        if suffix is not None:
            self._notes.warning(f"{self.name}: {text}{suffix}")
