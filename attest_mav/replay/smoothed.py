"""The smoothed attitude of a flight as a replay takes it: one for each inertial sample, a part of the flight at a time.

The smoother itself stands above the replay, because it needs numpy, which the compiled core does without; a request
brings it along.
"""

from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from math import inf, radians
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.estimation.pipeline import PipelineSettings
from attest_mav.filters.calibration import SensorCalibration
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.logs.source import LogSource, Plan
from attest_mav.samples import Sample
from attest_mav.types import EarthField, North, Quat, Vec3

LARGEST_TILT: Final = radians(1.0)
"""rad: nothing is compared with a smoothed attitude whose tilt sigma is larger,"""
LARGEST_HEADING: Final = radians(3.0)
"""rad: or whose heading sigma is."""
COLUMNS: Final = 9
"""Of a row: attitude, rates and both sigmas."""


@mypyc_attr(acyclic=True)  # as Sample
class SmoothedAttitude:
    """The smoothed attitude at one inertial sample."""

    def __init__(self, q_nb: Quat, rates: Vec3, tilt_sigma: float, heading_sigma: float) -> None:
        self.q_nb: Final = q_nb
        """Body to NED."""
        self.rates: Final = rates
        """Of the body, without bias, rad/s."""
        self.tilt_sigma: Final = tilt_sigma
        """1-sigma, rad."""
        self.heading_sigma: Final = heading_sigma
        """1-sigma, rad."""

    @property
    def is_sure(self) -> bool:
        """True where it is known well enough for others to be compared with it."""
        return self.tilt_sigma <= LARGEST_TILT and self.heading_sigma <= LARGEST_HEADING


class SmoothedAttitudes:
    """Those at consecutive inertial samples; 80 bytes a sample."""

    def __init__(self, t_ns: "array[int]", rows: "array[float]") -> None:
        self.t_ns: Final = t_ns
        """Sensor clock, ns."""
        self.rows: Final = rows
        """Attitude, rates and both sigmas of each sample."""


class SmoothedFlight:
    """All of them, in the order of the inertial samples.

    read: gives them anew from the beginning, a part of the flight at a time.
    """

    def __init__(
        self, read: Callable[[], Iterator[SmoothedAttitudes]], north: North, noise: str, has_refuted: bool = False
    ) -> None:
        self.north: Final = north
        self.noise: Final = noise
        """Name of the class of noise."""
        self.has_refuted: Final = has_refuted
        """Whether the flight contradicts the errors of the sensor by earlier flights; they were then not used."""
        self._read: Final = read
        self.begin()

    def begin(self) -> None:
        """The flight begins anew."""
        self._parts = self._read()
        self._part = SmoothedAttitudes(array("q"), array("d"))
        self._next = 0

    def at(self, t_ns: int) -> SmoothedAttitude | None:
        """The attitude at the next inertial sample, whose stamp is this (ns); None where that sample was not used."""
        if self._next >= len(self._part.t_ns):
            part = next(self._parts, None)
            if part is None:
                return None
            self._part, self._next = part, 0
        if self._part.t_ns[self._next] != t_ns:
            return None
        place = COLUMNS * self._next
        self._next += 1
        q_w, q_x, q_y, q_z, p, q, r, tilt_sigma, heading_sigma = self._part.rows[place : place + COLUMNS]
        return SmoothedAttitude((q_w, q_x, q_y, q_z), (p, q, r), tilt_sigma, heading_sigma)


def samples_of(source: LogSource, plan: Plan) -> Iterator[Sample]:
    """The samples of a log, one after the other."""
    for batch in source.samples(plan):
        yield from batch.samples


class FlightToSmooth:
    """The samples of a flight with everything that is known of it before it is smoothed."""

    def __init__(
        self,
        samples: Iterable[Sample],
        imu: str,
        opening: Sequence[Sample],
        field: EarthField,
        settings: PipelineSettings,
        parameters: FlightParameters,
        start_s: float = 0.0,
        end_s: float = inf,
        calibration: SensorCalibration | None = None,
    ) -> None:
        self.samples: Final = samples
        """All samples of the vehicle in order of time, to be read once."""
        self.imu: Final = imu
        """The inertial message."""
        self.opening: Final = opening
        """The vehicle as the log's first samples tell it."""
        self.field: Final = field
        self.settings: Final = settings
        self.parameters: Final = parameters
        """Of the flight filter, with the vehicle's settings in them."""
        self.start_s: Final = start_s
        self.end_s: Final = end_s
        """The part that is read, s of log time."""
        self.calibration: Final = calibration
        """Errors of the inertial sensor by earlier flights."""


Smooth = Callable[[FlightToSmooth], AbstractContextManager[SmoothedFlight | None]]
"""Smooths a flight, and keeps it while the context lasts; None where no attitude can be found to begin with."""
