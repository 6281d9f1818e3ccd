"""Reads the parameters of an autopilot that carry the settings of the vehicle.

A filter needs some of them; others tell the rotation between the reported attitude and the inertial messages. Each
parameter is requested by name with PARAM_REQUEST_READ, one at a time. An autopilot does not answer for a name that it
does not have, and names change between releases. The names of a setting are therefore tried in turn, at doubling
intervals; without an answer the filter keeps its own assumption. A value that comes unasked is asked again before it
counts (``parameter_request``), unless nothing may be asked.
"""

from collections.abc import Sequence
from math import isfinite
from typing import Final

from attest_mav.mavlink.component.line_limit import LineLimit
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.parameter_request import MAX_TRIES, Answer, ParameterRequest, same
from attest_mav.mavlink.constants import MAV_AUTOPILOT_INVALID
from attest_mav.mavlink.decode.autopilot_parameters import names_of
from attest_mav.vehicle_reports import ParameterSample
from attest_mav.vehicle_settings import (
    ACCELEROMETERS,
    MAGNETOMETERS,
    SENSOR_NUMBERS,
    Setting,
    VehicleSettings,
    quantity,
    with_unit,
)

SPACING_NS: Final = 50_000_000
"""Two requests are at least this far apart: a slow radio link carries them beside everything else."""
DOUBT_PAUSE_NS: Final = 60_000_000_000
"""After a value was refuted or contradicted, the same setting is asked again after this time at the earliest."""

FRAME_SETTINGS: Final = (
    Setting.TRIM_X,
    Setting.TRIM_Y,
    Setting.TRIM_Z,
    Setting.PITCH_TRIM,
    Setting.FLIGHT_OPTIONS,
    Setting.HOVERS,
    Setting.ESTIMATOR,
    Setting.DECLINATION,
    Setting.AUTO_DECLINATION,
)
"""Requested for every filter: the frame and the north of the autopilot's attitude."""
HOVER_SETTINGS: Final = (Setting.HOVER_PITCH_TRIM, Setting.TAILSITTER, Setting.HOVER_FRAME)
"""Requested besides of a plane that hovers; others do not have them."""


def settings_of_sensor(source: str) -> list[Setting]:
    """Requested of each inertial source that is heard: what tells its sensors from others."""
    number = SENSOR_NUMBERS.get(source)
    if number is None:
        return []
    accel, mag = ACCELEROMETERS[number], MAGNETOMETERS[number]
    return [Setting.BOARD_ORIENTATION, accel.device, *accel.offset, mag.device, *mag.offset]


