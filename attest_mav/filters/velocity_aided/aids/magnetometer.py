"""The magnetometer: one row that turns the heading, and a watch on the field.

The row is the field's component along magnetic east, which is zero in truth. The field's strength and dip do not
enter it, so no model of them is needed; they are watched instead, for a disturbance shows in them too. What
can be seen of a disturbance is taken as the size of what cannot, for as long as ``disturbance_hold_s``.

RAW_IMU repeats a magnetometer of 10 Hz: a reading is new when it differs from the one before. At rest it may
stay the same for good reason, and is used again now and then.
"""

from math import cos, exp, sin, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import clamp, cross, dot, mat_vec, norm, q_exp, q_mul, q_to_matrix, scale, sub
from attest_mav.filters.velocity_aided.covariance import Row
from attest_mav.filters.velocity_aided.nav_state import STILL_RATE, Motion, reach_of, shown, taken
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import dequantised
from attest_mav.matrices import mat_t_vec
from attest_mav.types import ImuSample, Vec3

MAX_FIELD: Final = 1e3
"""gauss: a reading of this length or more is no field."""
REUSE_S: Final = 0.5
"""At rest an unchanged reading is used again after this long."""
REST_RATE: Final = 0.02
"""rad/s."""
POWER_SHARE: Final = 0.02
"""Share of a new innovation in their remembered mean square."""
POWER_STEP: Final = 9.0
"""One innovation counts for at most this many times the mean square."""
NOISE_FACTOR: Final = 2.0
"""The noise of a reading as a multiple of the innovations' rms."""
USUAL_S: Final = 60.0
"""Time constant with which the usual strength and dip follow an undisturbed field."""
LAG_ERROR_S: Final = 0.03
"""Of the magnetometer's lag: a turn by this much is no deviation of the dip."""


@mypyc_attr(acyclic=True)
class Compass:
    """What is remembered of the field, and the record of the last reading.

    last: the last reading, gauss, as received. held_s: since one was used. lost_s: since a reading
    corrected the heading. strength: gauss, and dip (sine), as they usually are; strength 0 before the first.
    disturbance: remembered deviation from the usual, as a share of the field. power: mean square innovation.
    innovation: of the last reading, as a share of the field (east positive to the left); nis: its normalised square.
    used: whether this step's reading corrected the heading.
    """

    def __init__(
        self,
        last: Vec3,
        held_s: float,
        lost_s: float,
        strength: float,
        dip: float,
        disturbance: float,
        power: float,
        innovation: float,
        nis: float,
        used: bool,
    ) -> None:
        self.last: Final = last
        self.held_s: Final = held_s
        self.lost_s: Final = lost_s
        self.strength: Final = strength
        self.dip: Final = dip
        self.disturbance: Final = disturbance
        self.power: Final = power
        self.innovation: Final = innovation
        self.nis: Final = nis
        self.used: Final = used


def no_field(settings: FlightParameters) -> Compass:
    """Before the first reading."""
    power = (settings.mag_sigma / NOISE_FACTOR) ** 2
    return Compass((0.0, 0.0, 0.0), 0.0, 1e9, 0.0, 0.0, 0.0, power, 0.0, 0.0, False)


def field_of(sample: ImuSample) -> Vec3 | None:
    """The sample's field, gauss, with half a unit given back; None when it is none."""
    mag = sample.mag
    if mag is None or not 0.0 < norm(mag) < MAX_FIELD:
        return None
    return dequantised(mag, sample.quantum.mag)


def is_due(compass: Compass, sample: ImuSample, dt_s: float, settings: FlightParameters) -> bool:
    """True when the sample's reading is a new one, and far enough from the last one used.

    One that comes too soon is not used later: it would be older than its lag says.
    """
    since_s = compass.held_s + dt_s
    if sample.mag != compass.last:
        return since_s > settings.mag_spacing_s or compass.strength <= 0.0
    return since_s > REUSE_S and norm(sample.gyro) < REST_RATE


def unread(compass: Compass, sample: ImuSample, dt_s: float) -> Compass:
    """The memory after a step whose reading is not used."""
    return Compass(
        compass.last if sample.mag is None else sample.mag,
        compass.held_s + dt_s,
        compass.lost_s,
        compass.strength,
        compass.dip,
        compass.disturbance,
        compass.power,
        compass.innovation,
        compass.nis,
        False,
    )


