"""The messages that a link can carry besides the heartbeat: one entry of ``OUTPUTS`` each.

A new output is a function that makes its frames, and an entry. The configuration's choice of names, the schedule of
each link, and the answers to MAV_CMD_REQUEST_MESSAGE and MAV_CMD_SET_MESSAGE_INTERVAL follow from the entry.
"""

from collections.abc import Callable
from enum import IntEnum
from math import isfinite, isnan, nan
from typing import Final

from attest_mav.algebra import is_finite, norm, q_norm
from attest_mav.estimate import Estimate
from attest_mav.mavlink.component.encoder import COVARIANCE_UNKNOWN, Encoder
from attest_mav.mavlink.constants import (
    MAV_AUTOPILOT_ARDUPILOTMEGA,
    MAV_AUTOPILOT_PX4,
    MAV_ESTIMATOR_TYPE_UNKNOWN,
    MAV_FRAME_BODY_FRD,
    MAV_FRAME_LOCAL_FRD,
    MAV_FRAME_LOCAL_NED,
)
from attest_mav.types import North

UNKNOWN_21: Final[tuple[float, ...]] = (nan,) * 21
"""A covariance of ODOMETRY that is not known."""

MAX_RATE: Final = 1e4
"""rad/s: a rate beyond this is no rate, and a float of 32 bits could not hold any double."""


TEXTS: Final = "statustext"
"""The name under ``publish`` of the texts for people (``announcer``), which no estimate makes."""


class Confidence(IntEnum):
    """How far our own estimate can be believed at present."""

    DOUBTED = 0
    """A sensor, the receiver or the magnetic field contradicts it."""
    UNCERTAIN = 1
    """Nothing contradicts it; its tilt sigma is above the limit."""
    BELIEVED = 2
    """Nothing contradicts it, and its tilt sigma is below the limit, or the filter has none."""


class PublishedVerdict:
    """The verdict on the autopilot's attitude, as it is sent."""

    def __init__(self, ok: float, tilt_deg: float, heading_deg: float) -> None:
        self.ok: Final = ok
        """1 agrees, 0 disagrees, -1 undecided; NaN: there is no verdict yet."""
        self.tilt_deg: Final = tilt_deg
        """Difference of tilt, degrees; NaN where unknown."""
        self.heading_deg: Final = heading_deg
        """Difference of heading, degrees; NaN where unknown."""


NO_VERDICT: Final = PublishedVerdict(nan, nan, nan)


class Publication:
    """Everything that an output can tell."""

    def __init__(
        self, estimate: Estimate, verdict: PublishedVerdict, confidence: Confidence, autopilot: int, resets: int
    ) -> None:
        self.estimate: Final = estimate
        """The newest estimate."""
        self.verdict: Final = verdict
        """The newest verdict, or NO_VERDICT."""
        self.confidence: Final = confidence
        """How far the estimate can be believed."""
        self.autopilot: Final = autopilot
        """MAV_AUTOPILOT of the vehicle."""
        self.resets: Final = resets
        """How often the attitude has begun anew, or has come of another sensor."""


class Output:
    """One message that can be sent on a link."""

    def __init__(
        self,
        name: str,
        message: str,
        frames: Callable[[Encoder, Publication], list[bytes]],
        hz: float = 0.0,
        with_heartbeat: bool = False,
        least: Confidence = Confidence.BELIEVED,
        misleads: str = "",
        only_configured: bool = False,
    ) -> None:
        self.name: Final = name
        """Name under ``publish`` in the configuration."""
        self.message: Final = message
        """Name of the message in the dialect."""
        self.frames: Final = frames
        """Makes the frames; called with sound estimates only, unless they are sent with the heartbeat."""
        self.hz: Final = hz
        """Rate in the clock of the estimates until a peer sets another, Hz; 0: the configured rate of the attitude."""
        self.with_heartbeat: Final = with_heartbeat
        """The frames go out beside each heartbeat instead, and can be neither requested nor retimed."""
        self.least: Final = least
        """The output is sent at this confidence or a higher one."""
        self.misleads: Final = misleads
        """Programs that take the message for the autopilot's own, "" for none: such an output can be held back."""
        self.only_configured: Final = only_configured
        """Where ``publish`` does not name it, no command can request it."""


def attitude_quaternion(encoder: Encoder, publication: Publication) -> list[bytes]:
    """ATTITUDE_QUATERNION with the time of the inertial sample."""
    estimate = publication.estimate
    return [encoder.attitude_quaternion(boot_ms(estimate.t_ns), estimate.q_nb, estimate.rates)]


