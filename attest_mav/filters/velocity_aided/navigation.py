"""State of the aligned flight filter between two steps."""

from enum import IntEnum
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import is_finite_number
from attest_mav.filters.calibration import SensorChanges, SensorErrors
from attest_mav.filters.velocity_aided.aids.airspeed import Wind
from attest_mav.filters.velocity_aided.aids.fallback import Fallback
from attest_mav.filters.velocity_aided.aids.gnss_velocity import GnssVelocity
from attest_mav.filters.velocity_aided.aids.iron import IronFit
from attest_mav.filters.velocity_aided.aids.magnetometer import Magnetometer
from attest_mav.filters.velocity_aided.aids.zero_motion import Stationary
from attest_mav.filters.velocity_aided.calibration import after, is_refuted, known_by, without
from attest_mav.filters.velocity_aided.imu_memory import ImuMemory
from attest_mav.filters.velocity_aided.measurement import Measurement
from attest_mav.filters.velocity_aided.nav_state import NavigationState, cross_covariance_of, update
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.innovation import Innovation
from attest_mav.record import Record


class AidingMode(IntEnum):
    """Which aid keeps the attitude from drifting."""

    VELOCITY = 0
    """Velocity fixes."""
    STATIONARY = 1
    """Zero-rate and zero-velocity updates of a vehicle that stands."""
    COASTING = 2
    """None yet: the fixes have stopped, the velocity is carried on."""
    AIRSPEED = 3
    """The airspeed of a vehicle that goes where it points, with the wind as it was."""
    GRAVITY = 4
    """The mean specific force."""
    ZERO_MEAN_VELOCITY = 5
    """The mean velocity is zero: carried or turned by hand."""


@mypyc_attr(acyclic=True, free_list_len=1)
class Navigation(Record):
    """The estimate with the memory of prediction and of each aid."""

    def __init__(
        self,
        estimate: NavigationState,
        imu: ImuMemory,
        gnss: GnssVelocity,
        magnetometer: Magnetometer,
        iron: IronFit | None,
        stationary: Stationary,
        wind: Wind,
        fallback: Fallback,
        declination: float | None,
        mode: AidingMode,
        begun_with: SensorErrors | None,
        has_stepped: bool,
    ) -> None:
        self.estimate: Final = estimate
        """The navigation state with its covariance."""
        self.imu: Final = imu
        """Memory of dead reckoning."""
        self.gnss: Final = gnss
        """Velocity fusion."""
        self.magnetometer: Final = magnetometer
        """Magnetometer fusion."""
        self.iron: Final = iron
        """What turning in place has shown of the hard iron; None once a velocity has come, or under way."""
        self.stationary: Final = stationary
        """Stationary detector and zero updates."""
        self.wind: Final = wind
        """Wind estimate."""
        self.fallback: Final = fallback
        """Airspeed, gravity or zero mean velocity, as the mode says."""
        self.declination: Final = declination
        """Assumed declination, rad; None while it is not known, and headings are magnetic."""
        self.mode: Final = mode
        """Which aid holds the attitude."""
        self.begun_with: Final = begun_with
        """Sensor errors of earlier flights at the start; None where there were none, and once they are refuted."""
        self.has_stepped: Final = has_stepped
        """False at the start, whose memory still describes the time before a gap."""

    @property
    def assumed_declination(self) -> float:
        """Magnetic north east of the north that headings refer to, as assumed, rad."""
        return 0.0 if self.declination is None else self.declination

    @property
    def unshown_iron_sigma(self) -> float:
        """1-sigma of the heading for an iron that turning in place has not shown, rad; 0 elsewhere."""
        return 0.0 if self.iron is None else self.iron.heading_sigma

    @property
    def innovations(self) -> tuple[Innovation, ...]:
        """The records of this step's aids."""
        gnss, magnetometer, fallback = self.gnss.innovation, self.magnetometer.innovation, self.fallback.innovation
        records = self.stationary.innovations
        if gnss is not None:
            records = (gnss, *records)
        if fallback is not None:
            records = (*records, fallback)
        return records if magnetometer is None else (*records, magnetometer)

    def with_estimate(self, estimate: NavigationState, is_same_sensor: bool = True) -> "Navigation":
        """The same memories with another estimate, as a hypothesis about the past needs it, or another sensor.

        Another sensor begins with the errors that this estimate gives it: it has not shown them itself.
        """
        begun_with = self.begun_with
        if begun_with is not None and not is_same_sensor:
            begun_with = known_by(estimate)
        return self._with(estimate, self.imu.with_attitude(estimate), self.declination, begun_with)

    def with_declination(self, declination: float, parameters: FlightParameters) -> "Navigation":
        """The navigation with this assumed declination, rad; the same one if it is not known or no news."""
        if not is_finite_number(declination) or declination == self.declination:
            return self
        change = declination - self.assumed_declination
        estimate = _with_declination(self.estimate, change, self.declination is None, parameters)
        return self._with(estimate, self.imu, declination, self.begun_with)

    def without_refuted_calibration(self, parameters: FlightParameters) -> "Navigation":
        """The navigation without the sensor errors of earlier flights, once a fix has refuted them; else the same."""
        begun_with, fix_is_new = self.begun_with, self.gnss.since_fused_s == 0.0
        if begun_with is None or not (fix_is_new and is_refuted(self.estimate, begun_with)):
            return self
        return self.without_calibration(parameters)

    def after_changes(self, changes: SensorChanges, parameters: FlightParameters) -> "Navigation":
        """The navigation after changes of its sensors; earlier flights tell of those alone that are still the same."""
        estimate = after(self.estimate, changes, parameters)
        begun_with = None if changes.is_all_other or self.begun_with is None else known_by(estimate)
        return self._with(estimate, self.imu.with_attitude(estimate), self.declination, begun_with)

    def without_calibration(self, parameters: FlightParameters) -> "Navigation":
        """The navigation as uncertain as if no earlier flight had told of the sensor."""
        estimate = without(self.estimate, parameters)
        return self._with(estimate, self.imu.with_attitude(estimate), self.declination, None)

    def _with(
        self,
        estimate: NavigationState,
        imu: ImuMemory,
        declination: float | None,
        begun_with: SensorErrors | None,
    ) -> "Navigation":
        return Navigation(
            estimate,
            imu,
            self.gnss,
            self.magnetometer,
            self.iron,
            self.stationary,
            self.wind,
            self.fallback,
            declination,
            self.mode,
            begun_with,
            self.has_stepped,
        )


def _with_declination(
    nav: NavigationState, change: float, first: bool, parameters: FlightParameters
) -> NavigationState:
    """The state after the declination turned out ``change`` larger, rad; ``first``: it had not been known.

    Magnetic north stays where it was estimated; the first declination is a measurement of where that is.
    """
    error = nav.declination_error
    nav = nav.with_lags(nav.mag_lag_s, nav.fix_lag_s, error - change, nav.covariance)
    if not first:
        return nav
    measurement = Measurement(change - error, d=(0.0, 0.0, 1.0))
    return update(nav, measurement, cross_covariance_of(nav, measurement), parameters.declination_sigma**2)
