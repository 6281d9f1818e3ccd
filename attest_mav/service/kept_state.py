"""The state that survives a restart of the daemon, as a record and as text: the host reads and writes the file."""

from typing import Annotated, Final

import msgspec
from msgspec import Meta

from attest_mav.config.calibration import KeptCalibrations
from attest_mav.mavlink.component.own_parameters import OwnParameters, ParameterChange
from attest_mav.mavlink.signing.clock import SigningClock
from attest_mav.mavlink.signing.signature import LATEST
from attest_mav.service.calibration_store import CalibrationStore


class KeptParameter(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A parameter of ours that a station has set."""

    value: float
    """In place of the configured one, in the unit of its key."""
    by: Annotated[str, Meta(max_length=200)]
    """Ids of the station that set it, and the link."""


class KeptState(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The time of our signatures, the parameters that somebody has set, and the sensors' errors."""

    signing_timestamp: Annotated[int, Meta(ge=0, le=LATEST)] = 0
    """No signature of ours was later when this was kept; ticks of 10 us since 2015."""
    parameters: dict[str, KeptParameter] = {}
    """Values in place of the configured ones, by name."""
    calibrations: KeptCalibrations = {}
    """Errors of sensors that flights have shown."""


def parse_state(text: bytes) -> KeptState:
    """The state in a file; ValueError says what is wrong."""
    return msgspec.json.decode(text, type=KeptState)


def parse_without_calibrations(text: bytes) -> KeptState:
    """The rest of a state whose calibrations make no sense; ValueError where the rest makes none either."""
    state = msgspec.json.decode(text)
    if isinstance(state, dict):
        state.pop("calibrations", None)
    return msgspec.convert(state, KeptState)


def state_text(state: KeptState) -> bytes:
    """The state as the text of a file."""
    return msgspec.json.format(msgspec.json.encode(state)) + b"\n"


class Persistence:
    """Takes the state out of the parts of a service, and puts it back."""

    def __init__(self, clock: SigningClock, parameters: OwnParameters, calibrations: CalibrationStore) -> None:
        self._clock: Final = clock
        self.calibrations: Final = calibrations
        """Errors of sensors by flights."""
        self._parameters: Final = parameters

    @property
    def state(self) -> KeptState:
        """The state that must survive a restart."""
        changes = self._parameters.changes
        kept = {name: KeptParameter(one.value, one.by) for name, one in changes.items()}
        return KeptState(self._clock.timestamp, kept, self.calibrations.kept)

    def restore(self, state: KeptState, unix_ns: int, now_ns: int) -> None:
        """Go on from the state kept before a restart. unix_ns: the time of day."""
        self._clock.begin(state.signing_timestamp, unix_ns, now_ns)
        self.calibrations.restore(state.calibrations, unix_ns * 1e-9)
        self._parameters.restore({name: ParameterChange(one.value, one.by) for name, one in state.parameters.items()})

    def set_time(self, unix_ns: int, now_ns: int) -> None:
        """Take the time of day, ns of UNIX: signatures follow it, and the age of what is learned."""
        self.calibrations.set_time(unix_ns * 1e-9)
        self._clock.set_time(unix_ns, now_ns)