def attitude_quaternion_cov(encoder: Encoder, publication: Publication) -> list[bytes]:
    """ATTITUDE_QUATERNION_COV; the covariance is marked unknown where the filter has none."""
    estimate = publication.estimate
    tilt, heading = estimate.tilt_sigma, estimate.heading_sigma
    covariance = COVARIANCE_UNKNOWN
    if isfinite(tilt) and isfinite(heading):
        covariance = (tilt * tilt, 0.0, 0.0, 0.0, tilt * tilt, 0.0, 0.0, 0.0, heading * heading)
    return [encoder.attitude_quaternion_cov(estimate.t_ns // 1000, estimate.q_nb, estimate.rates, covariance)]


def named_values(encoder: Encoder, publication: Publication) -> list[bytes]:
    """The verdict as NAMED_VALUE_FLOAT; differences that are unknown are left out."""
    verdict = publication.verdict
    if isnan(verdict.ok):
        return []
    time = boot_ms(publication.estimate.t_ns)
    frames = [encoder.named_value_float(time, "ATT_OK", verdict.ok)]
    if isfinite(verdict.tilt_deg):
        frames.append(encoder.named_value_float(time, "ATT_TILT", verdict.tilt_deg))
    if isfinite(verdict.heading_deg):
        frames.append(encoder.named_value_float(time, "ATT_YAW", verdict.heading_deg))
    return frames


def odometry(encoder: Encoder, publication: Publication) -> list[bytes]:
    """ODOMETRY of the attitude alone, in the form of the vehicle's autopilot; nothing where it has none.

    Position, velocity and their covariances are NaN, which is unknown: zeros would be measurements.
    """
    estimate = publication.estimate
    is_true = estimate.north == North.TRUE
    if publication.autopilot == MAV_AUTOPILOT_ARDUPILOTMEGA and is_true:
        frame_id, time_ns = MAV_FRAME_LOCAL_FRD, estimate.t_ns
    elif publication.autopilot == MAV_AUTOPILOT_PX4:
        frame_id = MAV_FRAME_LOCAL_NED if is_true else MAV_FRAME_LOCAL_FRD
        # PX4 turns the time into its own by TIMESYNC, so it is the time of our clock.
        time_ns = estimate.rx_ns - round(1e9 * estimate.delay_s)
    else:
        return []
    values: dict[str, object] = {
        "time_usec": max(time_ns, 0) // 1000,
        "frame_id": frame_id,
        "child_frame_id": MAV_FRAME_BODY_FRD,
        "q": estimate.q_nb,
        "pose_covariance": _pose_covariance(estimate),
        "velocity_covariance": UNKNOWN_21,
        "reset_counter": publication.resets & 0xFF,
        "estimator_type": MAV_ESTIMATOR_TYPE_UNKNOWN,
    }
    values |= dict.fromkeys(("x", "y", "z", "vx", "vy", "vz"), nan)
    values |= dict(zip(("rollspeed", "pitchspeed", "yawspeed"), estimate.rates, strict=True))
    return [encoder.message("ODOMETRY", values)]


def _pose_covariance(estimate: Estimate) -> list[float]:
    """The upper triangle of a 6 by 6 matrix, row by row: the variances of roll, pitch and yaw, and NaN elsewhere."""
    covariance = list(UNKNOWN_21)
    covariance[15] = covariance[18] = estimate.tilt_sigma * estimate.tilt_sigma
    covariance[20] = estimate.heading_sigma * estimate.heading_sigma
    return covariance


OUTPUTS: Final = (
    Output("attitude_quaternion", "ATTITUDE_QUATERNION", attitude_quaternion, misleads="MAVROS and MAVSDK"),
    Output("attitude_quaternion_cov", "ATTITUDE_QUATERNION_COV", attitude_quaternion_cov, least=Confidence.UNCERTAIN),
    Output("named_values", "NAMED_VALUE_FLOAT", named_values, with_heartbeat=True, least=Confidence.DOUBTED),
    Output("odometry", "ODOMETRY", odometry, misleads="MAVROS and MAVSDK", only_configured=True),
)
"""ArduPilot writes the named values into its own log; nobody uses ATTITUDE_QUATERNION_COV unasked."""


SUBSTITUTE: Final = "ATTITUDE_QUATERNION_COV"
"""The message that goes out in the place of outputs that mislead, while those are held back."""

OUTPUT_NAMES: Final = (*[output.name for output in OUTPUTS], TEXTS)
"""All names that ``publish`` can list."""


def boot_ms(t_ns: int) -> int:
    """Milliseconds of the autopilot's clock as 32 bits hold them."""
    return (t_ns // 1_000_000) & 0xFFFFFFFF


def is_sound(estimate: Estimate) -> bool:
    """Whether it is a finite unit quaternion with finite rates: nothing else is ever sent."""
    return abs(q_norm(estimate.q_nb) - 1.0) < 1e-3 and is_finite(estimate.rates) and norm(estimate.rates) < MAX_RATE
