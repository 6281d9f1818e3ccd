"""Reads the parameters of an autopilot that carry the vehicle's settings a filter needs.

Each parameter is requested by name with PARAM_REQUEST_READ. An autopilot does not answer for a name that it does not
have, and names change between releases. The names of a setting are therefore tried in turn, at doubling intervals;
without an answer the filter keeps its own assumption.
"""

from math import isfinite
from typing import Final

from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.decode.autopilot_parameters import names_of, quantity, with_unit
from attest_mav.types import ParameterSample, Setting, VehicleSettings

FIRST_PAUSE_NS: Final = 1_000_000_000
"""Pause after the first request; it doubles after each one."""
MAX_TRIES: Final = 6
"""Requests at 0, 1, 3, 7, 15 and 31 s; given up at 63 s. The early ones may be lost while the autopilot boots or a
ground station downloads all parameters."""


class ParameterRequest:
    """An open request for one setting: the names under which autopilots have it, tried in turn."""

    def __init__(self, setting: Setting, names: list[str], now_ns: int) -> None:
        self.setting: Final = setting
        self.names: Final = names
        self.tries = 0
        self.due_ns = now_ns

    def next_name(self, now_ns: int) -> str:
        """The name to request now; the next request follows after the doubled pause."""
        name = self.names[self.tries % len(self.names)]
        self.due_ns = now_ns + (FIRST_PAUSE_NS << self.tries)
        self.tries += 1
        return name


class AutopilotSettings:
    """The settings of one vehicle and the open requests for them. ``poll`` returns names to request; it does not send.

    asks: False requests nothing and only listens. default_settings: the filter's own; those that are not NaN are
    requested, and hold until the autopilot has answered.
    """

    def __init__(self, asks: bool, default_settings: VehicleSettings, notebook: Notebook) -> None:
        self.wanted: Final = [setting for setting in Setting if isfinite(default_settings.get(setting))]
        self._asks: Final = asks
        self._assumed: Final = default_settings
        self._notebook: Final = notebook
        self._open: list[ParameterRequest] = []
        self._noted: dict[Setting, str] = {}

    def begin(self, autopilot: int, now_ns: int) -> None:
        """Request every setting: a vehicle was found, found again, or has rebooted. ``autopilot``: MAV_AUTOPILOT."""
        self._open = []
        if not self._asks:
            return
        for setting in self.wanted:
            names = names_of(setting, autopilot)
            if names:
                self._open.append(ParameterRequest(setting, names, now_ns))

    def forget(self) -> None:
        """Drop all requests and notes: there is no vehicle any more, or another one."""
        self._open = []
        self._noted = {}

    def received(self, sample: ParameterSample) -> None:
        """The vehicle sent a parameter, whoever had requested it."""
        setting = sample.setting
        if setting not in self.wanted:
            return
        self._open = [request for request in self._open if request.setting != setting]
        subject = f"the autopilot's {quantity(setting)}"
        if isfinite(sample.value):
            self._note(setting, f"{subject} is {with_unit(setting, sample.value)} ({sample.name})")
        else:
            self._note(setting, f"{subject} is left to a driver ({sample.name} is 0): {self._assumption(setting)}")

    def poll(self, now_ns: int) -> list[str]:
        """The names of the parameters to request now."""
        names = []
        still_open = []
        for request in self._open:
            if now_ns < request.due_ns:
                still_open.append(request)
            elif request.tries < MAX_TRIES:
                names.append(request.next_name(now_ns))
                still_open.append(request)
            else:
                self._give_up(request)
        self._open = still_open
        return names

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``poll`` is due; None while no request is open."""
        return min([request.due_ns for request in self._open]) if self._open else None

    def _give_up(self, request: ParameterRequest) -> None:
        setting = request.setting
        names = " or ".join(request.names)
        self._note(
            setting, f"the autopilot does not tell its {quantity(setting)} ({names}): {self._assumption(setting)}"
        )

    def _assumption(self, setting: Setting) -> str:
        return f"{with_unit(setting, self._assumed.get(setting))} is assumed"

    def _note(self, setting: Setting, text: str) -> None:
        """Leave a note, unless the last one on this setting had the same text."""
        if self._noted.get(setting) != text:
            self._noted[setting] = text
            self._notebook.info(text)
