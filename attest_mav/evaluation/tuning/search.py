"""The search: the cost of each point on the logs that tune, the best of them on those that check, and its surroundings.

The cost is one figure of the filter against the reference of each log (``attest_mav.replay.limits``), the mean over
the logs. A point that gives no figure on a log costs infinity.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Final

from attest_mav.errors import UnreadableDataError
from attest_mav.evaluation.harness import TrialMap
from attest_mav.evaluation.tuning.space import Parameter, Point
from attest_mav.replay.batch import OpenLog, replay_file, replay_files
from attest_mav.replay.limits import figure_of
from attest_mav.replay.request import Request, Window

SHORTLIST: Final = 5
"""So many of the best points are flown over the logs that check."""
CONFIGURED: Final[Point] = ()
"""Stands for the parameters as they are without the search."""


@dataclass(frozen=True)
class Trial:
    """One replay: a log, or a part of it, by one filter."""

    path: str
    request: Request


@dataclass(frozen=True)
class Measured:
    """The cost of one replay, None where nothing was compared. error: the reason why there was none, or ""."""

    cost: float | None
    reference: str = ""
    duration_s: float = 0.0
    error: str = ""


def measure(trial: Trial, figure: str, open_log: OpenLog) -> Measured:
    """Replay one log; a log that cannot be replayed is a result too."""

    def replay_one(path: str) -> dict[str, object]:
        return replay_file(path, trial.request, open_log)

    (outcome,) = replay_files([trial.path], replay_one)
    report = outcome.report
    if report is None:
        return Measured(None, error=str(outcome.error))
    reference = report["reference"]
    if reference is None:
        return Measured(None, error=f"{trial.path}: it has no reference to compare with")
    cost = figure_of(report["filters"][0], figure)
    error = f"{trial.path}: nothing was compared after {report['window']['skip_s']:g} s; is --skip too long?"
    return Measured(cost, reference["message"], report["duration_s"], error if cost is None else "")


@dataclass(frozen=True)
class LogPart:
    """A log, or the part of one in a window, that tunes or checks."""

    path: str
    checks: bool
    window: Window


def split(usable: Sequence[tuple[str, Measured]], every: int, window: Window) -> list[LogPart]:
    """Every so-many-th log checks, the last one if that is none. The halves of a single log: the first one tunes."""
    if len(usable) == 1:
        ((path, one),) = usable
        middle_s = round(0.5 * one.duration_s, 3)
        return [
            LogPart(path, checks=False, window=replace(window, end_s=middle_s)),
            LogPart(path, checks=True, window=replace(window, start_s=middle_s)),
        ]
    checking = set(range(every - 1, len(usable), every)) or {len(usable) - 1}
    return [LogPart(path, index in checking, window) for index, (path, _) in enumerate(usable)]


class Costs:
    """The costs that are known so far, by point and log. request_of: the replay by the filter at a point."""

    def __init__(
        self,
        request_of: Callable[[Point], Request],
        measure_one: Callable[[Trial], Measured],
        trial_map: TrialMap,
        done: Callable[[int], None],
    ) -> None:
        self._request_of: Final = request_of
        self._measure: Final = measure_one
        self._map: Final = trial_map
        self._done: Final = done
        self._count = 0
        self._known: Final[dict[tuple[Point, str, Window], Measured]] = {}

    def learn(self, points: Sequence[Point], parts: Sequence[LogPart]) -> None:
        """Measure what is not known yet."""
        keys = [(point, part.path, part.window) for point in points for part in parts]
        missing = [key for key in dict.fromkeys(keys) if key not in self._known]
        for key, measured in zip(missing, self._map(self._measure, self._trials(missing)), strict=True):
            self._known[key] = measured
            self._count += 1
            self._done(self._count)

    def at(self, point: Point, part: LogPart) -> Measured:
        """What was measured."""
        return self._known[point, part.path, part.window]

    def mean(self, point: Point, parts: Sequence[LogPart]) -> float:
        """Mean cost over the logs; infinity where one has none."""
        costs = [self.at(point, part).cost for part in parts]
        known = [cost for cost in costs if cost is not None]
        return sum(known) / len(known) if known and len(known) == len(costs) else inf

    def _trials(self, keys: Sequence[tuple[Point, str, Window]]) -> Iterator[Trial]:
        for point, path, window in keys:
            yield Trial(path, replace(self._request_of(point), window=window))


@dataclass(frozen=True)
class Neighbour:
    """One step of one parameter away from the best point. cost: on the logs that tune."""

    text: str
    cost: float


@dataclass(frozen=True)
class Flatness:
    """The surroundings of the best point along one parameter; None at an end of its values.

    at_end: the best point lies at an end of a range.
    """

    name: str
    best: str
    at_end: bool
    below: Neighbour | None
    above: Neighbour | None


@dataclass(frozen=True)
class Found:
    """The result of a search. ranked: all points with their costs, the best first; checked: costs of the shortlist."""

    parts: Sequence[LogPart]
    ranked: Sequence[tuple[Point, float]]
    checked: Mapping[Point, float]
    flatness: Sequence[Flatness]
    configured: float
    """The cost of the parameters as they are without the search, on the logs that tune."""
    configured_check: float
    """The same on the logs that check."""
    of_log: Callable[[LogPart], tuple[Measured, Measured]]
    """What a log gave, with the parameters as configured and with the best ones."""

    @property
    def best(self) -> Point:
        """The point of the lowest cost on the logs that tune."""
        return self.ranked[0][0]


def search(
    costs: Costs, parts: Sequence[LogPart], parameters: Sequence[Parameter], points: Sequence[Point], steps: int
) -> Found:
    """Measure all points, the surroundings of the best, and the shortlist on the logs that check."""
    tuning = [part for part in parts if not part.checks]
    checking = [part for part in parts if part.checks]
    costs.learn([CONFIGURED, *points], tuning)
    ranked = sorted([(point, costs.mean(point, tuning)) for point in points], key=lambda one: one[1])
    best, cost = ranked[0]
    if cost == inf:
        raise UnreadableDataError(f"nothing was compared: {costs.at(best, tuning[0]).error or 'on one of the logs'}")
    shortlist = [point for point, _ in ranked[:SHORTLIST]]
    costs.learn([CONFIGURED, *shortlist], checking)
    return Found(
        parts,
        ranked,
        {point: costs.mean(point, checking) for point in shortlist},
        surroundings(costs, tuning, parameters, best, steps),
        costs.mean(CONFIGURED, tuning),
        costs.mean(CONFIGURED, checking),
        lambda part: (costs.at(CONFIGURED, part), costs.at(best, part)),
    )


def surroundings(
    costs: Costs, tuning: Sequence[LogPart], parameters: Sequence[Parameter], best: Point, steps: int
) -> list[Flatness]:
    """The cost one step below and above the best point, parameter by parameter."""
    beside = [one.beside(best[index], steps) for index, one in enumerate(parameters)]
    near = [_moved(best, index, to) for index, both in enumerate(beside) for to in both if to is not None]
    costs.learn(near, tuning)

    def neighbour(index: int, position: float | None) -> Neighbour | None:
        if position is None:
            return None
        return Neighbour(parameters[index].text(position), costs.mean(_moved(best, index, position), tuning))

    return [
        Flatness(
            one.name,
            one.text(best[index]),
            not one.choices and None in (below, above),
            neighbour(index, below),
            neighbour(index, above),
        )
        for index, (one, (below, above)) in enumerate(zip(parameters, beside, strict=True))
    ]


def _moved(point: Point, index: int, position: float) -> Point:
    """The point with another position of one parameter."""
    return (*point[:index], position, *point[index + 1 :])
