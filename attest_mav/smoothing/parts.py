"""A flight in parts: the nodes of the smoother, and so many intervals at a time with the readings in them.

Whatever has a row for each reading or node stands in tables, and is worked on part by part, so that the memory of a
part is all that is needed for a flight of any length.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.readings import Readings, Recording
from attest_mav.smoothing.rotations import Array
from attest_mav.smoothing.steps import Steps, all_steps, steps_of

NODE_S: Final = 0.2
"""Time between two nodes, s; the next reading where they come more slowly."""
INTERVALS: Final = 2048
"""Intervals of a part, 7 minutes, where so many have no more readings than"""
READINGS: Final = 1 << 16
"""these: at 160 Hz or more a part has fewer intervals."""


@dataclass(frozen=True)
class Part:
    """Consecutive intervals. The last node of a part is the first of the next one."""

    first: int
    """Number of its first node in the flight."""
    rows: NDArray[np.int64]
    """Rows of the readings of this part at which its nodes are; one more than intervals."""
    begin: int
    """Row in the recording of its first reading."""
    is_gap: NDArray[np.bool_]
    """Nothing is known of the motion in this interval."""
    is_last: bool
    readings: Readings
    """From the first node to the last."""
    steps: Steps

    @property
    def node_s(self) -> Array:
        """Time of each node, s."""
        return self.readings.t_s[self.rows]


class Parts:
    """The parts of a flight, in order of time."""

    def __init__(self, recording: Recording, parameters: FlightParameters, intervals: int = INTERVALS) -> None:
        """intervals: the number of them in a part."""
        self.recording: Final = recording
        every = _readings_of_interval(recording)
        self.nodes: Final = _nodes(recording, every)
        """Rows of the readings at which the nodes are; 8 bytes a node."""
        self.steps: Final = all_steps(recording, parameters)
        self._begins: Final = np.array([stretch.begin for stretch in recording.stretches])
        self._firsts: Final = range(0, max(len(self.nodes) - 1, 1), min(intervals, READINGS // every))

    def __len__(self) -> int:
        return len(self._firsts)

    def first(self, number: int) -> int:
        """The first node of a part."""
        return self._firsts[number]

    def __getitem__(self, number: int) -> Part:
        first = self._firsts[number]
        nodes = self.nodes[first : first + self._firsts.step + 1]
        begin, end = int(nodes[0]), int(nodes[-1]) + 1
        return Part(
            first,
            nodes - begin,
            begin,
            np.isin(nodes[1:], self._begins),
            number == len(self) - 1,
            self.recording.rows(begin, end),
            steps_of(self.steps.rows(begin, end)),
        )


def _readings_of_interval(recording: Recording) -> int:
    """The readings from one node to the next."""
    usual_s = recording.usual_s if recording.usual_s > 0.0 else NODE_S
    return max(1, round(NODE_S / max(usual_s, 1e-4)))


def _nodes(recording: Recording, every: int) -> NDArray[np.int64]:
    """The rows of the readings that are nodes: every so many of a stretch, and its last one."""
    begins = [stretch.begin for stretch in recording.stretches]
    ends = [*begins[1:], len(recording.readings)]
    parts = [
        np.unique(np.append(np.arange(begin, end, every), end - 1)) for begin, end in zip(begins, ends, strict=True)
    ]
    return np.concatenate(parts).astype(np.int64)
