"""The lasting errors of one inertial sensor as earlier flights of the same vehicle have shown them.

One flight cannot tell them before its first manoeuvre: while a vehicle stands or hovers, a bias of the accelerometer
looks like a tilt, and hard iron like a heading. The vehicle's earlier flights can. (Errors that are constant over a run
and change from run to run: Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd
ed., section 4.4.1.)
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.record import Record
from attest_mav.types import Mat3, Vec3


@mypyc_attr(acyclic=True)  # as samples.Sample
class UncertainVector(Record):
    """A vector that is known with a covariance."""

    def __init__(self, mean: Vec3, covariance: Mat3) -> None:
        self.mean: Final = mean
        self.covariance: Final = covariance
        """Of its error, in the unit of ``mean`` squared; symmetric."""


@mypyc_attr(acyclic=True)  # as samples.Sample
class SensorCalibration(Record):
    """Accelerometer bias and hard iron of one sensor, at the end of the flights that have shown them."""

    def __init__(self, accel_bias: UncertainVector, hard_iron: UncertainVector, age_s: float = 0.0) -> None:
        self.accel_bias: Final = accel_bias
        """Body, m/s^2; to be subtracted from the accelerometer."""
        self.hard_iron: Final = hard_iron
        """Body, gauss; to be subtracted from the magnetometer."""
        self.age_s: Final = age_s
        """Time since then, s, 0 or more."""
