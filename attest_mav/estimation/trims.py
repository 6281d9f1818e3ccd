"""The trims among the settings of an ArduPilot vehicle, and the rules for its messages, worked out once a change."""

from math import isfinite
from typing import Final

from attest_mav.estimation.body_frames import ARDUPILOT, FrameRule, rules_of
from attest_mav.samples import AttitudeSample
from attest_mav.types import Vec3, Version
from attest_mav.vehicle_settings import Estimator, Setting, VehicleSettings

NO_PITCH_TRIM: Final = 1 << 8
"""Bit of FLIGHT_OPTIONS: the pitch trim is not taken off ATTITUDE."""


class Trims:
    """The trims by one state of the settings; zero where they are not told."""

    def __init__(self, settings: VehicleSettings) -> None:
        pitch = settings.get(Setting.PITCH_TRIM)
        is_left = int(settings.get_or(Setting.FLIGHT_OPTIONS, 0.0)) & NO_PITCH_TRIM != 0
        chosen = settings.get_or(Setting.ESTIMATOR, float(Estimator.EKF3))
        self.settings: Final = settings
        """The settings that all this is made of."""
        self.angles: Final[Vec3] = (
            settings.get_or(Setting.TRIM_X, 0.0),
            settings.get_or(Setting.TRIM_Y, 0.0),
            settings.get_or(Setting.TRIM_Z, 0.0),
        )
        """AHRS_TRIM_X, _Y and _Z, rad."""
        self.pitch: Final = 0.0 if is_left or not isfinite(pitch) else pitch
        """The pitch trim of a plane, rad; 0 where an option leaves it in."""
        self.are_told: Final = isfinite(settings.get(Setting.TRIM_X)) and isfinite(settings.get(Setting.TRIM_Y))
        """True where the vehicle has told the angles; versions without a third one have told it with two."""
        self.pitch_is_told: Final = isfinite(pitch)
        """True where the vehicle has told the pitch trim."""
        self.estimator: Final = next((one for one in Estimator if one == chosen), Estimator.EKF3)
        """The estimator that is set, the usual one where that is not told."""


class RuleBook:
    """The rules of one message, looked up again when firmware or estimator change."""

    def __init__(self) -> None:
        self._version: Version | None = None
        self._estimator: Estimator | None = None
        self._rules: list[FrameRule] = []

    def rules(self, sample: AttitudeSample, version: Version | None, estimator: Estimator) -> list[FrameRule]:
        """The rules that fit, see ``rules_of``."""
        if estimator is not self._estimator or version != self._version:
            self._version, self._estimator = version, estimator
            self._rules = rules_of(ARDUPILOT, sample.source, sample.form, version, estimator)
        return self._rules
