"""Our own parameters: a small fixed set that ground stations may read and set over MAVLink, where a link allows it.

A value that somebody has set holds in place of the configured one, with the name of who set it. All are REAL32, which
is the same in both encodings of parameters that autopilots use.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from struct import Struct
from typing import Final

from attest_mav.mavlink.component.line_limit import LineLimit
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.schedule import Station

_REAL32: Final = Struct("<f")


@dataclass(frozen=True)
class OwnParameter:
    """One parameter, in the unit and the range of its configuration key."""

    name: str
    """At most 16 characters."""
    low: float
    high: float
    """Values outside are moved to the nearer end."""
    in_flight: bool = False
    """Whether it may be set while the vehicle is armed."""


RATE: Final = OwnParameter("ATT_RATE", 0.01, 1000.0, in_flight=True)
"""``output.rate_hz``."""
MAX_SIGMA: Final = OwnParameter("ATT_MAX_SIG", 0.01, 180.0)
"""``output.max_sigma_deg``."""
TILT_LIMIT: Final = OwnParameter("ATT_TILT_LIM", 0.0, 90.0)
"""``verdict.tilt_deg``; 0 is its "auto"."""
HOLD: Final = OwnParameter("ATT_HOLD", 0.0, 60.0)
"""``verdict.hold_s``."""

OWN_PARAMETERS: Final = (RATE, MAX_SIGMA, TILT_LIMIT, HOLD)
"""In the order of their indices."""


@dataclass(frozen=True)
class ParameterChange:
    """A value in place of the configured one."""

    value: float
    by: str
    """Ids of the station that set it, and the link."""


class OwnParameters:
    """The values in force. ``configured``: those of the configuration by name; parameters without one do not exist."""

    def __init__(self, configured: Mapping[str, float], notebook: Notebook) -> None:
        self.table: Final = [one for one in OWN_PARAMETERS if one.name in configured]
        """The parameters, by index."""
        self.is_armed = False
        """Whether the vehicle is armed: most parameters cannot be set then."""
        self.changes: Final[dict[str, ParameterChange]] = {}
        """The values that were set, by name."""
        self._configured = dict(configured)
        self._notebook: Final = notebook
        self._lines: Final = LineLimit(10)
        self._is_changed = False

    def value(self, name: str) -> float:
        """The value in force."""
        change = self.changes.get(name)
        return self._configured[name] if change is None else change.value

    def configure(self, configured: Mapping[str, float]) -> None:
        """Take other configured values of the same parameters; a value that somebody has set stays in force."""
        before = {one.name: self.value(one.name) for one in self.table}
        self._configured = {one.name: configured[one.name] for one in self.table}
        self._is_changed |= any(self.value(name) != value for name, value in before.items())

    def find(self, name: str) -> int:
        """The index of the parameter with this name, -1 for none."""
        return next((index for index, one in enumerate(self.table) if one.name == name), -1)

    def restore(self, changes: Mapping[str, ParameterChange]) -> None:
        """Go on with values that were set before a restart; names that are not known are dropped."""
        for parameter in self.table:
            change = changes.get(parameter.name)
            if change is not None and isfinite(change.value):
                self._put(parameter, change.value, change.by)
                value, own = self.value(parameter.name), self._configured[parameter.name]
                self._notebook.info(
                    f"{parameter.name} is {value:g}, set by {change.by}; the configuration says {own:g}"
                )

    def set(self, index: int, value: float, station: Station, link: str, now_ns: int) -> None:
        """Set a parameter, unless the value is no number or the vehicle is armed; each attempt is a line of the log."""
        parameter = self.table[index]
        if not isfinite(value):
            self.refuse(index, "not a number", station, link, now_ns)
        elif self.is_armed and not parameter.in_flight:
            self.refuse(index, "the vehicle is armed", station, link, now_ns)
        else:
            before = self.value(parameter.name)
            self._put(parameter, value, f"{station.name} on {link}")
            after = self.value(parameter.name)
            if after != before:
                self._tell(f"{station.name} has set {parameter.name} to {after:g} (was {before:g})", link, now_ns)

    def refuse(self, index: int, reason: str, station: Station, link: str, now_ns: int) -> None:
        """Tell that a parameter was not set."""
        self._tell(f"{station.name} may not set {self.table[index].name}: {reason}", link, now_ns)

    def take_change(self) -> bool:
        """True once after values have changed."""
        is_changed = self._is_changed
        self._is_changed = False
        return is_changed

    def _put(self, parameter: OwnParameter, value: float, by: str) -> None:
        """Put a value in force, moved into its range; the configured one takes its own place again."""
        name = parameter.name
        value = min(max(value, parameter.low), parameter.high)
        if _real32(value) == _real32(self.value(name)):
            return
        self._is_changed = True
        if _real32(value) == _real32(self._configured[name]):
            del self.changes[name]
        else:
            self.changes[name] = ParameterChange(value, by)

    def _tell(self, text: str, link: str, now_ns: int) -> None:
        suffix = self._lines.suffix("set", now_ns)
        if suffix is not None:
            self._notebook.warning(f"{link}: {text}{suffix}")


def _real32(value: float) -> bytes:
    """The value as PARAM_VALUE carries it."""
    return _REAL32.pack(value)
