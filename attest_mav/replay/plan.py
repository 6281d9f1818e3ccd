"""Which vehicle, inertial messages, reference and filter a replay uses: chosen from a survey, or named by the user."""

from dataclasses import dataclass
from typing import Final

from attest_mav.errors import UnreadableDataError, UsageError
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.registry import default_filter
from attest_mav.logs.tlog.survey import (
    IMU_MESSAGES,
    NAMED_REFERENCES,
    REFERENCE_MESSAGES,
    TRUTH_MESSAGES,
    Sender,
    Survey,
)
from attest_mav.mavlink.component.imu_choice import preferred_messages
from attest_mav.mavlink.decode.units import ARDUPILOT, unit_row

FULL_SHARE: Final = 0.9
"""A message that is this nearly as frequent as the most frequent one is as good as that one."""
AUTOPILOT_MESSAGES: Final = ("ATTITUDE", "ATTITUDE_QUATERNION")
"""The autopilot's own attitude, to be compared with the reference. (Both carry the same.)"""
UNTIMED: Final = ("SIM_STATE", "SIMSTATE", "AHRS2")
"""References without a time of their own."""


@dataclass(frozen=True)
class Plan:
    """What to read. Names of messages; None where the log has none that suits.

    reference: what everything is compared with. autopilot: its own attitude, unless that is the reference. timing: the
    message that lends its time to an untimed reference.
    """

    sender: Sender
    imu: str
    reference: str | None
    autopilot: str | None
    timing: str | None


def check_names(imu: str | None, reference: str | None) -> None:
    """Raise UsageError unless both are messages that can be meant."""
    if imu is not None and imu not in IMU_MESSAGES:
        raise UsageError(f"unknown inertial message {imu!r}; known: {', '.join(IMU_MESSAGES)}")
    if reference is not None and reference not in NAMED_REFERENCES:
        raise UsageError(f"unknown reference {reference!r}; known: {', '.join(NAMED_REFERENCES)}")


def make_plan(survey: Survey, imu: str | None, reference: str | None) -> Plan:
    """Choose what was not named. UnreadableDataError: the log lacks what is named, or inertial messages at all."""
    sender = _choose_sender(survey, imu)
    if reference is not None and not survey.count(sender, reference):
        raise UnreadableDataError(f"no {reference} in it to compare with{_instead(survey, sender, NAMED_REFERENCES)}")
    chosen = reference or _first_present(survey, sender, REFERENCE_MESSAGES)
    autopilot = _first_present(survey, sender, AUTOPILOT_MESSAGES)
    inertial = imu or _choose_imu(survey, sender)
    return Plan(
        sender,
        inertial,
        chosen,
        autopilot if chosen not in AUTOPILOT_MESSAGES else None,
        (autopilot or inertial) if chosen in UNTIMED else None,
    )


def suitable_filter(survey: Survey, sender: Sender) -> AttitudeFilter:
    """The filter for who names none: the one for flight where the receiver gives a velocity, else the hardiest."""
    return default_filter("velocity-aided" if sender[0] in survey.velocities else "gradient-descent")


def in_simulator(survey: Survey, sender: Sender) -> bool:
    """True for a flight in ArduPilot's simulator, which tells its truth."""
    return survey.autopilot(sender) == ARDUPILOT and _first_present(survey, sender, TRUTH_MESSAGES) is not None


def _choose_sender(survey: Survey, imu: str | None) -> Sender:
    """The sender with most inertial messages, one that flies something if there is any."""
    wanted = IMU_MESSAGES if imu is None else (imu,)
    amounts = {
        sender: sum(survey.count(sender, name) for name in wanted)
        for sender in sorted(survey.heartbeats) or survey.senders()
    }
    best = max(amounts, key=amounts.__getitem__, default=None)
    if best is None or not amounts[best]:
        present = "" if best is None else _instead(survey, best, IMU_MESSAGES)
        raise UnreadableDataError(f"no {' or '.join(wanted)} in it: nothing to estimate an attitude from{present}")
    return best


def _choose_imu(survey: Survey, sender: Sender) -> str:
    """The best of the inertial messages that are about as frequent as the most frequent one."""
    counts = {name: survey.count(sender, name) for name in _by_preference(survey.autopilot(sender))}
    enough = FULL_SHARE * max(counts.values())
    return next(name for name, count in counts.items() if count >= enough)


def _by_preference(autopilot: int | None) -> list[str]:
    """All inertial messages, best first; those whose numbers have no meaning on this autopilot last."""
    if autopilot is None:
        return list(IMU_MESSAGES)
    preferred = preferred_messages(autopilot)
    ordered = [*preferred, *(name for name in IMU_MESSAGES if name not in preferred)]
    return sorted(ordered, key=lambda name: unit_row(name, autopilot, None) is None)


def _first_present(survey: Survey, sender: Sender, names: tuple[str, ...]) -> str | None:
    return next((name for name in names if survey.count(sender, name)), None)


def _instead(survey: Survey, sender: Sender, names: tuple[str, ...]) -> str:
    """What the log has in place of what was asked for, to be appended to an error."""
    present = [name for name in names if survey.count(sender, name)]
    return f"; it has {', '.join(present)}" if present else ""