def steered(
    motion: Motion,
    compass: Compass,
    sample: ImuSample,
    field: Vec3,
    rate: Vec3,
    dt_s: float,
    declination: float,
    teaches: bool,
    settings: FlightParameters,
) -> tuple[Motion, Compass]:
    """Motion and memory after a new reading. ``field``: gauss. ``rate``: of the body, rad/s.

    teaches: it may tell something of the sensors.
    """
    row, levelled, strength = compass_row(motion, field, rate, declination)
    watched = _watch(compass, motion, strength, levelled[2], norm(rate), dt_s, settings)
    seen = reach_of(motion, row)
    sigma = clamp(NOISE_FACTOR * sqrt(compass.power), settings.mag_floor, settings.mag_ceiling)
    usual = sigma * sigma + (settings.mag_jitter_s * row.d[0]) ** 2
    surprise = abs(row.residual) / sqrt(seen.variance + usual)
    agrees = surprise < settings.mag_gate
    disturbance = watched.disturbance if agrees else max(watched.disturbance, abs(row.residual))
    # Equivalent variance of paper 2, eq. (16): from the knee on it grows with the residual.
    variance = usual * max(1.0, surprise / settings.mag_knee) + (settings.disturbance_weight * disturbance) ** 2
    power = compass.power
    if agrees:
        power += POWER_SHARE * (min(row.residual**2, POWER_STEP * power + 1e-8) - power)
    return taken(motion, row, seen, variance, teaches), Compass(
        compass.last if sample.mag is None else sample.mag,
        0.0,
        0.0 if agrees else compass.lost_s + compass.held_s + dt_s,
        watched.strength,
        watched.dip,
        disturbance,
        power,
        row.residual,
        surprise * surprise,
        agrees,
    )


def compass_row(motion: Motion, field: Vec3, rate: Vec3, declination: float) -> tuple[Row, Vec3, float]:
    """The row of a reading, the field's direction in NED without the iron, and its strength, gauss.

    The residual is the component along magnetic east, as a share of the strength, with its sign changed.
    """
    iron_free = sub(field, motion.hard_iron)
    strength = norm(iron_free)
    # The attitude at the time of the reading: the lag is short enough to turn back at the present rate.
    then = q_to_matrix(q_mul(motion.q_nb, q_exp(scale(rate, -0.5 * motion.delays[0]))))
    levelled = scale(mat_vec(then, iron_free), 1.0 / strength)
    north = declination + motion.delays[2]
    east: Vec3 = (-sin(north), cos(north), 0.0)
    lag = mat_vec(then, scale(cross(shown(rate, STILL_RATE), iron_free), 1.0 / strength))
    row = Row(
        -dot(east, levelled),
        t=cross(levelled, east),
        m=scale(mat_t_vec(then, east), -1.0 / strength),
        d=(-dot(east, lag), 0.0, -(cos(north) * levelled[0] + sin(north) * levelled[1])),
    )
    return row, levelled, strength


@mypyc_attr(acyclic=True)
class Watched:
    """The usual field and the remembered disturbance after a reading."""

    def __init__(self, strength: float, dip: float, disturbance: float) -> None:
        self.strength: Final = strength
        self.dip: Final = dip
        self.disturbance: Final = disturbance


def _watch(
    compass: Compass,
    motion: Motion,
    strength: float,
    dip: float,
    rate: float,
    dt_s: float,
    settings: FlightParameters,
) -> Watched:
    """Compare strength and dip with the usual ones. The dip may also be off by what the tilt may be off."""
    if compass.strength <= 0.0:
        return Watched(strength, dip, 0.0)
    free = settings.disturbance_free
    off_strength = max(0.0, abs(strength / compass.strength - 1.0) - free)
    off_dip = max(0.0, abs(dip - compass.dip) - free - 3.0 * motion.tilt_sigma - LAG_ERROR_S * rate)
    off = sqrt(off_strength * off_strength + off_dip * off_dip)
    since_s = compass.held_s + dt_s
    disturbance = max(off, compass.disturbance * exp(-since_s / settings.disturbance_hold_s))
    if off >= free:
        return Watched(compass.strength, compass.dip, disturbance)
    share = min(1.0, since_s / USUAL_S)
    return Watched(
        compass.strength + share * (strength - compass.strength), compass.dip + share * (dip - compass.dip), disturbance
    )