class AutopilotSettings:
    """The settings of one vehicle and the open requests for them. ``poll`` returns names to request; it does not send.

    asks: False requests nothing and only listens. default_settings: the filter's own; those that are not NaN are
    requested, and hold until the autopilot has answered. ``FRAME_SETTINGS`` are requested of every autopilot that has
    them.
    """

    def __init__(self, asks: bool, default_settings: VehicleSettings, notebook: Notebook) -> None:
        self.hovers = False
        """True once a plane has told that it can hover."""
        self.doubts: Final[dict[Setting, str]] = {}
        """Settings of which values came that the autopilot does not confirm, in words."""
        self._wanted: Final = [setting for setting in Setting if isfinite(default_settings.get(setting))]
        self._asks: Final = asks
        self._assumed: Final = default_settings
        self._notebook: Final = notebook
        self._open: list[ParameterRequest] = []
        self._noted: dict[Setting, str] = {}
        self._sensors: Final[set[str]] = set()
        self._identified: Final[set[Setting]] = set()
        self._known: Final[dict[Setting, float]] = {}
        self._quiet_ns: Final[dict[Setting, int]] = {}
        self._lines: Final = LineLimit()
        self._autopilot = MAV_AUTOPILOT_INVALID
        self._is_plane = False
        self._next_ns = 0

    def begin(self, autopilot: int, is_plane: bool, now_ns: int) -> None:
        """Request every setting: a vehicle was found, found again, or has rebooted. ``autopilot``: MAV_AUTOPILOT."""
        self._open = []
        self._autopilot, self._is_plane, self.hovers = autopilot, is_plane, False
        self._next_ns = now_ns
        self._request([*self._wanted, *FRAME_SETTINGS], now_ns)
        self._forget_sensors()

    def identify(self, source: str, now_ns: int) -> None:
        """Request what tells the sensors of this source, which was heard, from others; once for each boot."""
        if source in self._sensors:
            return
        self._sensors.add(source)
        fresh = [one for one in settings_of_sensor(source) if one not in self._identified]
        self._identified.update(fresh)
        self._request(fresh, now_ns)

    def forget(self) -> None:
        """Drop all requests and notes: there is no vehicle any more, or another one."""
        self._open = []
        self._noted = {}
        self._forget_sensors()
        self._known.clear()
        self._quiet_ns.clear()
        self.doubts.clear()

    def _forget_sensors(self) -> None:
        self._sensors.clear()
        self._identified.clear()

    @property
    def is_answered(self) -> bool:
        """Whether the autopilot has answered a request for a parameter, or sent one that counts."""
        return bool(self._known)

    def received(self, sample: ParameterSample) -> bool:
        """The vehicle sent a parameter, whoever had requested it; True when its value counts."""
        if self._asks and not self._is_proven(sample):
            return False
        setting = sample.setting
        self._known[setting] = sample.value
        self._open = [request for request in self._open if request.setting != setting]
        if setting == Setting.HOVERS and sample.value != 0.0 and not self.hovers:
            self.hovers = True
            self._request(HOVER_SETTINGS, sample.rx_ns)
        if setting in self._wanted:
            self._note_value(sample)
        return True

    def _is_proven(self, sample: ParameterSample) -> bool:
        """Whether the value answers requests of ours; if not, the next steps are taken to find out."""
        setting, value, now_ns = sample.setting, sample.value, sample.rx_ns
        known = self._known.get(setting)
        request = next((one for one in self._open if one.setting == setting), None)
        if request is None:
            if known is not None and same(value, known):
                return True
            due_ns = max(now_ns, self._quiet_ns.get(setting, now_ns))
            self._open.append(ParameterRequest(setting, [sample.name], due_ns, is_doubt=known is not None))
            return False
        if request.tries == 0:
            return False
        answer = request.judge(value, known, now_ns)
        if answer == Answer.COUNTS:
            self.doubts.pop(setting, None)
            return True
        if answer != Answer.UNPROVEN and known is not None:
            self._doubt(sample, known, answer)
        return False

    def _doubt(self, sample: ParameterSample, known: float, answer: Answer) -> None:
        """Keep the known value, and say that there is another sender."""
        setting = sample.setting
        self._open = [request for request in self._open if request.setting != setting]
        self._quiet_ns[setting] = sample.rx_ns + DOUBT_PAUSE_NS
        reason = "a value came unasked" if answer == Answer.REFUTED else "it is told with two values"
        self.doubts[setting] = f"{sample.name}: {reason}, {with_unit(setting, known)} is kept"
        suffix = self._lines.suffix(sample.name, sample.rx_ns)
        if suffix is not None:
            self._notebook.warning(f"{self.doubts[setting]}: another sender uses the autopilot's ids{suffix}")

    def _note_value(self, sample: ParameterSample) -> None:
        """Note the value of a setting that the filter wants."""
        setting = sample.setting
        subject = f"the autopilot's {quantity(setting)}"
        if isfinite(sample.value):
            self._note(setting, f"{subject} is {with_unit(setting, sample.value)} ({sample.name})")
        else:
            self._note(setting, f"{subject} is left to a driver ({sample.name} is 0): {self._assumption(setting)}")

    def poll(self, now_ns: int) -> list[str]:
        """The name of the parameter to request now, in a list; empty while none is due."""
        for request in self._open:
            if request.tries >= MAX_TRIES and now_ns >= request.due_ns:
                self._give_up(request)
        self._open = [request for request in self._open if request.tries < MAX_TRIES or now_ns < request.due_ns]
        due = [request for request in self._open if now_ns >= request.due_ns]
        if not due or now_ns < self._next_ns:
            return []
        self._next_ns = now_ns + SPACING_NS
        return [due[0].next_name(now_ns)]

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``poll`` is due; None while no request is open."""
        return max(min([request.due_ns for request in self._open]), self._next_ns) if self._open else None

    def _request(self, settings: Sequence[Setting], now_ns: int) -> None:
        """Open a request for each setting that this autopilot's vehicle has."""
        if not self._asks:
            return
        for setting in settings:
            names = names_of(setting, self._autopilot, self._is_plane)
            if names:
                self._open.append(ParameterRequest(setting, names, now_ns))

    def _give_up(self, request: ParameterRequest) -> None:
        """Note a setting that is missed; a trim once for all its angles."""
        setting = request.setting
        if setting in self._known:
            return
        if setting in self._wanted:
            consequence = self._assumption(setting)
        elif setting == Setting.TRIM_X:
            consequence = "a steady offset of its attitude is measured instead"
        else:
            return
        names = " or ".join(request.names)
        self._note(setting, f"the autopilot does not tell its {quantity(setting)} ({names}): {consequence}")

    def _assumption(self, setting: Setting) -> str:
        return f"{with_unit(setting, self._assumed.get(setting))} is assumed"

    def _note(self, setting: Setting, text: str) -> None:
        """Leave a note, unless the last one on this setting had the same text."""
        if self._noted.get(setting) != text:
            self._noted[setting] = text
            self._notebook.info(text)
