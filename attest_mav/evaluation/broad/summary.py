"""The filters' errors on each trial and in the mean, and whether ours keep their limits."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from attest_mav.evaluation.broad.candidates import Candidate, chosen
from attest_mav.evaluation.broad.metric import errors
from attest_mav.evaluation.broad.trial import Trial


@dataclass(frozen=True)
class Figures:
    """Degrees: total, heading and inclination with the magnetometer, and inclination without it (6D)."""

    total: float
    heading: float
    inclination: float
    inclination_6d: float


@dataclass(frozen=True)
class TrialResult:
    """The figures of each filter, by its name, on one trial."""

    trial: str
    disturbed: bool
    figures: dict[str, Figures]


@dataclass(frozen=True)
class Check:
    """One mean of one filter of ours beside its limit, degrees."""

    filter: str
    figure: str
    measured: float
    limit: float

    @property
    def met(self) -> bool:
        """Whether the limit is kept; a figure that is not a number never does."""
        return self.measured <= self.limit


@dataclass(frozen=True)
class Summary:
    """All trials, the means by group and filter, and the limits."""

    trials: tuple[TrialResult, ...]
    means: dict[str, dict[str, Figures]]
    checks: tuple[Check, ...]

    @property
    def met(self) -> bool:
        """Whether every limit is kept."""
        return all(check.met for check in self.checks)

    def as_json(self) -> dict[str, object]:
        """The document that ``--json`` prints; angles in degrees."""
        return {
            "trials": [asdict(result) for result in self.trials],
            "means": {
                group: {name: asdict(figures) for name, figures in filters.items()}
                for group, filters in self.means.items()
            },
            "limits": [{**asdict(check), "met": check.met} for check in self.checks],
        }


def evaluated(task: tuple[Trial, tuple[str, ...]]) -> TrialResult:
    """Run the named filters over one trial."""
    trial, names = task
    return TrialResult(trial.name, trial.disturbed, {c.name: _figures(c, trial) for c in chosen(names)})


def summarised(results: Sequence[TrialResult], candidates: Sequence[Candidate]) -> Summary:
    """Means over all, the undisturbed and the disturbed trials; a group without trials is left out."""
    groups = {
        "all": list(results),
        "undisturbed": [result for result in results if not result.disturbed],
        "disturbed": [result for result in results if result.disturbed],
    }
    means = {
        group: {c.name: _mean([result.figures[c.name] for result in members]) for c in candidates}
        for group, members in groups.items()
        if members
    }
    checks = [
        Check(c.name, figure, getattr(means["all"][c.name], figure), limit)
        for c in candidates
        for figure, limit in c.limits.items()
    ]
    return Summary(tuple(results), means, tuple(checks))


def _figures(candidate: Candidate, trial: Trial) -> Figures:
    full, level = (errors(trial, candidate.run(trial, with_mag)) for with_mag in (True, False))
    return Figures(full.total, full.heading, full.inclination, level.inclination)


def _mean(rows: Sequence[Figures]) -> Figures:
    columns = [asdict(row) for row in rows]
    return Figures(**{name: sum(row[name] for row in columns) / len(columns) for name in columns[0]})
