"""Links and their messages as records of a snapshot."""

from dataclasses import dataclass

from attest_mav.service.signing_status import SigningSnapshot


@dataclass(frozen=True)
class Traffic:
    """Transport counters of one link; its host keeps them."""

    is_up: bool = False
    """Whether messages can be sent at all."""
    is_open: bool = False
    """Whether the device or socket is open: a link that listens is open before anyone speaks."""
    streams: int = 0
    """Byte streams begun: one more with every connection made again."""
    received_bytes: int = 0
    """Bytes received."""
    sent_bytes: int = 0
    """Bytes sent."""
    dropped_messages: int = 0
    """Messages not sent, because the link was down or its buffer full."""


NO_TRAFFIC = Traffic()
"""For a host that counts nothing."""


@dataclass(frozen=True)
class LinkSnapshot:
    """One link: its MAVLink frames, and its bytes."""

    name: str
    """The URL, with the port that the system chose."""
    frames: int
    """Intact frames received, wanted or not."""
    bad_bytes: int
    """Bytes received that belong to no frame."""
    bad_crc: int
    """Frames received whose checksum does not fit."""
    lost_frames: int
    """Frames missing in the sequence numbers of their senders."""
    attitudes_sent: int
    """Estimates published, each counted once in whichever messages; answers to requests are not counted."""
    held_back: bool
    """Whether ATTITUDE_QUATERNION is held back, because another onboard computer, or a ground station beside the
    vehicle, is heard on the link."""
    held_for: int
    """Component id of that program, 0 for none."""
    changes: tuple[str, ...]
    """What other stations have changed in our outputs: message, rate and station."""
    signing: SigningSnapshot | None
    """Its signatures, None where nothing is signed."""
    traffic: Traffic
    """Transport counters."""


@dataclass(frozen=True)
class StreamSnapshot:
    """One message that the autopilot is asked for."""

    name: str
    """The message."""
    hz: float
    """Rate asked for, Hz."""
    answer: str
    """The autopilot's answer in a word or two, "" before there is one."""
    refused: bool
    """Whether the autopilot will not send it."""
    achieved_hz: float
    """Rate measured over the last window, Hz; 0 before the first one ends, and while the vehicle is away."""
    ceiling_hz: float
    """The most that the autopilot gives, Hz; 0 where no limit was found."""
    hindrance: str
    """Why it does not come at the rate asked for, "" where that is not known."""


@dataclass(frozen=True)
class Refusal:
    """Messages of one source that gave no samples."""

    source: str
    """The message; with `` magnetometer`` behind it, its magnetometer alone."""
    reason: str
    """Why it gives none at present, "" where it gives samples again."""
    messages: int
    """Messages refused so far."""
