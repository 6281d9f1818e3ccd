"""What leaves on one link: the heartbeat, our outputs, answers and requests, with one run of sequence numbers."""

from dataclasses import dataclass
from math import isfinite
from typing import Final

from attest_mav.algebra import is_finite, norm, q_norm
from attest_mav.mavlink.component.encoder import COVARIANCE_UNKNOWN, Encoder
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.stream import StreamRequest
from attest_mav.mavlink.constants import MAV_AUTOPILOT_INVALID, MAV_TYPE_ONBOARD_CONTROLLER
from attest_mav.mavlink.dialect import Dialect
from attest_mav.types import Estimate

ATTITUDE_QUATERNION: Final = 31
ATTITUDE_QUATERNION_COV: Final = 61

ONBOARD_SILENCE_NS: Final = 5_000_000_000
"""An onboard computer that has not been heard for this long is gone."""
REMEMBERED_HEARTBEATS: Final = 16
"""An echo of a heartbeat comes back before this many more are sent, or it is no echo."""
MAX_RATE: Final = 1e4
"""rad/s: a rate beyond this is no rate, and a float of 32 bits could not hold any double."""


@dataclass(frozen=True)
class PortSettings:
    """What one link carries.

    attitude, covariance: ATTITUDE_QUATERNION and ATTITUDE_QUATERNION_COV. named_values: ATT_TILT, ATT_YAW, ATT_OK.
    yields: ATTITUDE_QUATERNION is held back while another onboard computer of the vehicle is heard on the link.
    """

    attitude: bool = True
    covariance: bool = False
    named_values: bool = False
    yields: bool = True


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
        """ATTITUDE_QUATERNION and ATTITUDE_QUATERNION_COV frames so far."""
        period_ns = int(1e9 / hz)
        self.attitude: Final = Schedule(period_ns if settings.attitude else -1)
        self.covariance: Final = Schedule(period_ns if settings.covariance else -1)
        self._dialect: Final = dialect
        self._notes: Final = notes
        self._out: list[bytes] = []
        self._heartbeats: list[int] = []
        self._onboard_heard_ns = -ONBOARD_SILENCE_NS
        self.held = False
        """ATTITUDE_QUATERNION is held back at present."""

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
        """Another onboard computer of the vehicle speaks here: it may take our attitude for the autopilot's."""
        self._onboard_heard_ns = now_ns
        if self.settings.attitude and self.settings.yields and not self.held:
            self.held = True
            self._notes.warning(
                f"{self.name}: ATTITUDE_QUATERNION is held back: component {component} is an onboard computer too "
                "(MAVROS and MAVSDK would take ours for the autopilot's); see yield_to_onboard"
            )

    def publish(self, estimate: Estimate, now_ns: int) -> None:
        """Send the estimate in the forms and at the rates of this link."""
        if self.held and now_ns - self._onboard_heard_ns >= ONBOARD_SILENCE_NS:
            self.held = False
            self._notes.info(f"{self.name}: the other onboard computer is gone; ATTITUDE_QUATERNION is sent again")
        if not self.held and self.attitude.due(estimate.t_ns):
            self.put_attitude(estimate)
        if self.covariance.due(estimate.t_ns):
            self.put_covariance(estimate)

    def put_attitude(self, estimate: Estimate) -> None:
        """ATTITUDE_QUATERNION with the time of the IMU sample, unless the estimate is none."""
        if is_sound(estimate):
            self.attitudes_sent += 1
            self.put(self.encoder.attitude_quaternion(boot_ms(estimate.t_ns), estimate.q_nb, estimate.rates))

    def put_covariance(self, estimate: Estimate) -> None:
        """ATTITUDE_QUATERNION_COV; the covariance is marked unknown where the filter has none."""
        if not is_sound(estimate):
            return
        tilt, heading = estimate.tilt_sigma, estimate.heading_sigma
        covariance = COVARIANCE_UNKNOWN
        if isfinite(tilt) and isfinite(heading):
            covariance = (tilt * tilt, 0.0, 0.0, 0.0, tilt * tilt, 0.0, 0.0, 0.0, heading * heading)
        self.attitudes_sent += 1
        self.put(self.encoder.attitude_quaternion_cov(estimate.t_ns // 1000, estimate.q_nb, estimate.rates, covariance))

    def put_verdict(self, t_ns: int, ok: float, tilt_deg: float, heading_deg: float) -> None:
        """The verdict as named values, which ArduPilot writes into its own log. Unknown differences are left out."""
        if not self.settings.named_values:
            return
        time = boot_ms(t_ns)
        self.put(self.encoder.named_value_float(time, "ATT_OK", ok))
        if isfinite(tilt_deg):
            self.put(self.encoder.named_value_float(time, "ATT_TILT", tilt_deg))
        if isfinite(heading_deg):
            self.put(self.encoder.named_value_float(time, "ATT_YAW", heading_deg))


def boot_ms(t_ns: int) -> int:
    """Milliseconds of the autopilot's clock as 32 bits hold them."""
    return (t_ns // 1_000_000) & 0xFFFFFFFF


def is_sound(estimate: Estimate) -> bool:
    """Whether it is a finite unit quaternion with finite rates: nothing else is ever sent."""
    return abs(q_norm(estimate.q_nb) - 1.0) < 1e-3 and is_finite(estimate.rates) and norm(estimate.rates) < MAX_RATE
