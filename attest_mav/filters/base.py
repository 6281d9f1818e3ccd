"""The protocol of every filter: frozen parameters, an ``initial`` state, and a pure ``step`` from state to state.

A snapshot is the state itself, a split run is a state kept and used again, and several lanes are several states of
one filter. No filter reads a clock: ``dt_s`` is the time since the previous sample, on the sensor's clock.
"""

from abc import abstractmethod
from math import nan
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.filters.calibration import SensorCalibration, SensorChanges
from attest_mav.innovation import Innovation
from attest_mav.record import Record
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.types import AirspeedSource, North, Quat, Vec3
from attest_mav.vehicle_settings import VehicleSettings

MAX_CORRECTION_DT_S: Final = 0.05
"""A correction after a gap counts for at most this long, s: the reading is one reading however long the gap was."""


@mypyc_attr(acyclic=True)  # as samples.Sample
class Start(Record):
    """Where a filter begins: the outcome of alignment."""

    def __init__(
        self, q_nb: Quat, gyro_bias: Vec3, north: North, accel: Vec3, mag: Vec3 | None, at_rest: bool = True
    ) -> None:
        self.q_nb: Final = q_nb
        """Body to NED, heading as ``north`` says."""
        self.gyro_bias: Final = gyro_bias
        """rad/s; zero if the vehicle was not still."""
        self.north: Final = north
        """The north that the heading refers to."""
        self.accel: Final = accel
        """Mean specific force behind the attitude, m/s^2."""
        self.mag: Final = mag
        """Mean field, gauss, or None."""
        self.at_rest: Final = at_rest
        """Whether the vehicle stood, as far as can be told."""


@mypyc_attr(acyclic=True)  # as samples.Sample
class BodyVelocity(Record):
    """Velocity in the body at one instant, m/s."""

    def __init__(
        self, forward: float, side: float = 0.0, down: float = 0.0, lateral_known: bool = True, is_new: bool = True
    ) -> None:
        self.forward: Final = forward
        """Along the nose."""
        self.side: Final = side
        """Along the body's y, 0 by assumption for a vehicle that goes where it points."""
        self.down: Final = down
        """Along the body's z, likewise."""
        self.lateral_known: Final = lateral_known
        """False where the vehicle can move sideways and how fast is not known."""
        self.is_new: Final = is_new
        """True only on the sample that first carries this velocity."""


@mypyc_attr(acyclic=True)  # as samples.Sample
class Airspeed(Record):
    """Speed through the air."""

    def __init__(self, speed: float, source: AirspeedSource) -> None:
        self.speed: Final = speed
        """m/s."""
        self.source: Final = source
        """Who measured or made it."""


@mypyc_attr(acyclic=True, free_list_len=1)  # as samples.Sample
class FilterInputs(Record):
    """Everything known besides the inertial sample, at the time of the sample."""

    def __init__(
        self,
        body_velocity: BodyVelocity | None = None,
        stationary: bool = False,
        latitude: float = nan,
        declination: float = nan,
        velocity: VelocitySample | None = None,
        heading: float | None = None,
        inclination: float = nan,
        airspeed: Airspeed | None = None,
        goes_where_it_points: bool = False,
        zero_mean_velocity: bool = True,
        samples_missing: bool = False,
    ) -> None:
        self.body_velocity: Final = body_velocity
        """For filters that level themselves by it; its source is a setting. None where nobody tells one."""
        self.stationary: Final = stationary
        """The vehicle stands still."""
        self.latitude: Final = latitude
        """rad, NaN where it is not known."""
        self.declination: Final = declination
        """Of the Earth's field, rad, east positive; NaN where it is not known."""
        self.velocity: Final = velocity
        """The newest velocity over ground, None while none is fresh enough. The same sample may come many times."""
        self.heading: Final = heading
        """From another source than the magnetometer, rad from the filter's north; None on samples without one."""
        self.inclination: Final = inclination
        """Of the Earth's field below the horizontal, rad, NaN where it is not known."""
        self.airspeed: Final = airspeed
        """None while none is fresh."""
        self.goes_where_it_points: Final = goes_where_it_points
        """Through the air the vehicle moves along its nose (a wing)."""
        self.zero_mean_velocity: Final = zero_mean_velocity
        """True unless the vehicle is armed or fast: the filter may then assume that velocity averages to zero."""
        self.samples_missing: Final = samples_missing
        """This step is much longer than the stream's usual one, so that motion may have gone unseen."""

    def with_velocity(self, velocity: VelocitySample | None) -> "FilterInputs":
        """The same inputs with another velocity over ground: an earlier one, one shifted in time, or none."""
        return FilterInputs(
            body_velocity=self.body_velocity,
            stationary=self.stationary,
            latitude=self.latitude,
            declination=self.declination,
            velocity=velocity,
            heading=self.heading,
            inclination=self.inclination,
            airspeed=self.airspeed,
            goes_where_it_points=self.goes_where_it_points,
            zero_mean_velocity=self.zero_mean_velocity,
            samples_missing=self.samples_missing,
        )


