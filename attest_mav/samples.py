"""The records of inertial sensors, attitudes, velocities, positions and air data; units and frames as in ``types``."""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.record import Record
from attest_mav.types import (
    EXACT,
    NO_TIME,
    AirspeedSource,
    AttitudeForm,
    AttitudeRole,
    Quantum,
    Quat,
    Vec3,
    VelocityOrigin,
)


# Numbers, text and other records form no cycles: compiled, a record is made faster without the collector.
@mypyc_attr(acyclic=True)
class Sample(Record):
    """Base of everything a decoder makes out of one message.

    ``source`` names the stream (the MAVLink message or log record), ``system`` and ``component`` who sent it.
    """

    def __init__(self, source: str, system: int, component: int, t_ns: int, rx_ns: int) -> None:
        self.source: Final = source
        self.system: Final = system
        self.component: Final = component
        self.t_ns: Final = t_ns
        self.rx_ns: Final = rx_ns


@mypyc_attr(acyclic=True)  # as Sample
class ImuSample(Sample):
    """One reading of one inertial sensor, in SI units, body frame.

    gyro: angular rate, rad/s. accel: specific force, m/s^2. mag: field, gauss; None when the message carries
    none or a field of zeros. saturated: a gyro or accelerometer component is at 99 % of its range or more. quantum: the
    resolution of the readings. has_field, field: the same as mag without an object for it; field holds nothing where
    has_field is False.
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
        self.has_field: Final = mag is not None
        self.field: Final[Vec3] = (0.0, 0.0, 0.0) if mag is None else mag
        self.saturated: Final = saturated
        self.quantum: Final = quantum

    @property
    def mag(self) -> Vec3 | None:
        """The field, gauss; None when the sample has none."""
        return self.field if self.has_field else None

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


@mypyc_attr(acyclic=True)  # as Sample
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


@mypyc_attr(acyclic=True)  # as Sample
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


@mypyc_attr(acyclic=True)  # as Sample
class PositionSample(Sample):
    """A position good enough to look up the declination: GPS_RAW_INT with a 3-D fix.

    Latitude and longitude in degrees (people's units: they are only ever shown or looked up), altitude in m.
    satellites: number of those that the receiver uses. dilution: horizontal dilution of precision. None for one that is
    not told.
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
        satellites: int | None = None,
        dilution: float | None = None,
    ) -> None:
        super().__init__(source, system, component, t_ns, rx_ns)
        self.latitude_deg: Final = latitude_deg
        self.longitude_deg: Final = longitude_deg
        self.altitude_m: Final = altitude_m
        self.satellites: Final = satellites
        self.dilution: Final = dilution


@mypyc_attr(acyclic=True)  # as Sample
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
