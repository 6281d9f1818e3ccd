"""The Earth's magnetic field at a place and date, by the World Magnetic Model."""

import sys
from importlib.util import find_spec, module_from_spec
from math import radians
from typing import Any, Final

from attest_mav.record import Record
from attest_mav.types import EarthField

SECONDS_PER_YEAR: Final = 31_556_952.0
"""Mean Gregorian year. The field moves by 0.2 degrees a year at most where people fly: days do not matter."""
FIRST_YEAR: Final = 2010.0
"""Start of the oldest model at hand."""
LAST_YEAR: Final = 2030.0
"""End of the newest."""
NEWEST_MODEL_YEAR: Final = 2025.0
PLAUSIBLE_YEAR: Final = 2005.0
"""Clocks that say less were never set (1970, 1980, 2000): MAVLink is younger."""


class LocalField(Record):
    """The direction of the field at a place."""

    def __init__(self, declination_deg: float, inclination_deg: float, source: str) -> None:
        self.declination_deg: Final = declination_deg
        """Magnetic north east of true north, degrees."""
        self.inclination_deg: Final = inclination_deg
        """Below the horizontal, degrees; NaN where only the declination was given."""
        self.source: Final = source
        """The model, with place and date."""

    @property
    def direction(self) -> EarthField:
        """The same in radians."""
        return EarthField(radians(self.declination_deg), radians(self.inclination_deg))


def year_of(unix_s: float) -> float:
    """The year of a UNIX time, with its fraction."""
    return 1970.0 + unix_s / SECONDS_PER_YEAR


def field_at(latitude_deg: float, longitude_deg: float, altitude_m: float, unix_s: float) -> LocalField:
    """The field there and then. A date that no model covers is answered by the nearest one, which says so."""
    # Costs 40 ms and is needed by few commands.
    from pygeomag import GeoMag  # noqa: PLC0415

    year, remark = _model_year(year_of(unix_s))
    model = GeoMag(base_year=min(year, LAST_YEAR - 1.0))
    field = model.calculate(
        glat=latitude_deg, glon=longitude_deg, alt=1e-3 * altitude_m, time=year, allow_date_outside_lifespan=True
    )
    place = f"{latitude_deg:.3f}, {longitude_deg:.3f}"
    return LocalField(float(field.d), float(field.i), f"{model.model} at {place} in {year:.1f}{remark}")


def simulated_field_at(latitude_deg: float, longitude_deg: float) -> LocalField | None:
    """The field there in ArduPilot's simulator, None off its table.

    Its world has the field of a coarse table, of one year, that pymavlink carries too: up to a degree from the model's.
    """
    found = _simulator_table().get_mag_field_ef(latitude_deg, longitude_deg)
    if found is None:
        return None
    declination_deg, inclination_deg, _ = found
    place = f"{latitude_deg:.3f}, {longitude_deg:.3f}"
    return LocalField(declination_deg, inclination_deg, f"the table of ArduPilot's simulator at {place}")


def _simulator_table() -> Any:
    """A copy of pymavlink's module of that table, for one call.

    The module does without pymavlink's quaternions where there is no numpy. They are withheld here unless they are
    loaded already: the table needs none, and numpy takes 100 ms. The copy is nobody else's, who may want them.
    """
    spec = find_spec("pymavlink.mavextra")
    if spec is None or spec.loader is None:
        raise ModuleNotFoundError("pymavlink.mavextra")
    module = module_from_spec(spec)
    quaternions = "pymavlink.quaternion"
    is_withheld = quaternions not in sys.modules
    if is_withheld:
        sys.modules[quaternions] = None  # type: ignore[assignment]  # Python's way to say that it is not there
    try:
        spec.loader.exec_module(module)
    finally:
        if is_withheld:
            del sys.modules[quaternions]
    return module


def _model_year(year: float) -> tuple[float, str]:
    """The year to look the field up for, and a remark when it is not the year of the log."""
    if year < PLAUSIBLE_YEAR:
        return NEWEST_MODEL_YEAR, f" (the log's clock says {year:.0f}; the newest model's first year is taken)"
    if year < FIRST_YEAR:
        return FIRST_YEAR, f" (the log is of {year:.1f}; the oldest model begins here)"
    if year > LAST_YEAR:
        return LAST_YEAR, f" (the log is of {year:.1f}; the newest model ends here)"
    return year, ""
