"""The charter: units, frames, time, and the value types every layer shares.

Units
    SI and radians everywhere inside the package; degrees only where a person reads or writes.
    Magnetic fields are in gauss (the Earth's is 0.25 to 0.65 gauss). Standard gravity is ``G_MPS2``.

Frames
    Body ``b`` is FRD (forward, right, down). World ``n`` is NED (north, east, down).
    ``q_nb`` is a unit Hamilton quaternion (w, x, y, z) that turns body vectors into NED:
    ``v_n = q_nb * v_b * conj(q_nb)``. It is exactly what MAVLink's ATTITUDE_QUATERNION carries.
    The accelerometer measures specific force: (0, 0, -g) when level and at rest.

Time
    Instants are integer nanoseconds, intervals are float seconds. ``t_ns`` is the sensor's clock, the
    time that the message itself carries; ``rx_ns`` is the host's clock at reception. Filters use
    ``t_ns`` only. ``NO_TIME`` marks messages that carry none.

North
    ``North`` says what a heading refers to. Magnetic and true north differ by the declination
    (positive east): true = magnetic + declination.

Meaning
    A filter compares no message name. Who measured a value, with which resolution, and what it may be used for stand
    in fields: ``Quantum``, ``VelocityOrigin``, ``AttitudeRole``, ``AttitudeForm``, ``VehicleKind``,
    ``AirspeedSource``. ``source`` is for people, and for choosing one stream among several.

Records made once a sample are plain classes, set once and never changed afterwards: compiled, they are
made in some 30 ns, where a frozen dataclass takes 550.
"""

from enum import IntEnum
from math import isfinite, nan
from typing import Final

from attest_mav.innovation import Innovation

Vec3 = tuple[float, float, float]
Quat = tuple[float, float, float, float]
Mat3 = tuple[Vec3, Vec3, Vec3]
"""Three rows."""

G_MPS2: Final = 9.80665
"""Standard gravity; MAVLink's milli-g are thousandths of it."""

NO_TIME: Final = -1
"""``t_ns`` of a message that carries no timestamp (SIM_STATE, SIMSTATE, AHRS2)."""


class North(IntEnum):
    """What a heading is measured from."""

    RELATIVE = 0
    """Nothing: the heading at the start was taken as zero, or has drifted since the field was lost."""
    MAGNETIC = 1
    TRUE = 2


class Setting(IntEnum):
    """A setting of the vehicle that the autopilot can tell. Switches and choices are numbers, as the autopilot's."""

    LOW_PASS_HZ = 0
    """Corner of the low-pass that gyro and accelerometer have passed, Hz; 0 for none."""
    FIX_DELAY_S = 1
    """Age of the receiver's velocity at the time that GPS_RAW_INT names, s."""
    ACCEL_LOW_PASS_HZ = 2
    """Corner of the accelerometer's low-pass where it has one of its own, Hz; 0 for none."""
    TRIM_X = 3
    """First angle of the trim between the reported attitude and the inertial sensor's, rad."""
    TRIM_Y = 4
    """Second angle, rad."""
    TRIM_Z = 5
    """Third angle, rad."""
    ESTIMATOR = 6
    """The estimator that the autopilot is set to use, a number of ``Estimator``."""
    PITCH_TRIM = 7
    """Pitch of level flight that a plane takes off the pitch it reports, rad."""
    FLIGHT_OPTIONS = 8
    """A plane's options as bits."""
    HOVER_PITCH_TRIM = 9
    """Pitch of a VTOL plane in the hover, rad."""
    HOVERS = 10
    """Other than 0 for a plane that can hover."""
    TAILSITTER = 11
    """Other than 0 for a plane that hovers nose-up."""
    HOVER_FRAME = 12
    """Class of a VTOL plane's frame."""
    DECLINATION = 13
    """Declination that the autopilot uses, rad, east positive."""
    AUTO_DECLINATION = 14
    """Other than 0 where the autopilot looks its declination up."""
    LOW_PASS_DELAY_SIGMA_S = 15
    """Uncertainty of the low-pass's delay where its corner is only assumed, s; 0 once the autopilot has told it."""


_OTHERS_UNKNOWN: Final = (nan,) * (len(Setting) - 2)
"""The values of all settings behind the first two."""


