"""Scenarios of the papers, with their trials spread over processes.

A scenario has an id, bounds for what it measures, and a function that measures it. To add the scenarios of a paper:

1. Write a module like ``paper1``: a picklable record of one trial (seed and run number included), a module-level
   function that runs one, a ``measure`` function for each scenario that maps trials and returns named figures, and a
   tuple ``SCENARIOS``.
2. Add that tuple in ``scenarios.all_scenarios``. The command, its table and its JSON need nothing else.

A trial draws all its random numbers from ``np.random.default_rng([seed, run])``, so that it depends neither on how
many runs there are nor on the process that it lands in.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Protocol, TypeVar

Bound = tuple[float, float]
"""Lowest and highest value that passes."""

Task = TypeVar("Task")
Result = TypeVar("Result")


class TrialMap(Protocol):
    """The built-in ``map`` over one iterable, or the same over processes; results come in the order of the tasks."""

    def __call__(self, function: Callable[[Task], Result], tasks: Iterable[Task], /) -> Iterator[Result]:
        """Results of the function for each task."""


Measure = Callable[[int, int, TrialMap], dict[str, float]]
"""Measures a scenario: number of runs, seed and map in, named figures out."""


@dataclass(frozen=True)
class Outcome:
    """Figures of a scenario, with their bounds and the paper's figures (None where the paper printed none)."""

    id: str
    title: str
    measured: Mapping[str, float]
    bounds: Mapping[str, Bound]
    paper: Mapping[str, float] | None
    runs: int
    seed: int

    def within(self, name: str) -> bool:
        """Whether one figure is within its bound; a figure that is not a number never is."""
        low, high = self.bounds[name]
        return low <= self.measured[name] <= high

    @property
    def passed(self) -> bool:
        """Whether every bounded figure is within its bound."""
        return all(self.within(name) for name in self.bounds)

    def as_json(self) -> dict[str, object]:
        """The record that ``evaluate --json`` prints; figures that are not numbers become null."""
        return {
            "id": self.id,
            "measured": {name: value if isfinite(value) else None for name, value in self.measured.items()},
            "bounds": {name: list(bound) for name, bound in self.bounds.items()},
            "paper": None if self.paper is None else dict(self.paper),
            "runs": self.runs,
            "seed": self.seed,
            "pass": self.passed,
        }


@dataclass(frozen=True)
class Scenario:
    """A condition of a paper with what must hold in it.

    default_runs: Monte Carlo runs for which the bounds are meant; fewer are quicker and may miss one by chance.
    """

    id: str
    title: str
    default_runs: int
    bounds: Mapping[str, Bound]
    measure: Measure
    paper: Mapping[str, float] | None = None

    def evaluate(self, runs: int | None, seed: int, trial_map: TrialMap) -> Outcome:
        """Measure with that many runs (None: the default number)."""
        runs = self.default_runs if runs is None else runs
        measured = self.measure(runs, seed, trial_map)
        return Outcome(self.id, self.title, measured, self.bounds, self.paper, runs, seed)
