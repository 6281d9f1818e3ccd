"""The rotation between the body whose attitude an autopilot reports and the body of its inertial messages: the rules.

ArduPilot reports its attitude turned by AHRS_TRIM_X/Y/Z = t (rad), which the inertial messages are not. Messages and
log records use three forms of this one trim, which differ by up to ``|t| sin(bank)``::

    EULER    angles as sent = angles of the IMU - t, one by one
    MATRIX   R as sent = R of the IMU * transpose(R(t.x, t.y, t.z))
    VECTOR   q as sent = q of the IMU * Exp(-t), with t as one rotation vector

A plane takes its pitch trim off ATTITUDE besides, and in the hover shows another view of the aircraft, which is turned
about the pitch axis. PX4 turns its sensors instead: attitude and inertial messages share one frame.

Sources: ArduPilot's AP_NavEKF3_Outputs.cpp, AP_AHRS.cpp, AP_AHRS_Logging.cpp and ArduPlane's GCS_Mavlink.cpp.
"""

from collections.abc import Sequence
from enum import IntEnum
from typing import Final

from attest_mav.algebra import q_exp, q_from_euler, q_mul, scale
from attest_mav.record import Record
from attest_mav.types import AttitudeForm, Quat, Vec3, Version
from attest_mav.vehicle_settings import Estimator

ARDUPILOT: Final = 3
PX4: Final = 12
"""MAV_AUTOPILOT."""

FIRST: Final = (0, 0, 0)
LAST: Final = (1000, 0, 0)


class TrimForm(IntEnum):
    """How the trim is in an attitude."""

    NONE = 0
    EULER = 1
    MATRIX = 2
    VECTOR = 3


class FrameRule(Record):
    """The frame of one message or log record, as far as it depends on firmware and estimator."""

    def __init__(
        self,
        autopilot: int,
        source: str,
        trim: TrimForm,
        written: AttitudeForm = AttitudeForm.EULER,
        estimators: tuple[Estimator, ...] = (),
        since: Version = FIRST,
        until: Version = LAST,
        pitch_trim: bool = False,
        hover_view: bool = False,
        secondary: bool = False,
    ) -> None:
        self.autopilot: Final = autopilot
        """MAV_AUTOPILOT."""
        self.source: Final = source
        """The message or log record."""
        self.trim: Final = trim
        self.written: Final = written
        """How the record writes the attitude."""
        self.estimators: Final = estimators
        """The estimators that it holds for; empty for all."""
        self.since: Final = since
        """The first firmware that it holds for."""
        self.until: Final = until
        """The first firmware that it does not hold for any more."""
        self.pitch_trim: Final = pitch_trim
        """True where a plane's pitch trim is taken off the pitch."""
        self.hover_view: Final = hover_view
        """True where a plane in the hover shows its other view."""
        self.secondary: Final = secondary
        """True for an attitude of the secondary estimator; ``estimators`` then speaks of that one."""


QUATERNION: Final = AttitudeForm.QUATERNION
EKF: Final = (Estimator.EKF2, Estimator.EKF3)
PLAIN: Final = (Estimator.DCM, Estimator.SIMULATOR)
OWN: Final = (*PLAIN, *EKF)
EXTERNAL: Final = (Estimator.EXTERNAL,)
V41: Final = (4, 1, 0)
V42: Final = (4, 2, 0)
V48: Final = (4, 8, 0)
"""Inferred from the date of the change, as the first release with it."""


def _trimmed_as_attitude(source: str, pitch_trim: bool) -> tuple[FrameRule, ...]:
    """The rules of ATTITUDE, which the ATT record shares but for the pitch trim."""
    parts = (
        (TrimForm.EULER, EKF, FIRST, LAST),
        (TrimForm.MATRIX, PLAIN, FIRST, LAST),
        (TrimForm.NONE, EXTERNAL, V48, LAST),
        (TrimForm.MATRIX, EXTERNAL, FIRST, V48),
    )
    return tuple(
        FrameRule(
            ARDUPILOT,
            source,
            trim,
            estimators=estimators,
            since=since,
            until=until,
            pitch_trim=pitch_trim,
            hover_view=True,
        )
        for trim, estimators, since, until in parts
    )