class VehicleSettings:
    """The settings of the vehicle (``Setting``) as far as they are known; NaN where one is not.

    others: the values of all settings behind the first two, in order.
    """

    def __init__(
        self, low_pass_hz: float = nan, fix_delay_s: float = nan, others: tuple[float, ...] = _OTHERS_UNKNOWN
    ) -> None:
        self.low_pass_hz: Final = low_pass_hz
        self.fix_delay_s: Final = fix_delay_s
        self._values: Final = (low_pass_hz, fix_delay_s, *others)

    def get(self, setting: Setting) -> float:
        """The value of one setting."""
        return self._values[setting]

    def get_or(self, setting: Setting, default: float) -> float:
        """The value of one setting, the default where it is not known."""
        value = self._values[setting]
        return value if isfinite(value) else default

    def updated(self, setting: Setting, value: float) -> "VehicleSettings":
        """The settings with one of them replaced; NaN takes back an earlier value."""
        values = list(self._values)
        values[setting] = value
        if setting == Setting.LOW_PASS_HZ:
            values[Setting.LOW_PASS_DELAY_SIGMA_S] = nan
        return VehicleSettings(values[0], values[1], tuple(values[2:]))

    def __eq__(self, other: object) -> bool:
        """Equal where the same settings are known with the same values."""
        return isinstance(other, VehicleSettings) and repr(self) == repr(other)

    def __hash__(self) -> int:
        return hash(repr(self))

    def __repr__(self) -> str:
        """The known settings, every digit of them."""
        known = [f"{one.name}={self._values[one]!r}" for one in Setting if isfinite(self._values[one])]
        return f"VehicleSettings({', '.join(known)})"


class Estimator(IntEnum):
    """The autopilot's attitude estimators, by ArduPilot's numbers (AHRS_EKF_TYPE)."""

    DCM = 0
    """The direction cosine matrix, the fallback."""
    EKF2 = 2
    EKF3 = 3
    SIMULATOR = 10
    """The simulator's truth."""
    EXTERNAL = 11
    """A sensor that brings its own estimator."""


Version = tuple[int, int, int]
"""Major, minor and patch number of a firmware."""


class VehicleKind(IntEnum):
    """How a vehicle can move; it decides which speeds tell something of its attitude."""

    UNKNOWN = 0
    """Nothing is known, or the kind allows any motion (submarines, balloons)."""
    ROTARY = 1
    """Copters and helicopters: they move in any direction."""
    WING = 2
    """Aeroplanes, and VTOL vehicles, which fly as aeroplanes when they are fast: through the air they go where they
    point."""
    SURFACE = 3
    """Ground vehicles and boats: over ground they go where they point."""


class Quantum:
    """The resolution of an inertial sample's readings: one count of gyro (rad/s), accel (m/s^2) and mag (gauss).

    Readings are truncated toward zero to whole counts; 0 means that they are exact.
    """

    def __init__(self, gyro: float, accel: float, mag: float) -> None:
        self.gyro: Final = gyro
        self.accel: Final = accel
        self.mag: Final = mag


EXACT: Final = Quantum(0.0, 0.0, 0.0)
"""The quantum of readings that are floating-point numbers."""


class EarthField:
    """The direction of the Earth's magnetic field where the vehicle is; rad, NaN where it is not known.

    declination: east of true north. inclination: below the horizontal.
    """

    def __init__(self, declination: float = nan, inclination: float = nan) -> None:
        self.declination: Final = declination
        self.inclination: Final = inclination


class Sample:
    """Base of everything a decoder makes out of one message.

    ``source`` names the stream (the MAVLink message or log record), ``system`` and ``component`` who sent it.
    """

    def __init__(self, source: str, system: int, component: int, t_ns: int, rx_ns: int) -> None:
        self.source: Final = source
        self.system: Final = system
        self.component: Final = component
        self.t_ns: Final = t_ns
        self.rx_ns: Final = rx_ns


class ImuSample(Sample):
    """One reading of one inertial sensor, in SI units, body frame.

    gyro: angular rate, rad/s. accel: specific force, m/s^2. mag: field, gauss; None when the message carries
    none or a field of zeros. saturated: a gyro or accelerometer component is at 99 % of its range or more. quantum: the
    resolution of the readings.
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        t_ns: int,
        rx_ns: int,
        gyro: Vec3,
        accel: Vec3,
        mag: Vec3 | None,
        saturated: bool = False,
        quantum: Quantum = EXACT,
    ) -> None:
        super().__init__(source, system, component, t_ns, rx_ns)
        self.gyro: Final = gyro
        self.accel: Final = accel
        self.mag: Final = mag
        self.saturated: Final = saturated
        self.quantum: Final = quantum

    def with_readings(self, gyro: Vec3, accel: Vec3, mag: Vec3 | None) -> "ImuSample":
        """The same sample with other readings; units as above."""
        return ImuSample(
            self.source,
            self.system,
            self.component,
            self.t_ns,
            self.rx_ns,
            gyro,
            accel,
            mag,
            self.saturated,
            self.quantum,
        )


class AttitudeRole(IntEnum):
    """Whose attitude a sample carries, and so what it may be used for."""

    AUTOPILOT = 0
    """The attitude that the autopilot flies by: the one to be judged (ATTITUDE, ATTITUDE_QUATERNION)."""
    SECONDARY = 1
    """Another estimator of the autopilot: context, never judged (AHRS2)."""
    TRUTH = 2
    """A simulator's own state (SIM_STATE, SIMSTATE)."""


