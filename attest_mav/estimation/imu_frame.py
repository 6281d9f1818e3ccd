"""The autopilot's attitudes, each turned into the frame of the inertial messages before anybody compares it.

The rules stand in ``body_frames``; the trims, the firmware's version and the estimator in use are the vehicle's own
words (``Vehicle``), and each counts from the first attitude after it.
"""

from enum import Enum
from math import degrees, radians
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import q_from_euler, q_to_euler
from attest_mav.estimation.body_frames import (
    ARDUPILOT,
    FrameRule,
    TrimForm,
    forms_of,
    without_hover_view,
    without_trim,
)
from attest_mav.estimation.hover_view import HoverView, hover_angle, hover_view
from attest_mav.estimation.trim_form_fit import TrimFormFit
from attest_mav.estimation.trims import RuleBook, Trims
from attest_mav.estimation.vehicle import Vehicle
from attest_mav.samples import AttitudeSample
from attest_mav.types import AttitudeForm, AttitudeRole, Quat, Vec3, VehicleKind

STEEPEST: Final = radians(85.0)
"""Beyond this pitch a difference of Euler angles is no rotation that could be undone."""
SHOWN: Final = radians(0.05)
"""Smaller angles are not worth a note."""
MAX_PAST: Final = 8
"""Changes that are remembered for notes."""


@mypyc_attr(acyclic=True, free_list_len=1)  # as Sample
class _Removed:
    """The angles that were taken off an attitude: the trim, and a pitch by its name; rad."""

    def __init__(self, trim: Vec3, pitch_name: str, pitch: float) -> None:
        self.trim: Final = trim
        self.pitch_name: Final = pitch_name
        self.pitch: Final = pitch

    def differs(self, other: "_Removed") -> bool:
        """True for other angles."""
        return self.trim != other.trim or self.pitch != other.pitch

    def text(self) -> str:
        """The angles for people, "" where there are none."""
        trim, parts = self.trim, []
        if max(abs(angle) for angle in trim) >= SHOWN:
            shown = trim if abs(trim[2]) >= SHOWN else trim[:2]
            parts.append(f"AHRS_TRIM {', '.join([f'{degrees(angle):.1f}' for angle in shown])} deg")
        if abs(self.pitch) >= SHOWN:
            parts.append(f"{self.pitch_name} {degrees(self.pitch):.1f} deg")
        return " and ".join(parts)


class Refusal(Enum):
    """Why an attitude cannot be turned into the frame of the IMU."""

    NO_RULE = "no rule tells how this firmware trims it"
    SECONDARY = "firmware before 4.1 fills it from its secondary estimator"
    VIEW = "it may show the view of the hover, which the flight mode alone does not tell"
    STEEP = "its pitch is too near 90 degrees for a difference of Euler angles"


