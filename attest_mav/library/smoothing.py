"""The smoother over arrays."""

import numpy as np

from attest_mav.errors import ArgumentError
from attest_mav.estimation.sequence_rows import Columns
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.library.readings import Array, Readings, nanoseconds
from attest_mav.library.running import sequence_of, stretches
from attest_mav.library.solution import Innovations, Solution, continuous, in_frames
from attest_mav.runtime.scratch import ScratchFile
from attest_mav.smoothing.noise import with_wide_priors
from attest_mav.smoothing.recorder import Recorder
from attest_mav.smoothing.tables import Scratch
from attest_mav.smoothing.trajectory import Trajectory, smoothed_trajectory


def smooth_readings(readings: Readings, parameters: FlightParameters | None = None) -> Solution:
    """The attitude at each reading by all readings, those after it too: docs/filters/smoother.md.

    parameters: of the sensors, as for ``VelocityAided``; None for its defaults with wide priors. Without a velocity the
    sensor is taken to stay in place in the mean.

    The first row and rows whose gyro is no reading are NaN. The smoother leaves no innovations. ArgumentError (a
    ValueError) where the readings show no attitude to begin with.
    """
    chosen = with_wide_priors(FlightParameters()) if parameters is None else parameters
    with Scratch(ScratchFile) as scratch:
        recorder = Recorder(chosen, scratch)
        for _ in stretches(sequence_of(recorder, readings), readings, Columns):
            pass
        recording = recorder.recording()
        if recording is None:
            raise ArgumentError("the readings show no attitude to begin with; expected some seconds of plausible ones")
        trajectory = smoothed_trajectory(recording, chosen)
        gyro = recording.rows(0, len(recording.readings)).gyro
    return _solution(readings, trajectory, gyro - trajectory.rates)


def _solution(readings: Readings, trajectory: Trajectory, biases: Array) -> Solution:
    """The trajectory, which has no row for a reading that could not be one, as a row for each reading."""
    frames = readings.frames
    rows = np.searchsorted(nanoseconds(readings.t), trajectory.t_ns)

    def spread(values: Array) -> Array:
        found = np.full((len(readings), *values.shape[1:]), np.nan)
        found[rows] = values
        return found

    return Solution(
        t=readings.t,
        attitudes=continuous(in_frames(spread(trajectory.q_nb), frames)),
        tilt_sigma=spread(trajectory.tilt_sigma),
        heading_sigma=spread(trajectory.heading_sigma),
        gyro_biases=spread(biases * np.array(frames.body_vector((1.0, 1.0, 1.0)))),
        aligned=np.isin(np.arange(len(readings)), rows),
        north=trajectory.north,
        frames=frames,
        find_innovations=_none,
    )


def _none() -> Innovations:
    """No innovations."""
    numbers, vectors = np.empty(0, np.int64), np.empty((0, 3))
    return Innovations(numbers, numbers, numbers, vectors, vectors)
