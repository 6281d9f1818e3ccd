"""A log through the smoother: the samples of its vehicle into a lane with a recorder, and the trajectory out."""

from array import array

import numpy as np

from attest_mav.errors import UnreadableDataError
from attest_mav.estimation.lane import Lane
from attest_mav.estimation.pipeline import PipelineSettings
from attest_mav.estimation.vehicle import Vehicle
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.logs.source import LogSource
from attest_mav.replay.log_time import LogTime
from attest_mav.replay.north import north_of
from attest_mav.replay.plan import make_plan
from attest_mav.replay.smoothed import FlightToSmooth, SmoothedFlight, samples_of
from attest_mav.samples import AttitudeSample, ImuSample
from attest_mav.smoothing.noise import with_wide_priors
from attest_mav.smoothing.readings import Recorder
from attest_mav.smoothing.trajectory import Trajectory, smoothed_trajectory
from attest_mav.smoothing.white_noise import with_white_noise
from attest_mav.vehicle_reports import ParameterSample


def smooth(source: LogSource, imu: str | None = None, declination_deg: float | None = None) -> Trajectory:
    """Smooth the flight of a log source (``attest_mav.logs.formats.open_source``).

    imu: the inertial message; None to choose it as a replay does. declination_deg: east positive; None to look it up.
    UnreadableDataError where the log has no inertial message, or no attitude can be found to begin with.
    """
    summary = source.summary()
    plan = make_plan(summary, imu, None)
    vehicle = summary.vehicles[plan.vehicle]
    one = VelocityAided().with_vehicle_settings(vehicle.settings)
    field = north_of(vehicle, declination_deg).direction
    flight = FlightToSmooth(
        samples_of(source, plan), plan.imu, vehicle.opening, field, PipelineSettings(), one.parameters
    )
    trajectory = trajectory_of(flight)
    if trajectory is None:
        raise UnreadableDataError(
            f"{plan.imu} shows no attitude that a smoother could begin with; expected some seconds of it without a gap"
        )
    return trajectory


def smoothed_flight(flight: FlightToSmooth) -> SmoothedFlight | None:
    """The smoothed attitudes as a replay takes them; None where no attitude can be found to begin with."""
    trajectory = trajectory_of(flight)
    if trajectory is None:
        return None
    sigmas = (trajectory.tilt_sigma, trajectory.heading_sigma)
    rows = np.column_stack((trajectory.q_nb, trajectory.rates, *sigmas))
    columns, times = array("d"), array("q")
    columns.frombytes(rows.tobytes())
    times.frombytes(trajectory.t_ns.tobytes())
    return SmoothedFlight(times, columns, trajectory.north, trajectory.noise)


def trajectory_of(flight: FlightToSmooth) -> Trajectory | None:
    """The smoothed attitude at each inertial sample; None where no attitude can be found to begin with."""
    recorder = recorded(flight)
    readings = recorder.recording()
    if readings is None:
        return None
    return smoothed_trajectory(readings, with_white_noise(with_wide_priors(flight.parameters), readings))


def recorded(flight: FlightToSmooth) -> Recorder:
    """The recorder after the samples of a log, which pass the same lane as for a live filter."""
    vehicle = Vehicle(flight.settings.aids)
    vehicle.field = flight.field
    for sample in flight.opening:
        vehicle.take(sample)
    recorder = Recorder(flight.parameters)
    lane = Lane(flight.imu, recorder, vehicle)
    time = LogTime()
    for sample in flight.samples:
        if isinstance(sample, ImuSample):
            is_ours = sample.source == flight.imu
            if is_ours and flight.start_s <= time.advance(sample.t_ns) <= flight.end_s:
                lane.handle(sample)
        elif not isinstance(sample, AttitudeSample | ParameterSample):
            vehicle.take(sample)
    return recorder
