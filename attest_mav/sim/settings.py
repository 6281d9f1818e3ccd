"""Settings of a simulation: frozen records with a default for everything."""

from dataclasses import dataclass, field

from attest_mav.sim.earth import Earth
from attest_mav.sim.faults import Fault
from attest_mav.types import Vec3


@dataclass(frozen=True)
class SensorErrors:
    """Errors of an inertial unit and its magnetometer, each axis and each unit for itself.

    Noise densities are such that a sample at the rate f has the deviation density * sqrt(f). Biases are deviations of a
    constant drawn once; drifts are random walks on top of it, with the deviation drift * sqrt(t) after the time t.
    The defaults are a middling MEMS unit after the autopilot's own calibration.
    """

    gyro_noise: float = 1.0e-4
    """rad/s/sqrt(Hz)."""
    gyro_bias: float = 1.5e-3
    """rad/s."""
    gyro_drift: float = 3.0e-5
    """rad/s/sqrt(s): 0.03 deg/s after five minutes."""
    accel_noise: float = 2.0e-3
    """m/s^2/sqrt(Hz)."""
    accel_bias: float = 0.02
    """m/s^2: 2 mg."""
    accel_drift: float = 1.0e-4
    """m/s^2/sqrt(s)."""
    mag_noise: float = 2.0e-3
    """gauss, one reading of the chip."""
    mag_bias: float = 2.0e-3
    """gauss: what calibration has left of the vehicle's own field."""


PERFECT = SensorErrors(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Sensors without errors; the message's own resolution stays."""


@dataclass(frozen=True)
class SimSettings:
    """One simulated vehicle."""

    personality: str = "ardupilot"
    """``ardupilot`` or ``px4``."""
    scenario: str = "hover"
    """One of ``scenarios.SCENARIOS``."""
    fast_rate_hz: float | None = None
    """Rate of the IMU, attitude and truth messages at the start, 1 to 1000 Hz; None is the firmware's own default."""
    loop_rate_hz: int | None = None
    """Main loop, 10 to 1000 Hz; None is the firmware's default, or as much more as ``fast_rate_hz`` needs.

    ArduPilot's ceiling on message rates follows from it.
    """
    low_pass_hz: float | None = None
    """Corner of the low-pass that the inertial messages have passed; None is the firmware's default."""
    system: int = 1
    earth: Earth = field(default_factory=Earth)
    errors: SensorErrors = field(default_factory=SensorErrors)
    attitude_error: Vec3 = (0.0015, 0.0015, 0.004)
    """Amplitude, rad in NED, of the slow errors of the attitude the autopilot reports: 0.1 and 0.2 degrees."""
    trim: Vec3 = (0.0, 0.0, 0.0)
    """ArduPilot's AHRS_TRIM_X, _Y and _Z, rad: the reported attitude is turned by it, the inertial readings are not."""
    first_fix_s: float = 3.0
    """GPS has no fix before, and GLOBAL_POSITION_INT no position."""
    mag_offset: Vec3 = (0.11, -0.06, 0.08)
    """gauss: the vehicle's own field, which PX4 leaves in SCALED_IMU. Calibrated messages are without it."""
    faults: tuple[Fault, ...] = ()
    """Faults with their times; ``fault_text.parse_faults`` reads the text that users write."""