class AttitudeForm(IntEnum):
    """How the message writes the attitude. Where one sender sends both, the quaternion is used."""

    EULER = 0
    QUATERNION = 1


class AttitudeSample(Sample):
    """An attitude that someone else reports.

    q_nb: body to NED, true north. rates: body angular rate, rad/s, or None where the message has none. role: whose it
    is. form: how it was written. euler: roll, pitch and yaw as sent, rad, None where it was written otherwise.
    frame_known: False where a rotation between the autopilot's body and the inertial sensor's may be left in it.
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        t_ns: int,
        rx_ns: int,
        q_nb: Quat,
        rates: Vec3 | None,
        role: AttitudeRole,
        form: AttitudeForm = AttitudeForm.EULER,
        euler: Vec3 | None = None,
        frame_known: bool = True,
    ) -> None:
        super().__init__(source, system, component, t_ns, rx_ns)
        self.q_nb: Final = q_nb
        self.rates: Final = rates
        self.role: Final = role
        self.form: Final = form
        self.euler: Final = euler
        self.frame_known: Final = frame_known

    def with_attitude(self, q_nb: Quat, frame_known: bool) -> "AttitudeSample":
        """The same sample with another attitude; the Euler angles stay as they were sent."""
        return AttitudeSample(
            self.source,
            self.system,
            self.component,
            self.t_ns,
            self.rx_ns,
            q_nb,
            self.rates,
            self.role,
            self.form,
            self.euler,
            frame_known,
        )


class VelocityOrigin(IntEnum):
    """Who measured a velocity. It decides its delay, and whether it is independent of the autopilot's estimator."""

    RECEIVER = 0
    """A satellite receiver, unfiltered: late by the receiver's delay (GPS_RAW_INT; GPS records of logs)."""
    ESTIMATOR = 1
    """The autopilot's own estimator: not independent, nearly without delay (GLOBAL_POSITION_INT)."""


class VelocitySample(Sample):
    """Velocity over ground in NED, m/s.

    ``vertical_known`` is False where the message has no vertical velocity (its z is then 0). ``origin``: who measured.
    ``sigma``: the uncertainty that the receiver itself reports, m/s an axis; None where it reports none.
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        t_ns: int,
        rx_ns: int,
        v_ned: Vec3,
        vertical_known: bool,
        origin: VelocityOrigin,
        sigma: float | None = None,
    ) -> None:
        super().__init__(source, system, component, t_ns, rx_ns)
        self.v_ned: Final = v_ned
        self.vertical_known: Final = vertical_known
        self.origin: Final = origin
        self.sigma: Final = sigma

    def with_velocity(self, v_ned: Vec3) -> "VelocitySample":
        """The same sample with another velocity, m/s."""
        return self._with(self.t_ns, v_ned)

    def with_time(self, t_ns: int) -> "VelocitySample":
        """The same sample of another instant, ns."""
        return self._with(t_ns, self.v_ned)

    def _with(self, t_ns: int, v_ned: Vec3) -> "VelocitySample":
        return VelocitySample(
            self.source,
            self.system,
            self.component,
            t_ns,
            self.rx_ns,
            v_ned,
            self.vertical_known,
            self.origin,
            self.sigma,
        )


class PositionSample(Sample):
    """A position good enough to look up the declination: GPS_RAW_INT with a 3-D fix.

    Latitude and longitude in degrees (people's units: they are only ever shown or looked up), altitude in m.
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        t_ns: int,
        rx_ns: int,
        latitude_deg: float,
        longitude_deg: float,
        altitude_m: float,
    ) -> None:
        super().__init__(source, system, component, t_ns, rx_ns)
        self.latitude_deg: Final = latitude_deg
        self.longitude_deg: Final = longitude_deg
        self.altitude_m: Final = altitude_m


class AirspeedSource(IntEnum):
    """Where an airspeed comes from."""

    SENSOR = 0
    """A pitot tube, by its own message or record."""
    REPORTED = 1
    """The autopilot's display value (VFR_HUD): a sensor's where there is one, else made of groundspeed and wind."""


