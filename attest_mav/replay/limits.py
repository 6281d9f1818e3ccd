"""Limits on the figures of a replay: the largest value that each may have."""

from collections.abc import Sequence
from math import isfinite
from typing import Any, Final

from attest_mav.errors import UsageError
from attest_mav.record import Record

SPREADS: Final = tuple(f"{kind}.{figure}" for kind in ("tilt", "heading") for figure in ("rms", "p95", "max"))
"""Errors in degrees, of each filter; behind ``AUTOPILOT`` those of the autopilot."""
AUTOPILOT: Final = "autopilot."
VERDICT: Final = "verdict."
VERDICT_TIMES: Final = tuple(f"{VERDICT}{state}_s" for state in ("agree", "disagree", "undecided"))
"""Seconds of each verdict."""
LIMITED: Final = (*SPREADS, *(AUTOPILOT + name for name in SPREADS), *VERDICT_TIMES)
"""The names of all figures that can be limited."""


class Limit(Record):
    """The largest value of one figure, degrees or seconds."""

    def __init__(self, name: str, most: float) -> None:
        self.name: Final = name
        self.most: Final = most


class Checked(Record):
    """A limit held against one figure.

    name: that of the limit, with the filter's where there are several. value: None where nothing was compared.
    """

    def __init__(self, name: str, value: float | None, limit: float) -> None:
        self.name: Final = name
        self.value: Final = value
        self.limit: Final = limit

    @property
    def passes(self) -> bool:
        """Whether the figure exists and is within its limit."""
        return self.value is not None and self.value <= self.limit

    def as_json(self) -> dict[str, Any]:
        """The object of the contract."""
        return {"name": self.name, "value": self.value, "limit": self.limit, "pass": self.passes}

    def __str__(self) -> str:
        if self.value is None:
            return f"{self.name}: nothing was compared; at most {self.limit:g} is allowed"
        return f"{self.name} is {self.value:.3f}; at most {self.limit:g} is allowed"


class LogResult:
    """One log: the limits held against it, or the error that prevented the replay.

    error: the reason why the log could not be read, "" for one that was.
    """

    def __init__(self, log: str, checked: Sequence[Checked] = (), error: str = "") -> None:
        self.log: Final = log
        self.checked: Final = checked
        self.error: Final = error


def parse_limit(text: str, names: Sequence[str] = LIMITED) -> Limit:
    """The limit of ``NAME=VALUE``; UsageError for another form, a name of no figure or a value that is no number."""
    name, equals, number = text.partition("=")
    if name not in names or not equals:
        raise UsageError(f"--limit {text}: expected NAME=VALUE with NAME one of {', '.join(names)}")
    try:
        most = float(number)
    except ValueError:
        most = -1.0
    if not (isfinite(most) and most >= 0.0):
        raise UsageError(f"--limit {text}: expected a number of degrees or seconds, 0 or more, after the =")
    return Limit(name, most)


def check(report: dict[str, Any], limits: Sequence[Limit]) -> list[Checked]:
    """Each limit held against the report on one log."""
    return [checked for limit in limits for checked in _check(report, limit)]


def _check(report: dict[str, Any], limit: Limit) -> list[Checked]:
    name = limit.name
    if name.startswith(VERDICT):
        verdict = report["verdict"]
        value = verdict[name.removeprefix(VERDICT)] if verdict["intervals"] else None
        return [Checked(name, value, limit.most)]
    if name.startswith(AUTOPILOT):
        return [Checked(name, figure_of(report["autopilot"], name.removeprefix(AUTOPILOT)), limit.most)]
    filters = report["filters"]
    return [
        Checked(name if len(filters) == 1 else f"{one['name']}: {name}", figure_of(one, name), limit.most)
        for one in filters
    ]


def figure_of(errors: dict[str, Any] | None, name: str) -> float | None:
    """A figure such as ``tilt.rms`` of one attitude's errors; None where there is none."""
    kind, _, figure = name.partition(".")
    spread = None if errors is None else errors[f"{kind}_deg"]
    value: float | None = None if spread is None else spread[figure]
    return value
