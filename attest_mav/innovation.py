"""The innovation record: one aid's measurement in a step, its residual from the prediction, and its use.

Every aid of every filter leaves this record in each step in which it had something to say, used or not. One record is
the column of a table, the figure in a report, the line of a log and the hook of a test at once (after EKF2's
``estimator_aid_source`` messages of PX4).
"""

from enum import IntEnum
from math import nan
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.record import Record


class Aid(IntEnum):
    """A source of information besides the integrated inertial sensor."""

    VELOCITY = 0
    """Velocity over ground, NED, m/s."""
    MAGNETOMETER = 1
    """Direction of the magnetic field, as a share of its strength."""
    ZERO_RATE = 2
    """The gyro of a vehicle that stands shows its bias, rad/s."""
    ZERO_VELOCITY = 3
    """The velocity of a vehicle that stands, m/s."""
    AIRSPEED = 4
    """Velocity through the air, in the body, m/s."""
    GRAVITY = 5
    """The accelerometer taken for gravity: horizontal specific force, m/s^2, or a unit vector in the body."""
    ZERO_MEAN_VELOCITY = 6
    """Zero velocity in the mean, m/s: a vehicle that is carried or turned by hand."""
    SPEED = 7
    """Velocity in the body, m/s, from a speed along the nose or from all components."""
    CONSTANT_VELOCITY = 8
    """The last velocity in the body, m/s, of a vehicle whose speed is not known."""
    HEADING = 9
    """Heading, rad, by the levelled field or from another source."""
    UNIT_LENGTH = 10
    """The constraint that the down vector has unit length."""


class Fusion(IntEnum):
    """Use of a measurement."""

    USED = 0
    """Fused with its usual variance."""
    INFLATED = 1
    """Fused with a larger variance, because the residual lay outside the gate or the field is disturbed."""
    OUTSIDE_GATE = 2
    """Rejected: the residual is too large for its variance."""
    IMPLAUSIBLE = 3
    """Rejected: not finite, beyond any sensor's range, saturated, or no specific force near 1 g."""
    TOO_OLD = 4
    """Rejected: from before the history of velocities, or from the future."""
    UNINFORMATIVE = 5
    """Left out: the state is known better than the measurement could tell."""
    REDUNDANT = 6
    """Left out: a better aid is at work."""
    NOT_ALONE = 7
    """Left out: fused only beside another aid that this step lacks."""


@mypyc_attr(acyclic=True)  # as Sample
class Innovation(Record):
    """One aid in one step. Vectors have one element for each scalar measurement."""

    def __init__(
        self,
        aid: Aid,
        fusion: Fusion,
        t_ns: int,
        observation: tuple[float, ...] = (),
        residual: tuple[float, ...] = (),
        variance: tuple[float, ...] = (),
    ) -> None:
        self.aid: Final = aid
        """Which aid; it names the unit."""
        self.fusion: Final = fusion
        """Whether the measurement was used, or why not."""
        self.t_ns: Final = t_ns
        """The time that the measurement itself carries, sensor clock, ns."""
        self.observation: Final = observation
        """Measured or assumed values; empty for a reading that could not be one."""
        self.residual: Final = residual
        """Measured minus predicted; empty where nothing was predicted."""
        self.variance: Final = variance
        """Innovation variances, the state's and the measurement's before any inflation; empty without a covariance."""

    @property
    def is_used(self) -> bool:
        """True when the measurement changed the state."""
        return self.fusion <= Fusion.INFLATED

    @property
    def nis(self) -> float:
        """Normalised innovation squared, mean over the scalar measurements: 1 where the variances are true.

        NaN without variances.
        """
        count = len(self.variance)
        if count == 0:
            return nan
        total = 0.0
        for index in range(count):
            residual = self.residual[index]
            total += residual * residual / self.variance[index] / count
        return total
