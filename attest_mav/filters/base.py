"""What every filter is: a frozen record of parameters with ``initial`` and a pure ``step`` on an immutable state.

A snapshot is the state itself, a split run is a state kept and used again, and several lanes are several states of
one filter. No filter reads a clock: ``dt_s`` is the time since the previous sample, on the sensor's clock.
"""

from abc import abstractmethod
from math import nan
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.types import AirspeedSource, ImuSample, North, Quat, Vec3, VehicleSettings, VelocitySample

MAX_CORRECTION_DT_S: Final = 0.05
"""A correction after a gap counts for at most this long, s: the reading is one reading however long the gap was."""


class Start:
    """Where a filter begins: the outcome of alignment.

    q_nb: body to NED, heading as ``north`` says. gyro_bias: rad/s, zero if the vehicle was not still.
    accel, mag: the averaged readings behind it (m/s^2; gauss or None). at_rest: whether the vehicle stood, as
    far as can be told.
    """

    def __init__(
        self, q_nb: Quat, gyro_bias: Vec3, north: North, accel: Vec3, mag: Vec3 | None, at_rest: bool = True
    ) -> None:
        self.q_nb: Final = q_nb
        self.gyro_bias: Final = gyro_bias
        self.north: Final = north
        self.accel: Final = accel
        self.mag: Final = mag
        self.at_rest: Final = at_rest


class BodyVelocity:
    """Velocity in the body at one instant, m/s.

    forward: along the nose. side, down: along the body's y and z, 0 by assumption for a vehicle that goes where it
    points. lateral_known: False where the vehicle can move sideways and how fast is not known. is_new: True only on
    the sample that first carries this velocity.
    """

    def __init__(
        self, forward: float, side: float = 0.0, down: float = 0.0, lateral_known: bool = True, is_new: bool = True
    ) -> None:
        self.forward: Final = forward
        self.side: Final = side
        self.down: Final = down
        self.lateral_known: Final = lateral_known
        self.is_new: Final = is_new


class Airspeed:
    """Speed through the air, m/s, and where it comes from."""

    def __init__(self, speed: float, source: AirspeedSource) -> None:
        self.speed: Final = speed
        self.source: Final = source


class FilterInputs:
    """What is known besides the inertial sample, at the time of the sample.

    body_velocity: for filters that level themselves by it; its source is a setting. stationary: the vehicle stands
    still. latitude: rad; declination: rad, east positive; inclination: of the Earth's field below the horizontal, rad;
    each NaN where it is not known. velocity: the newest one over ground, None while none is fresh enough. heading: from
    another source than the magnetometer, rad from the filter's north, on the samples that carry one. airspeed: None
    while none is fresh. goes_where_it_points: through the air the vehicle moves along its nose (a wing).
    zero_mean_velocity: nothing says that the vehicle is under way, so its velocity may be assumed to average to zero.
    """

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
    ) -> None:
        self.body_velocity: Final = body_velocity
        self.stationary: Final = stationary
        self.latitude: Final = latitude
        self.declination: Final = declination
        self.velocity: Final = velocity
        self.heading: Final = heading
        self.inclination: Final = inclination
        self.airspeed: Final = airspeed
        self.goes_where_it_points: Final = goes_where_it_points
        self.zero_mean_velocity: Final = zero_mean_velocity


# Floats and flags form no cycles: compiled, a state is made faster without the collector. A filter outside the compiled
# core may extend state and filter.
@mypyc_attr(acyclic=True, allow_interpreted_subclasses=True)
class FilterState:
    """What all states share; each filter adds its own fields, its innovation among them.

    q_nb: unit, body to NED. gyro_bias: rad/s, subtracted from the gyro. accel_used, mag_used: whether the last step
    used that sensor. tilt_sigma, heading_sigma: 1-sigma in rad, NaN for a filter without covariance.
    """

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
        self.gyro_bias: Final = gyro_bias
        self.accel_used: Final = accel_used
        self.mag_used: Final = mag_used
        self.tilt_sigma: Final = tilt_sigma
        self.heading_sigma: Final = heading_sigma

    @property
    def aligned(self) -> bool:
        """False while a filter that aligns itself has no attitude yet: ``q_nb`` is then not to be shown."""
        return True

    @property
    def referred_to(self) -> North | None:
        """What the heading refers to; None where the filter leaves that to its caller."""
        return None

    @property
    def sigma_is_proven(self) -> bool:
        """True while the sigmas cover the errors in flight too, so that a verdict may go by them."""
        return False

    @property
    def rests_on(self) -> str:
        """What keeps the attitude from drifting at present, in words; "" for a filter that always does the same."""
        return ""

    @property
    def velocity_nis(self) -> float:
        """Normalised innovation squared of this step's velocity, mean of the axes; NaN without one."""
        return nan

    @property
    def field_nis(self) -> float:
        """Normalised innovation squared of this step's magnetometer reading, mean of the axes; NaN without one."""
        return nan


@mypyc_attr(allow_interpreted_subclasses=True)
class AttitudeFilter:
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
    def default_settings(self) -> VehicleSettings:
        """The vehicle's settings that the filter uses while they are not known; NaN for those it does not ask for."""
        return VehicleSettings()

    def with_vehicle_settings(self, known: VehicleSettings) -> "AttitudeFilter":
        """The filter with the known settings in place of its defaults; states of the one go on in the other."""
        return self

    @abstractmethod
    def initial(self, start: Start) -> FilterState:
        """The state right after alignment."""

    @abstractmethod
    def step(self, state: FilterState, dt_s: float, sample: ImuSample, inputs: FilterInputs) -> FilterState:
        """The state ``dt_s`` seconds later, 0 < dt_s <= 1, given the sample taken then.

        Never raises on bad readings: a sensor that is missing, not finite or out of its gate is not used, and the
        state says so.
        """
