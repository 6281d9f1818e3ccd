"""What every filter is: a frozen record of parameters with ``initial`` and a pure ``step`` on an immutable state.

A snapshot is the state itself, a split run is a state kept and used again, and several lanes are several states of
one filter. No filter reads a clock: ``dt_s`` is the time since the previous sample, on the sensor's clock.
"""

from abc import abstractmethod
from dataclasses import dataclass
from math import nan
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.types import ImuSample, North, Quat, Setting, Vec3, VelocitySample

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


class Aids:
    """What is known besides the inertial sample, at the time of the sample. NaN means not known.

    forward_speed: along the nose, m/s, with ``forward_speed_fresh`` True only on the sample that first carries a new
    value. stationary: the vehicle stands still. latitude: rad. declination: rad, east positive. velocity: the newest
    one over ground, None while none is fresh enough, with ``velocity_fresh`` as above. airspeed: m/s. heading: from
    another source than the magnetometer, rad from the filter's north; finite only on the samples that carry one.
    side_speed, down_speed: along the body's y and z at the instant of forward_speed, m/s; 0 for a vehicle that goes
    where it points, NaN for one that does not and whose sideways motion is not known. inclination: of the Earth's field
    below the horizontal, rad. in_place: nothing says that the vehicle is under way: what moves is carried or turned by
    hand, and stays where it is on average.
    """

    def __init__(
        self,
        forward_speed: float = nan,
        forward_speed_fresh: bool = False,
        stationary: bool = False,
        latitude: float = nan,
        declination: float = nan,
        velocity: VelocitySample | None = None,
        velocity_fresh: bool = False,
        airspeed: float = nan,
        airspeed_fresh: bool = False,
        heading: float = nan,
        side_speed: float = 0.0,
        down_speed: float = 0.0,
        inclination: float = nan,
        in_place: bool = True,
    ) -> None:
        self.forward_speed: Final = forward_speed
        self.forward_speed_fresh: Final = forward_speed_fresh
        self.stationary: Final = stationary
        self.latitude: Final = latitude
        self.declination: Final = declination
        self.velocity: Final = velocity
        self.velocity_fresh: Final = velocity_fresh
        self.airspeed: Final = airspeed
        self.airspeed_fresh: Final = airspeed_fresh
        self.heading: Final = heading
        self.side_speed: Final = side_speed
        self.down_speed: Final = down_speed
        self.inclination: Final = inclination
        self.in_place: Final = in_place


@dataclass(frozen=True)
class VehicleFacts:
    """What is known of the vehicle's settings (``Setting``), each NaN while it is not."""

    low_pass_hz: float = nan
    fix_delay_s: float = nan

    def of(self, setting: Setting) -> float:
        """The value of one setting."""
        return self.low_pass_hz if setting == Setting.LOW_PASS_HZ else self.fix_delay_s

    def told(self, setting: Setting, value: float) -> "VehicleFacts":
        """The facts with one setting as it was told last; NaN takes back what was told before."""
        if setting == Setting.LOW_PASS_HZ:
            return VehicleFacts(value, self.fix_delay_s)
        return VehicleFacts(self.low_pass_hz, value)


@mypyc_attr(acyclic=True)  # floats and flags form no cycles; compiled, a state is made faster without the collector
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
    def aided(self) -> bool:
        """True while a velocity over ground tells acceleration from tilt: a fresh one, or one carried on a while."""
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
        """True for a filter that takes any sample for a start, and steps of more than a second: it aligns by itself."""
        return False

    @property
    def assumed(self) -> VehicleFacts:
        """What it takes the vehicle's settings to be while nobody tells it; NaN where it does not want to be told."""
        return VehicleFacts()

    def informed(self, facts: VehicleFacts) -> "AttitudeFilter":
        """The filter with these facts in place of what it assumes; states of the one go on in the other."""
        return self

    @abstractmethod
    def initial(self, start: Start) -> FilterState:
        """The state right after alignment."""

    @abstractmethod
    def step(self, state: FilterState, dt_s: float, sample: ImuSample, aids: Aids) -> FilterState:
        """The state ``dt_s`` seconds later, 0 < dt_s <= 1, given the sample taken then.

        Never raises on bad readings: a sensor that is missing, not finite or out of its gate is not used, and the
        state says so.
        """