class AirDataSample(Sample):
    """Speeds for display: airspeed and groundspeed in m/s, climb in m/s upward; NaN for one that is not known.

    groundspeed and climb are the autopilot's own estimates. airspeed_source: where the airspeed comes from. VFR_HUD
    carries no time.
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        rx_ns: int,
        airspeed: float,
        groundspeed: float,
        climb: float,
        airspeed_source: AirspeedSource = AirspeedSource.REPORTED,
    ) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.airspeed: Final = airspeed
        self.groundspeed: Final = groundspeed
        self.climb: Final = climb
        self.airspeed_source: Final = airspeed_source


class HeartbeatSample(Sample):
    """HEARTBEAT: who is there.

    ``vehicle_type`` is MAV_TYPE, ``kind`` how such a vehicle moves, ``autopilot`` MAV_AUTOPILOT, ``status`` MAV_STATE,
    ``mode`` the autopilot's own number of its flight mode.
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        rx_ns: int,
        vehicle_type: int,
        autopilot: int,
        armed: bool,
        status: int,
        kind: VehicleKind = VehicleKind.UNKNOWN,
        mode: int = 0,
    ) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.vehicle_type: Final = vehicle_type
        self.kind: Final = kind
        self.autopilot: Final = autopilot
        self.armed: Final = armed
        self.status: Final = status
        self.mode: Final = mode


class LandedSample(Sample):
    """EXTENDED_SYS_STATE: whether the vehicle is on the ground, by the autopilot's own landing detector."""

    def __init__(self, source: str, system: int, component: int, rx_ns: int, on_ground: bool) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.on_ground: Final = on_ground


class ClockSample(Sample):
    """SYSTEM_TIME: ``t_ns`` is time since boot, ``unix_us`` the wall clock in microseconds (0 when unknown)."""

    def __init__(self, source: str, system: int, component: int, t_ns: int, rx_ns: int, unix_us: int) -> None:
        super().__init__(source, system, component, t_ns, rx_ns)
        self.unix_us: Final = unix_us


class ParameterSample(Sample):
    """PARAM_VALUE of a parameter that tells a setting. ``name`` is the autopilot's; PARAM_VALUE carries no time.

    value: in the unit of the setting, NaN where the autopilot leaves the setting to a default that it does not tell.
    is_listed: it is part of a list of all parameters, and so no news; False for an answer and for a change.
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        rx_ns: int,
        name: str,
        setting: Setting,
        value: float,
        is_listed: bool = False,
    ) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.name: Final = name
        self.setting: Final = setting
        self.value: Final = value
        self.is_listed: Final = is_listed


class FirmwareSample(Sample):
    """The version of the autopilot's firmware, as AUTOPILOT_VERSION or its first words tell it."""

    def __init__(self, source: str, system: int, component: int, rx_ns: int, version: Version) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.version: Final = version


class EstimatorSample(Sample):
    """The autopilot's word that from now on this estimator makes the attitude that it reports."""

    def __init__(self, source: str, system: int, component: int, rx_ns: int, estimator: Estimator) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.estimator: Final = estimator


class Estimate:
    """What one lane's filter says about one IMU sample.

    lane: the IMU message. filter_name: the filter. q_nb: body to NED, sign-continuous. rates: bias-corrected body
    angular rate, rad/s. north: what the heading refers to. tilt_sigma, heading_sigma: 1-sigma, rad, NaN where the
    filter has no covariance. dt_s: the step that led here, s. delay_s: how much later than usual the sample came, s.
    innovations: of the aids that had something to say in this step. sigma_is_proven: the sigmas cover the errors in
    flight too.
    """

    def __init__(
        self,
        lane: str,
        filter_name: str,
        t_ns: int,
        rx_ns: int,
        q_nb: Quat,
        rates: Vec3,
        north: North,
        tilt_sigma: float,
        heading_sigma: float,
        dt_s: float,
        delay_s: float = 0.0,
        innovations: tuple[Innovation, ...] = (),
        sigma_is_proven: bool = False,
    ) -> None:
        self.lane: Final = lane
        self.filter_name: Final = filter_name
        self.t_ns: Final = t_ns
        self.rx_ns: Final = rx_ns
        self.q_nb: Final = q_nb
        self.rates: Final = rates
        self.north: Final = north
        self.tilt_sigma: Final = tilt_sigma
        self.heading_sigma: Final = heading_sigma
        self.dt_s: Final = dt_s
        self.delay_s: Final = delay_s
        self.innovations: Final = innovations
        self.sigma_is_proven: Final = sigma_is_proven
