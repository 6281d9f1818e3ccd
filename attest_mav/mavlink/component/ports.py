"""The sending side of one link: heartbeat, outputs, answers and requests, with one run of sequence numbers."""

from dataclasses import dataclass
from typing import Final

from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.outputs import OUTPUTS, TEXTS, Output, Publication, is_sound
from attest_mav.mavlink.component.stream import StreamRequest
from attest_mav.mavlink.component.timesync import AnswerLimit, TimeQuestion
from attest_mav.mavlink.constants import MAV_AUTOPILOT_INVALID, MAV_TYPE_ONBOARD_CONTROLLER
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame

ONBOARD_SILENCE_NS: Final = 5_000_000_000
"""An onboard computer that has not been heard for this long is gone."""
LAST_TEXT_ID: Final = 0xFFFF
"""The largest STATUSTEXT.id."""
REMEMBERED_HEARTBEATS: Final = 16
"""An echo of a heartbeat comes back before this many more are sent, or it is no echo."""


@dataclass(frozen=True)
class PortSettings:
    """The outputs of one link."""

    publish: tuple[str, ...] = ("attitude_quaternion", TEXTS)
    """Names of the outputs that are sent without being requested."""
    yields: bool = True
    """Outputs that can be taken for the autopilot's own are held back while another onboard computer of the vehicle is
    heard on the link."""
    outputs: tuple[Output, ...] = OUTPUTS
    """All outputs that can be published or requested."""


class Schedule:
    """Lets through as many samples of a clock as a rate allows. ``period_ns`` 0 lets all through, < 0 none."""

    def __init__(self, period_ns: int) -> None:
        self.default_ns: Final = period_ns
        self.period_ns = period_ns
        self._next_ns = -1

    def due(self, t_ns: int) -> bool:
        """Whether the sample at ``t_ns`` is to be sent. A tenth of a period early still counts: clocks jitter."""
        period_ns = self.period_ns
        if period_ns <= 0:
            return period_ns == 0
        ahead_ns = self._next_ns - t_ns
        if period_ns // 10 < ahead_ns <= 2 * period_ns:  # further ahead, the clock has gone back
            return False
        self._next_ns = self._next_ns + period_ns if abs(ahead_ns) <= period_ns else t_ns + period_ns
        return True


class Channel:
    """One output on one link."""

    def __init__(self, output: Output, schedule: Schedule) -> None:
        self.output: Final = output
        self.schedule: Final = schedule


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
        self.settings: Final = settings
        self.encoder = Encoder(dialect, system, component)
        self.attitudes_sent = 0
        """Frames of outputs that carry estimates so far."""
        self._channels: Final[dict[int, Channel]] = {
            dialect.id_of(output.message): Channel(output, _schedule(output, settings, hz))
            for output in settings.outputs
            if not output.with_heartbeat
        }
        published = [output for output in settings.outputs if output.name in settings.publish]
        self._beside_heartbeat: Final = [output for output in published if output.with_heartbeat]
        misleading = [output for output in published if output.misleads]
        self._misleading: Final = ", ".join([output.message for output in misleading])
        self._misled: Final = ", ".join([output.misleads for output in misleading])
        self._sends_texts: Final = TEXTS in settings.publish
        self._text_id = 0
        self._dialect: Final = dialect
        self._notes: Final = notes
        self._out: list[bytes] = []
        self._heartbeats: list[int] = []
        self._onboard_heard_ns = -ONBOARD_SILENCE_NS
        self._time_limit: Final = AnswerLimit()
        self.held = False
        """Outputs that can be taken for the autopilot's own are held back at present."""

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
        self._onboard_heard_ns = now_ns
        if self._misleading and self.settings.yields and not self.held:
            self.held = True
            self._notes.warning(
                f"{self.name}: {self._misleading} is held back: component {component} is an onboard computer too "
                f"({self._misled} would take ours for the autopilot's); see yield_to_onboard"
            )

    def publish(self, publication: Publication, now_ns: int) -> None:
        """Send the estimate in the forms and at the rates of this link."""
        if self.held and now_ns - self._onboard_heard_ns >= ONBOARD_SILENCE_NS:
            self.held = False
            self._notes.info(f"{self.name}: the other onboard computer is gone; {self._misleading} is sent again")
        for channel in self._channels.values():
            output = channel.output
            if publication.confidence < output.least or (self.held and output.misleads):
                continue
            if channel.schedule.due(publication.estimate.t_ns):
                self._put_output(output, publication)

    def publish_beside_heartbeat(self, publication: Publication) -> None:
        """Send the outputs of this link that go with the heartbeat."""
        for output in self._beside_heartbeat:
            if publication.confidence >= output.least:
                self._out += output.frames(self.encoder, publication)

    def say(self, severity: int, text: str) -> None:
        """Send a text for people with this MAV_SEVERITY, on a link that carries texts."""
        if self._sends_texts:
            self._text_id = self._text_id % LAST_TEXT_ID + 1
            self._out += self.encoder.statustexts(severity, text, self._text_id)

    def tell_time(self, question: TimeQuestion, asker: Frame, now_ns: int) -> None:
        """Answer a question for our time. One to everybody is left to others while there are any.

        Another onboard computer takes each answer of its vehicle for the autopilot's.
        """
        others = now_ns - self._onboard_heard_ns < ONBOARD_SILENCE_NS
        if not (question.is_for_all and others) and self._time_limit.allows(now_ns):
            self.put(self.encoder.timesync(max(1, now_ns), question.ts1_ns, asker.system, asker.component))

    def schedule_of(self, message_id: int) -> Schedule | None:
        """The schedule of an output, whether it is published here or not; None for other messages."""
        channel = self._channels.get(message_id)
        return None if channel is None else channel.schedule

    def put_output(self, message_id: int, publication: Publication) -> bool:
        """Send an output now that has a schedule; False where the estimate is not to be believed so far."""
        output = self._channels[message_id].output
        if publication.confidence < output.least:
            return False
        self._put_output(output, publication)
        return True

    def _put_output(self, output: Output, publication: Publication) -> None:
        if is_sound(publication.estimate):
            frames = output.frames(self.encoder, publication)
            self.attitudes_sent += len(frames)
            self._out += frames


def _schedule(output: Output, settings: PortSettings, hz: float) -> Schedule:
    """The schedule of an output on a link whose attitude has the rate ``hz``; silent where it is not published."""
    return Schedule(int(1e9 / (output.hz or hz)) if output.name in settings.publish else -1)
