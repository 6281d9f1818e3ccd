"""What must survive a restart of the daemon, as a record and as the text of a file: the host reads and writes it."""

from typing import Annotated

import msgspec
from msgspec import Meta

from attest_mav.mavlink.component.own_parameters import OwnParameters, ParameterChange
from attest_mav.mavlink.signing.signature import LATEST


class KeptParameter(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A parameter of ours that a station has set."""

    value: float
    """In place of the configured one, in the unit of its key."""
    by: Annotated[str, Meta(max_length=200)]
    """Ids of the station that set it, and the link."""


class KeptState(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The time of our signatures, and the parameters that somebody has set."""

    signing_timestamp: Annotated[int, Meta(ge=0, le=LATEST)] = 0
    """No signature of ours was later when this was kept; ticks of 10 us since 2015."""
    parameters: dict[str, KeptParameter] = {}
    """Values in place of the configured ones, by name."""


def parse_state(text: bytes) -> KeptState:
    """The state in a file; ValueError says what is wrong."""
    return msgspec.json.decode(text, type=KeptState)


def kept(timestamp: int, parameters: OwnParameters) -> KeptState:
    """The state with this timestamp of signatures and the parameters that were set."""
    return KeptState(timestamp, {name: KeptParameter(one.value, one.by) for name, one in parameters.changes.items()})


def restore_parameters(state: KeptState, parameters: OwnParameters) -> None:
    """Put the kept parameters in force again."""
    parameters.restore({name: ParameterChange(one.value, one.by) for name, one in state.parameters.items()})


def state_text(state: KeptState) -> bytes:
    """The state as the text of a file."""
    return msgspec.json.format(msgspec.json.encode(state)) + b"\n"