def _of_secondary(source: str) -> tuple[FrameRule, ...]:
    """The rules of an attitude of the secondary estimator in Euler angles."""
    return (
        FrameRule(ARDUPILOT, source, TrimForm.EULER, estimators=EKF, secondary=True),
        FrameRule(ARDUPILOT, source, TrimForm.MATRIX, estimators=PLAIN, secondary=True),
        FrameRule(ARDUPILOT, source, TrimForm.NONE, estimators=EXTERNAL, secondary=True),
    )


CORES: Final = ("XKF1", "XKF6", "XKF11", "NKF1", "NKF6", "NKF11", "EKF1")
"""Records of the estimators' cores in Euler angles."""
CORE_QUATERNIONS: Final = ("XKQ", "XKQ2", "XKQ3", "NKQ", "NKQ2", "NKQ3")
"""The same as quaternions."""

RULES: Final = (
    *_trimmed_as_attitude("ATTITUDE", pitch_trim=True),
    *_trimmed_as_attitude("ATT", pitch_trim=False),
    FrameRule(ARDUPILOT, "ATTITUDE_QUATERNION", TrimForm.VECTOR, QUATERNION, OWN, since=V41),
    FrameRule(ARDUPILOT, "ATTITUDE_QUATERNION", TrimForm.NONE, QUATERNION, OWN, since=V41, until=V42),
    FrameRule(ARDUPILOT, "ATTITUDE_QUATERNION", TrimForm.NONE, QUATERNION, until=V41, secondary=True),
    FrameRule(ARDUPILOT, "ATTITUDE_QUATERNION", TrimForm.NONE, QUATERNION, EXTERNAL, since=V41),
    *_of_secondary("AHRS2"),
    *_of_secondary("AHR2"),
    FrameRule(ARDUPILOT, "AHR2", TrimForm.VECTOR, QUATERNION, since=V42, secondary=True),
    FrameRule(ARDUPILOT, "AHR2", TrimForm.NONE, QUATERNION, until=V42, secondary=True),
    *(FrameRule(ARDUPILOT, source, TrimForm.EULER) for source in CORES),
    *(FrameRule(ARDUPILOT, source, TrimForm.NONE, QUATERNION) for source in CORE_QUATERNIONS),
    FrameRule(ARDUPILOT, "DCM", TrimForm.MATRIX),
    FrameRule(PX4, "ATTITUDE", TrimForm.NONE),
    FrameRule(PX4, "ATTITUDE_QUATERNION", TrimForm.NONE, QUATERNION),
    FrameRule(PX4, "vehicle_attitude", TrimForm.NONE, QUATERNION),
)
"""Of several rules that fit while the firmware's version is not known, the newest firmware's stands first."""


def rules_of(
    autopilot: int, source: str, written: AttitudeForm, version: Version | None, estimator: Estimator
) -> list[FrameRule]:
    """The rules that fit; more than one where the version (None while it is not known) would have to decide."""
    fallback = Estimator.EKF3 if estimator == Estimator.DCM else Estimator.DCM
    return [
        rule
        for rule in RULES
        if rule.source == source
        and rule.autopilot == autopilot
        and rule.written == written
        and (not rule.estimators or (fallback if rule.secondary else estimator) in rule.estimators)
        and (version is None or rule.since <= version < rule.until)
    ]


def without_trim(form: TrimForm, trim: Vec3, q_nb: Quat, euler: Vec3) -> Quat:
    """The attitude of the IMU. q_nb: as reported; euler: the same as angles, for the form that subtracts them."""
    if form == TrimForm.EULER:
        return q_from_euler(euler[0] + trim[0], euler[1] + trim[1], euler[2] + trim[2])
    if form == TrimForm.MATRIX:
        return q_mul(q_nb, q_from_euler(trim[0], trim[1], trim[2]))
    if form == TrimForm.VECTOR:
        return q_mul(q_nb, q_exp(scale(trim, 0.5)))
    return q_nb


def without_hover_view(q_nb: Quat, angle: float) -> Quat:
    """The attitude whose view in the hover is q_nb. angle: pitch of the view, rad."""
    return q_mul(q_nb, q_exp((0.0, 0.5 * angle, 0.0)))


def forms_of(rules: Sequence[FrameRule]) -> list[TrimForm]:
    """The different forms of some rules, in order."""
    return list(dict.fromkeys(rule.trim for rule in rules))
