"""The faults of a recorded flight with their times, read from its card, and the bounds of each kind."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from math import inf
from typing import Final, cast

from attest_mav.errors import UnreadableDataError
from attest_mav.evaluation.harness import Bound

AFTERMATH_S: Final = 25.0
"""A fault's time goes on for this long after its end, s, or until the next one begins."""


class FaultGroup(IntEnum):
    """Kinds of faults that share their bounds."""

    SINGLE = 0
    """One sensor, the receiver or the compass; one source is wrong and others show it."""
    BOTH_SENSORS = 1
    """All gyros or all accelerometers alike, not about the vertical."""
    BOTH_VERTICAL = 2
    """All gyros alike about the vertical: only the magnetic field shows it."""
    VIBRATION = 3
    """Vibration: every reading is true and none is good."""
    CLEAN = 4
    """A flight without a fault."""


@dataclass(frozen=True)
class Fault:
    """One fault. Times are seconds of the autopilot's clock."""

    name: str
    start_s: float
    end_s: float
    group: FaultGroup = FaultGroup.SINGLE
    accused: tuple[str, ...] = ()
    """Words that the text which names the faulty source must have; empty where nothing is to be named."""


@dataclass(frozen=True)
class FaultCard:
    """The faults of one flight in order of time, and the intervals (s) in which the truth itself is not to be used."""

    faults: tuple[Fault, ...]
    leave_out: tuple[tuple[float, float], ...] = ()

    def window(self, place: int) -> tuple[float, float]:
        """First and last second that belong to the fault at this place."""
        fault = self.faults[place]
        following = self.faults[place + 1].start_s if place + 1 < len(self.faults) else inf
        return fault.start_s, min(following, fault.end_s + AFTERMATH_S)


def read_card(text: str) -> FaultCard:
    """The card beside a recorded flight; UnreadableDataError says what is wrong with it."""
    try:
        card = cast("Mapping[str, list[object]]", json.loads(text))
        faults = tuple(_recorded_fault(cast("Mapping[str, object]", entry)) for entry in card["faults"])
        intervals = cast("list[tuple[float, float]]", card.get("leave_out", []))
        return FaultCard(faults, tuple((float(first), float(last)) for first, last in intervals))
    except (KeyError, TypeError, ValueError) as error:
        raise UnreadableDataError(f"a card of faults that cannot be read: {error}") from None


def _recorded_fault(entry: Mapping[str, object]) -> Fault:
    name = str(entry["fault"])
    return Fault(name, float(str(entry["start_s"])), float(str(entry["end_s"])), _group(name), _accused(name))


def _group(name: str) -> FaultGroup:
    if name.startswith("vibration"):
        return FaultGroup.VIBRATION
    if name.startswith("both"):
        return FaultGroup.BOTH_VERTICAL if "gyros z" in name else FaultGroup.BOTH_SENSORS
    return FaultGroup.SINGLE


def _accused(name: str) -> tuple[str, ...]:
    """The message of the faulty inertial sensor, with its kind and axis as the card names them."""
    words = name.split()
    message = {"imu1": "RAW_IMU", "imu2": "SCALED_IMU2"}.get(words[0])
    if message is None:
        return ()
    kind = "gyro" if words[1] == "gyro" else "accelerometer"
    return (message, f"{kind} {words[2]}") if words[2] in ("x", "y", "z") else (message,)


def bounds_of(group: FaultGroup) -> dict[str, Bound]:
    """The required figures of a kind of fault: seconds, and degrees of published tilt."""
    if group == FaultGroup.CLEAN:
        return {"false": (0.0, 0.0)}
    blind = {FaultGroup.BOTH_SENSORS: 1.0, FaultGroup.BOTH_VERTICAL: 1.5}.get(group, 0.5)
    bounds = {"blind": (0.0, blind), "false": (0.0, 0.0)}
    if group == FaultGroup.BOTH_SENSORS:
        return {**bounds, "above 3": (0.0, 0.4)}
    if group == FaultGroup.SINGLE:
        return {**bounds, "mute": (0.0, 3.0), "ours": (0.0, 1.0), "ours 99%": (0.0, 0.7)}
    return {**bounds, "ours": (0.0, 1.5)} if group == FaultGroup.VIBRATION else bounds
