"""Asking an autopilot for the parameters that tell what a filter wants to know of the vehicle.

Each is asked for by name with PARAM_REQUEST_READ. An autopilot does not answer for a name that it does not have, and
names change from one release to the next: so the names of a setting are tried in turn, ever more seldom, and then it
is left at what the filter assumes.
"""

from math import isfinite
from typing import Final

from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.decode.autopilot_parameters import names_of, quantity, with_unit
from attest_mav.types import ParameterSample, Setting, VehicleSettings

FIRST_PAUSE_NS: Final = 1_000_000_000
"""Doubled after each request."""
MAX_TRIES: Final = 6
"""Over a minute: the first of them may meet an autopilot that has just booted, or a ground station's download."""


class Question:
    """One setting that is wanted."""

    def __init__(self, setting: Setting, names: list[str], now_ns: int) -> None:
        self.setting: Final = setting
        self.names: Final = names
        self.tries = 0
        self.due_ns = now_ns

    def next_name(self, now_ns: int) -> str:
        """The name to ask for now."""
        name = self.names[self.tries % len(self.names)]
        self.due_ns = now_ns + (FIRST_PAUSE_NS << self.tries)
        self.tries += 1
        return name


class ParameterAsker:
    """The questions to one vehicle. ``poll`` returns the names to ask for; it does not send.

    asks: False only listens. default_settings: each that is not NaN is wanted,
    and holds until the autopilot tells another.
    """

    def __init__(self, asks: bool, default_settings: VehicleSettings, notebook: Notebook) -> None:
        self.wanted: Final = [setting for setting in Setting if isfinite(default_settings.get(setting))]
        self._asks: Final = asks
        self._assumed: Final = default_settings
        self._notebook: Final = notebook
        self._questions: list[Question] = []
        self._told: dict[Setting, str] = {}

    def begin(self, autopilot: int, now_ns: int) -> None:
        """Ask for everything: a vehicle was found, or found again, or has rebooted. ``autopilot``: MAV_AUTOPILOT."""
        self._questions = []
        if not self._asks:
            return
        for setting in self.wanted:
            names = names_of(setting, autopilot)
            if names:
                self._questions.append(Question(setting, names, now_ns))

    def forget(self) -> None:
        """There is no vehicle any more, or another one."""
        self._questions = []
        self._told = {}

    def told(self, sample: ParameterSample) -> None:
        """The vehicle told a setting, whoever asked."""
        setting = sample.setting
        if setting not in self.wanted:
            return
        self._questions = [one for one in self._questions if one.setting != setting]
        what = f"the autopilot's {quantity(setting)}"
        if isfinite(sample.value):
            self._say(setting, f"{what} is {with_unit(setting, sample.value)} ({sample.name})")
        else:
            self._say(setting, f"{what} is left to a driver ({sample.name} is 0): {self._assume(setting)}")

    def poll(self, now_ns: int) -> list[str]:
        """The names of the parameters to ask for now."""
        names = []
        open_ones = []
        for question in self._questions:
            if now_ns < question.due_ns:
                open_ones.append(question)
            elif question.tries < MAX_TRIES:
                names.append(question.next_name(now_ns))
                open_ones.append(question)
            else:
                self._give_up(question)
        self._questions = open_ones
        return names

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``poll`` is due; None while nothing is asked."""
        return min([question.due_ns for question in self._questions]) if self._questions else None

    def _give_up(self, question: Question) -> None:
        setting = question.setting
        names = " or ".join(question.names)
        self._say(setting, f"the autopilot does not tell its {quantity(setting)} ({names}): {self._assume(setting)}")

    def _assume(self, setting: Setting) -> str:
        return f"{with_unit(setting, self._assumed.get(setting))} is assumed"

    def _say(self, setting: Setting, text: str) -> None:
        """Leave a note, unless the same was said last."""
        if self._told.get(setting) != text:
            self._told[setting] = text
            self._notebook.info(text)
