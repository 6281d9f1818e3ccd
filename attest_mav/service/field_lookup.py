"""The Earth's magnetic field at the vehicle: looked up at its first position, and again far from there."""

from collections.abc import Callable
from math import degrees, isfinite
from typing import Final

from attest_mav.mavlink.component.line_limit import LineLimit
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.samples import PositionSample
from attest_mav.types import EarthField

FieldFinder = Callable[[float, float, float], tuple[EarthField, str]]
"""From latitude, longitude (degrees) and altitude (m) to the Earth's field and the name of the model."""

PAUSE_NS: Final = 10_000_000_000
"""Pause between two look-ups: no vehicle is half a degree away sooner, and each one takes half a millisecond."""
FAR_DEG: Final = 0.5
"""Change of latitude or longitude after which the field is looked up again, degrees; nearer, it is nearly the same."""


class FieldLookup:
    """Decides when to look the field up. ``declination``: the configured one, rad, which stays; NaN: looked up too."""

    def __init__(self, find: FieldFinder, declination: float, notebook: Notebook) -> None:
        self._find: Final = find
        self._declination: Final = declination
        self._notebook: Final = notebook
        self._place: tuple[float, float] | None = None
        self._next_ns = 0
        self._lines: Final = LineLimit()

    def at(self, position: PositionSample) -> EarthField | None:
        """The field there; None where the last one still holds, where the model knows none, and for no place at all."""
        place = (position.latitude_deg, position.longitude_deg)
        last = self._place
        if last is not None and max(abs(place[0] - last[0]), abs(place[1] - last[1])) < FAR_DEG:
            return None
        if position.rx_ns < self._next_ns or abs(place[0]) > 90.0 or abs(place[1]) > 180.0:
            return None
        self._place, self._next_ns = place, position.rx_ns + PAUSE_NS
        found, model = self._find(*place, position.altitude_m)
        if not isfinite(found.declination):
            return None
        if isfinite(self._declination):
            return EarthField(self._declination, found.inclination)
        suffix = self._lines.suffix("declination", position.rx_ns)
        if suffix is not None:
            declination_deg = degrees(found.declination)
            self._notebook.info(f"headings are true: declination {declination_deg:+.2f} degrees by {model}{suffix}")
        return found