# Floats and flags form no cycles: compiled, a state is made faster without the collector. A filter outside the compiled
# core may extend state and filter.
@mypyc_attr(acyclic=True, allow_interpreted_subclasses=True)
class FilterState(Record):
    """The part that all states share; each filter adds its own fields."""

    def __init__(
        self,
        q_nb: Quat,
        gyro_bias: Vec3,
        accel_used: bool,
        mag_used: bool,
        tilt_sigma: float = nan,
        heading_sigma: float = nan,
    ) -> None:
        self.q_nb: Final = q_nb
        """Body to NED, unit length."""
        self.gyro_bias: Final = gyro_bias
        """rad/s, subtracted from the gyro."""
        self.accel_used: Final = accel_used
        """Whether the last step took the accelerometer for gravity."""
        self.mag_used: Final = mag_used
        """Whether the last step used the magnetometer."""
        self.tilt_sigma: Final = tilt_sigma
        """1-sigma of the tilt, rad, NaN for a filter without covariance."""
        self.heading_sigma: Final = heading_sigma
        """1-sigma of the heading, rad, NaN for a filter without covariance."""

    @property
    def aligned(self) -> bool:
        """False while a filter that aligns itself has no attitude yet: ``q_nb`` is then not to be shown."""
        return True

    @property
    def referred_to(self) -> North | None:
        """The north that the heading refers to; None where the filter leaves that to its caller."""
        return None

    @property
    def accel_bias(self) -> Vec3 | None:
        """Bias of the accelerometer, m/s^2, body; None where the filter does not estimate one."""
        return None

    @property
    def is_calibrated(self) -> bool:
        """True while it goes on from the sensor errors of earlier flights."""
        return False

    @property
    def sigma_is_proven(self) -> bool:
        """True while the sigmas cover the errors in flight too, so that a verdict may go by them."""
        return False

    @property
    def rests_on(self) -> str:
        """The aid that keeps the attitude from drifting, in words; "" for a filter that always does the same."""
        return ""

    @property
    def innovations(self) -> tuple[Innovation, ...]:
        """The records of the aids that had something to say in this step."""
        return ()


@mypyc_attr(allow_interpreted_subclasses=True)
class AttitudeFilter(Record):
    """The protocol. Subclasses are frozen dataclasses of parameters.

    A state made by one filter goes only into that filter's ``step``, which narrows it by a cast (the compiler
    refuses dataclasses with a generic base, so the type cannot say it).
    """

    @property
    @abstractmethod
    def name(self) -> str:
        """The name users type, for example ``gradient-descent``."""

    @property
    def aligns_itself(self) -> bool:
        """True if the filter does its own alignment: it can start from any sample and accepts steps longer than 1 s."""
        return False

    @property
    def uses_body_velocity(self) -> bool:
        """False if the filter has no use for ``FilterInputs.body_velocity``, which is then left out."""
        return True

    @property
    def default_settings(self) -> VehicleSettings:
        """The vehicle's settings that the filter uses while they are not known; NaN for those it does not ask for."""
        return VehicleSettings()

    def with_vehicle_settings(self, known: VehicleSettings) -> "AttitudeFilter":
        """The filter with the known settings in place of its defaults; states of the one go on in the other."""
        return self

    def with_calibration(self, known: SensorCalibration) -> "AttitudeFilter":
        """The filter that begins with these errors of its sensor; one that has no use for them as it is."""
        return self

    def after_changes(self, state: FilterState, changes: SensorChanges) -> FilterState:
        """The state after changes of the sensors; the same where it has none of their errors."""
        return state

    def learned(self, state: FilterState) -> SensorCalibration | None:
        """The errors of the sensor as its flight has shown them, None where it has shown none."""
        return None

    @abstractmethod
    def initial(self, start: Start) -> FilterState:
        """The state right after alignment."""

    @abstractmethod
    def step(self, state: FilterState, dt_s: float, sample: ImuSample, inputs: FilterInputs) -> FilterState:
        """The state ``dt_s`` seconds later, 0 < dt_s <= 1, given the sample taken then.

        Never raises on bad readings: one that is missing, not finite or out of its gate is not used.
        """
