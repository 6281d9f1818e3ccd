"""Recorded flights for programs: as arrays, and as the report of a replay."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from attest_mav.estimation.imu_frame import ImuFrame
from attest_mav.estimation.vehicle import AidSettings, Vehicle
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.velocity_aided.reading import dequantised
from attest_mav.library.readings import NS, Array, Readings
from attest_mav.logs.formats import open_source
from attest_mav.logs.source import LogSource, Plan
from attest_mav.replay.batch import replay_file
from attest_mav.replay.north import north_of
from attest_mav.replay.plan import make_plan
from attest_mav.replay.request import Request, Window
from attest_mav.replay.stamping import BurstStamp, Stamped
from attest_mav.runtime.files import open_log
from attest_mav.samples import AttitudeSample, ImuSample, Sample, VelocitySample
from attest_mav.types import NO_TIME, EarthField, Quat, Vec3
from attest_mav.vehicle_settings import VehicleSettings


@dataclass(frozen=True, eq=False)
class FlightLog:
    """A recorded flight as arrays. Times are of the sensor's clock, seconds from the first inertial sample."""

    readings: Readings
    """Gyro, accelerometer, magnetometer and velocity fixes, in FRD and NED; truncated integers are given back their
    half unit."""
    inertial: str
    """The message or record that they come from."""
    reference: str | None
    """The attitude to compare with: a simulator's truth, else the autopilot's own; None without one."""
    reference_t: Array
    """Shape (k,), s."""
    reference_attitudes: Array
    """Shape (k, 4), body of the inertial sensor to NED."""
    settings: VehicleSettings
    """The autopilot's settings that a filter may use: ``attitude_filter.with_vehicle_settings(log.settings)``."""


def read_log(path: str | Path, imu: str | None = None, reference: str | None = None) -> FlightLog:
    """The flight in a log of any format that ``attest-mav replay`` reads.

    imu, reference: names of the inertial message and of the attitude to compare with; None to choose them.
    UnreadableDataError says why a file cannot be read.
    """
    with open_log(path) as data:
        source = open_source(data, str(path))
        summary = source.summary()
        plan = make_plan(summary, imu, reference)
        vehicle = summary.vehicles[plan.vehicle]
        field = north_of(vehicle, None).direction
        collector = _Collector(plan, vehicle.opening)
        collector.take_all(source)
    return collector.flight(field, vehicle.settings)


def replay_log(
    path: str | Path, filters: Sequence[AttitudeFilter] = (), skip_s: float = 30.0, imu: str | None = None
) -> dict[str, Any]:
    """The report on a log, the object that ``attest-mav replay --json`` prints.

    filters: those to run; none for the flight filter. skip_s: time after alignment that the figures leave out, s.
    UnreadableDataError says why a file cannot be read.
    """
    return replay_file(str(path), Request(tuple(filters), imu=imu, window=Window(skip_s=skip_s)), open_log)


class _Collector:
    """Takes the samples of one vehicle in order of time."""

    def __init__(self, plan: Plan, opening: Sequence[Sample]) -> None:
        self._plan: Final = plan
        self._vehicle: Final = Vehicle(AidSettings())
        self._frame: Final = ImuFrame(self._vehicle)
        self._stamp: Final = BurstStamp()
        self._imu: Final[list[ImuSample]] = []
        self._fixes: Final[list[VelocitySample]] = []
        self._attitudes: Final[list[tuple[int, Quat]]] = []
        for sample in opening:
            self._vehicle.take(sample)

    def take_all(self, source: LogSource) -> None:
        """Read the log."""
        for batch in source.samples(self._plan):
            for sample in batch.samples:
                self._take(sample)
        self._take_stamped(self._stamp.finish())

    def _take(self, sample: Sample) -> None:
        if sample.source == self._plan.timing:
            self._take_stamped(self._stamp.timed(sample.t_ns, sample.rx_ns))
        if isinstance(sample, ImuSample):
            if sample.source == self._plan.imu and (not self._imu or sample.t_ns > self._imu[-1].t_ns):
                self._imu.append(sample)
        elif isinstance(sample, AttitudeSample):
            self._take_attitude(sample)
        else:
            self._vehicle.take(sample)
            velocity = self._vehicle.velocity(sample.rx_ns)
            if velocity is not None and (not self._fixes or velocity.t_ns > self._fixes[-1].t_ns):
                self._fixes.append(velocity)

    def _take_attitude(self, sample: AttitudeSample) -> None:
        self._vehicle.self_report.take(sample)
        if sample.source != self._plan.reference:
            return
        turned = self._frame.attitude(sample)
        if turned is None:
            return
        if turned.t_ns == NO_TIME:
            self._take_stamped(self._stamp.untimed(turned))
        else:
            self._attitudes.append((turned.t_ns, turned.q_nb))

    def _take_stamped(self, stamped: Stamped | None) -> None:
        if stamped is not None:
            self._attitudes.append((stamped.t_ns, stamped.sample.q_nb))

    def flight(self, field: EarthField, settings: VehicleSettings) -> FlightLog:
        """The flight as arrays."""
        begin = self._imu[0].t_ns if self._imu else 0
        times = np.array([t_ns for t_ns, _ in self._attitudes], dtype=np.int64)
        return FlightLog(
            self._readings(begin, field),
            self._plan.imu,
            self._plan.reference,
            (times - begin) / NS,
            np.array([q for _, q in self._attitudes], dtype=np.float64).reshape(-1, 4),
            settings,
        )

    def _readings(self, begin: int, field: EarthField) -> Readings:
        imu, fixes = self._imu, self._fixes
        has_mag = any(one.mag is not None for one in imu)
        return Readings(
            _seconds([one.t_ns for one in imu], begin),
            [dequantised(one.gyro, one.quantum.gyro) for one in imu],
            [dequantised(one.accel, one.quantum.accel) for one in imu],
            [_field_of(one) for one in imu] if has_mag else None,
            [_velocity_of(one) for one in fixes] or None,
            velocity_t=_seconds([one.t_ns for one in fixes], begin) if fixes else None,
            velocity_sigma=[nan if one.sigma is None else one.sigma for one in fixes] or None,
            declination=field.declination,
            inclination=field.inclination,
        )


def _seconds(times: list[int], begin: int) -> npt.NDArray[np.float64]:
    found: npt.NDArray[np.float64] = (np.array(times, dtype=np.int64) - begin) / NS
    return found


def _field_of(sample: ImuSample) -> Vec3:
    return (nan, nan, nan) if sample.mag is None else dequantised(sample.mag, sample.quantum.mag)


def _velocity_of(sample: VelocitySample) -> Vec3:
    north, east, down = sample.v_ned
    return (north, east, down if sample.vertical_known else nan)
