"""The north that headings refer to: the declination, and where it comes from."""

from math import degrees, isfinite, nan
from typing import Final

from attest_mav.earth_field import LocalField, field_at, simulated_field_at
from attest_mav.logs.source import FlightDate, VehicleSummary
from attest_mav.record import Record
from attest_mav.samples import PositionSample
from attest_mav.types import EarthField
from attest_mav.vehicle_settings import Setting


class LocalNorth(Record):
    """True north as far as the log tells it."""

    def __init__(self, field: LocalField | None, notes: tuple[str, ...] = ()) -> None:
        self.field: Final = field
        """None if headings stay magnetic: they are then not compared with a reference, which is true."""
        self.notes: Final = notes
        """Remarks for people."""

    @property
    def direction(self) -> EarthField:
        """The field for the filters; not known without a declination."""
        return EarthField() if self.field is None else self.field.direction


def north_of(vehicle: VehicleSummary, given_deg: float | None) -> LocalNorth:
    """True north at the vehicle's first position, in its world, else by the autopilot's own declination.

    given_deg: a declination that replaces the one looked up, degrees.
    """
    found = None if vehicle.position is None else _field_at(vehicle, vehicle.position)
    if given_deg is not None:
        return LocalNorth(LocalField(given_deg, nan if found is None else found.inclination_deg, "given"))
    if found is not None:
        note = "" if vehicle.date is None else vehicle.date.note
        return LocalNorth(found, (note,) if note else ())
    return _told_by_autopilot(vehicle)


def date_of(vehicle: VehicleSummary) -> FlightDate | None:
    """The date of the flight, None where the log does not tell it."""
    position = vehicle.position
    return vehicle.date or (None if position is None else FlightDate(position.rx_ns * 1e-9))


def _field_at(vehicle: VehicleSummary, position: PositionSample) -> LocalField:
    """The field of the simulator's world, or of this one on the day of the flight."""
    place = (position.latitude_deg, position.longitude_deg)
    found = simulated_field_at(*place) if vehicle.in_simulator else None
    date = vehicle.date or FlightDate(position.rx_ns * 1e-9)
    return found or field_at(*place, position.altitude_m, unix_s=date.unix_s)


def _told_by_autopilot(vehicle: VehicleSummary) -> LocalNorth:
    """The autopilot's setting. Nought is what it says before it has looked its declination up, unless it never does."""
    told = vehicle.settings.get(Setting.DECLINATION)
    looks_up = vehicle.settings.get(Setting.AUTO_DECLINATION) != 0.0
    names = [one.name for one in vehicle.parameters if one.setting == Setting.DECLINATION]
    if not isfinite(told) or not names:
        return _magnetic("the log has neither a position nor a parameter that tells the declination")
    if told == 0.0 and looks_up:
        return _magnetic(f"the log has no position, and its {names[0]} is 0: not looked up yet")
    field = LocalField(degrees(told), nan, f"the log's {names[0]}")
    return LocalNorth(field, (f"no position in the log: {names[0]} gives the declination, {degrees(told):+.1f} deg",))


def _magnetic(reason: str) -> LocalNorth:
    return LocalNorth(
        None, (f"headings are not compared: ours are magnetic and the reference's are true; {reason} (--declination)",)
    )
