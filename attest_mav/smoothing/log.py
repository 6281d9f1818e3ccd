"""A log through the smoother: the samples of its vehicle into a lane with a recorder, and the trajectory out."""

from array import array
from collections.abc import Iterator
from functools import partial

import numpy as np

from attest_mav.errors import UnreadableDataError
from attest_mav.estimation.lane import Lane
from attest_mav.estimation.pipeline import PipelineSettings
from attest_mav.estimation.vehicle import Vehicle
from attest_mav.filters.calibration import SensorCalibration
from attest_mav.filters.velocity_aided.calibration import at_start
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.logs.source import LogSource
from attest_mav.replay.log_time import LogTime
from attest_mav.replay.north import north_of
from attest_mav.replay.plan import make_plan
from attest_mav.replay.smoothed import FlightToSmooth, SmoothedAttitudes, SmoothedFlight, samples_of
from attest_mav.samples import AttitudeSample, ImuSample
from attest_mav.smoothing.noise import with_wide_priors
from attest_mav.smoothing.readings import Recording
from attest_mav.smoothing.recorder import Recorder
from attest_mav.smoothing.tables import Scratch
from attest_mav.smoothing.trajectory import SmoothedParts, Trajectory
from attest_mav.smoothing.white_noise import with_white_noise
from attest_mav.vehicle_reports import ParameterSample


def smooth(
    source: LogSource,
    imu: str | None = None,
    declination_deg: float | None = None,
    calibration: SensorCalibration | None = None,
) -> Trajectory:
    """Smooth the flight of a log source (``attest_mav.logs.formats.open_source``), in memory.

    imu: the inertial message; None to choose it as a replay does. declination_deg: east positive; None to look it up.
    calibration: errors of the sensor by earlier flights; a flight that contradicts them is smoothed without.
    UnreadableDataError where the log has no inertial message, or no attitude can be found to begin with.
    """
    flight = flight_of(source, imu, declination_deg, calibration)
    parts = parts_of(flight, Scratch())
    if parts is None:
        raise UnreadableDataError(
            f"{flight.imu} shows no attitude that a smoother could begin with; expected some seconds without a gap, "
            "with a compass or a velocity that changes"
        )
    return parts.whole()


def flight_of(
    source: LogSource,
    imu: str | None = None,
    declination_deg: float | None = None,
    calibration: SensorCalibration | None = None,
) -> FlightToSmooth:
    """The flight of a log source, see ``smooth``."""
    summary = source.summary()
    plan = make_plan(summary, imu, None)
    vehicle = summary.vehicles[plan.vehicle]
    one = VelocityAided().with_vehicle_settings(vehicle.settings)
    field = north_of(vehicle, declination_deg).direction
    return FlightToSmooth(
        samples_of(source, plan),
        plan.imu,
        vehicle.opening,
        field,
        PipelineSettings(),
        one.parameters,
        calibration=calibration,
    )


def smoothed_flight(flight: FlightToSmooth, scratch: Scratch) -> SmoothedFlight | None:
    """The smoothed attitudes as a replay takes them; None where no attitude can be found to begin with.

    scratch: keeps the tables, and is needed until the last attitude is taken.
    """
    parts = parts_of(flight, scratch)
    return None if parts is None else SmoothedFlight(partial(_runs, parts), parts.north, parts.noise, parts.has_refuted)


def _runs(parts: SmoothedParts) -> Iterator[SmoothedAttitudes]:
    """The attitudes of a flight, part by part."""
    for part in parts:
        rows = np.column_stack((part.q_nb, part.rates, part.tilt_sigma, part.heading_sigma))
        columns, times = array("d"), array("q")
        columns.frombytes(rows.tobytes())
        times.frombytes(part.t_ns.tobytes())
        yield SmoothedAttitudes(times, columns)


def parts_of(flight: FlightToSmooth, scratch: Scratch) -> SmoothedParts | None:
    """The smoothed flight; None where no attitude can be found to begin with. scratch: keeps the tables."""
    recording = recorded(flight, scratch)
    return None if recording is None else smoothed_parts(recording, flight)


def smoothed_parts(recording: Recording, flight: FlightToSmooth) -> SmoothedParts:
    """The smoothed flight by its recording."""
    known = None if flight.calibration is None else at_start(flight.calibration, flight.parameters)
    return SmoothedParts(recording, with_white_noise(with_wide_priors(flight.parameters), recording), known)


def recorded(flight: FlightToSmooth, scratch: Scratch) -> Recording | None:
    """The samples of a log, which pass the same lane as for a live filter; None as for ``parts_of``."""
    vehicle = Vehicle(flight.settings.aids)
    vehicle.field = flight.field
    for sample in flight.opening:
        vehicle.take(sample)
    recorder = Recorder(flight.parameters, scratch)
    lane = Lane(flight.imu, recorder, vehicle)
    time = LogTime()
    for sample in flight.samples:
        if isinstance(sample, ImuSample):
            is_ours = sample.source == flight.imu
            if is_ours and flight.start_s <= time.advance(sample.t_ns) <= flight.end_s:
                lane.handle(sample)
        elif not isinstance(sample, AttitudeSample | ParameterSample):
            vehicle.take(sample)
    return recorder.recording()