class ImuFrame:
    """Turns attitudes into the frame of the IMU. ``vehicle``: tells its trims, now and later."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._removed: Final[dict[str, list[_Removed]]] = {}
        self._refusals: Final[dict[str, Refusal]] = {}
        self._vehicle: Final = vehicle
        self._fit: Final = TrimFormFit()
        self._trims = Trims(vehicle.settings)
        self._books: Final[dict[tuple[str, AttitudeForm], RuleBook]] = {}

    @property
    def notes(self) -> list[str]:
        """A line for each message off which something is taken at present, or whose frame is not known."""
        texts = {source: past[-1].text() for source, past in self._removed.items()}
        taken = [f"{text} taken off {source}" for source, text in texts.items() if text]
        return taken + self._obstacle_notes()

    @property
    def history(self) -> list[str]:
        """The same for the whole time: all that was taken off."""
        taken = []
        for source, past in self._removed.items():
            share = "" if len(past) == 1 else ", part of the time"
            texts = dict.fromkeys([removed.text() for removed in past])
            taken += [f"{text} taken off {source}{share}" for text in texts if text]
        return taken + self._obstacle_notes()

    def _obstacle_notes(self) -> list[str]:
        return [f"{source} is not compared: {refusal.value}" for source, refusal in self._refusals.items()]

    def refusal(self, source: str) -> Refusal | None:
        """Why the newest attitude of a message was not turned; None for one that was."""
        return self._refusals.get(source)

    def attitude(self, sample: AttitudeSample) -> AttitudeSample | None:
        """The sample with the attitude of the IMU, None where that cannot be known.

        A simulator's truth is the board's already. Of other autopilots than ArduPilot no trim is known.
        """
        vehicle = self._vehicle
        if sample.role == AttitudeRole.TRUTH or vehicle.autopilot != ARDUPILOT:
            return sample
        if vehicle.settings is not self._trims.settings:
            self._trims = Trims(vehicle.settings)
        rules = self._rules(sample)
        if not rules:
            self._refusals[sample.source] = Refusal.NO_RULE
            return None
        rule = self._chosen(rules, sample)
        if rule.secondary and sample.role == AttitudeRole.AUTOPILOT:
            self._refusals[sample.source] = Refusal.SECONDARY
            return None
        view = hover_view(vehicle) if rule.hover_view else HoverView.NO
        if view == HoverView.UNKNOWN:
            self._refusals[sample.source] = Refusal.VIEW
            return None
        return self._turned(sample, rule, view)

    def _rules(self, sample: AttitudeSample) -> list[FrameRule]:
        """The rules that fit the message, by the estimator's own words, else as it is set."""
        key = (sample.source, sample.form)
        book = self._books.get(key)
        if book is None:
            book = self._books[key] = RuleBook()
        estimator = self._vehicle.estimator
        return book.rules(sample, self._vehicle.firmware, self._trims.estimator if estimator is None else estimator)

    def _chosen(self, rules: list[FrameRule], sample: AttitudeSample) -> FrameRule:
        """The rule whose form fits ATTITUDE where the version does not decide; until that is known the first."""
        if len(rules) < 2:
            return rules[0]
        forms = forms_of(rules)
        if len(forms) < 2:
            return rules[0]
        form = self._fit.judge(sample, forms, self._trims.angles)
        return next(rule for rule in rules if rule.trim == form)

    def _turned(self, sample: AttitudeSample, rule: FrameRule, view: HoverView) -> AttitudeSample | None:
        """The sample without trim and view."""
        trims, none = self._trims, (0.0, 0.0, 0.0)
        if view == HoverView.YES:
            angle = hover_angle(self._vehicle)
            q_nb = without_trim(TrimForm.MATRIX, trims.angles, without_hover_view(sample.q_nb, angle), none)
            return self._known(sample, q_nb, _Removed(trims.angles, "pitch trim of the hover", angle), trims.are_told)
        trim = none if rule.trim == TrimForm.NONE else trims.angles
        pitch = trims.pitch if rule.pitch_trim else 0.0
        sent = q_to_euler(sample.q_nb) if sample.euler is None else sample.euler
        euler = (sent[0], sent[1] + pitch, sent[2])
        if rule.trim == TrimForm.EULER and trim != none and abs(euler[1] + trim[1]) > STEEPEST:
            self._refusals[sample.source] = Refusal.STEEP
            return None
        q_nb = sample.q_nb if pitch == 0.0 else q_from_euler(euler[0], euler[1], euler[2])
        if trim != none:
            q_nb = without_trim(rule.trim, trim, q_nb, euler)
        if sample.form == AttitudeForm.EULER and sample.role == AttitudeRole.AUTOPILOT:
            self._fit.remember(sample.t_ns, q_nb)
        return self._known(sample, q_nb, _Removed(trim, "pitch trim", pitch), self._is_told(rule))

    def _is_told(self, rule: FrameRule) -> bool:
        """True where the vehicle has told all trims of a message under this rule."""
        trims = self._trims
        needs_pitch = rule.pitch_trim and self._vehicle.kind == VehicleKind.WING
        return (rule.trim == TrimForm.NONE or trims.are_told) and (trims.pitch_is_told or not needs_pitch)

    def _known(self, sample: AttitudeSample, q_nb: Quat, removed: _Removed, is_told: bool) -> AttitudeSample:
        past = self._removed.get(sample.source)
        if past is None:
            self._removed[sample.source] = [removed]
        elif past[-1].differs(removed):
            past.append(removed)
            del past[:-MAX_PAST]
        if self._refusals:
            self._refusals.pop(sample.source, None)
        return sample.with_attitude(q_nb, is_told)
