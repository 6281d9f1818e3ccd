"""The values that parameters may have: ranges and choices, and points among them in a grid or at random.

A position says where a value lies: in a range, the share of the way from the low to the high end, by logarithm where
that is asked for; among choices, the index. A point has one position a parameter.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import exp, isfinite, log
from random import Random
from typing import Final

from attest_mav.errors import UsageError

Point = tuple[float, ...]

EXPECTED: Final = "NAME=LOW:HIGH, NAME=LOW:HIGH:log or NAME=A,B,C"
MOST_POINTS: Final = 10_000
"""A grid of more points is refused."""
DIGITS: Final = 9
"""Decimals of a position, so that neighbours in a grid are found again."""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a filter: a range, or choices where there are any.

    is_log: values are spread evenly by their logarithm.
    """

    name: str
    low: float = 0.0
    high: float = 0.0
    is_log: bool = False
    choices: tuple[str, ...] = ()

    def text(self, position: float) -> str:
        """The value at a position as TOML has it, with four significant digits in a range."""
        if self.choices:
            return self.choices[round(position)]
        if self.is_log:
            return f"{exp(log(self.low) + position * (log(self.high) - log(self.low))):.4g}"
        return f"{self.low + position * (self.high - self.low):.4g}"

    def grid(self, steps: int) -> list[float]:
        """Positions over the range with its ends, or all choices."""
        if self.choices:
            return [float(index) for index in range(len(self.choices))]
        return [round(step / (steps - 1), DIGITS) for step in range(steps)]

    def drawn(self, random: Random) -> float:
        """A position by chance."""
        return float(random.randrange(len(self.choices))) if self.choices else round(random.random(), DIGITS)

    def beside(self, position: float, steps: int) -> tuple[float | None, float | None]:
        """The positions one step below and above, None beyond an end of the range."""
        last, step = (len(self.choices) - 1.0, 1.0) if self.choices else (1.0, 1.0 / (steps - 1))
        below, above = max(0.0, position - step), min(last, position + step)
        return (
            round(below, DIGITS) if below < position else None,
            round(above, DIGITS) if above > position else None,
        )


def parse_parameter(text: str, known: Sequence[str], filter_name: str) -> Parameter:
    """The parameter of ``NAME=LOW:HIGH``, ``NAME=LOW:HIGH:log`` or ``NAME=A,B,C``; UsageError names those known."""
    name, equals, values = (part.strip() for part in text.partition("="))
    if not (equals and name and values):
        raise UsageError(f"--param {text}: expected {EXPECTED}")
    if name not in known:
        raise UsageError(f"--param {text}: {filter_name} has no {name}; its parameters: {', '.join(known)}")
    if ":" not in values:
        choices = tuple(dict.fromkeys(part.strip() for part in values.split(",")))
        if "" in choices:
            raise UsageError(f"--param {text}: a value is missing between commas; expected {EXPECTED}")
        return Parameter(name, choices=choices)
    low, high, *scale = values.split(":")
    if scale not in ([], ["log"]):
        raise UsageError(f"--param {text}: expected {EXPECTED}")
    return _range(text, name, (_number(text, low), _number(text, high)), bool(scale))


def _range(text: str, name: str, ends: tuple[float, float], is_log: bool) -> Parameter:
    low, high = ends
    if not low < high:
        raise UsageError(f"--param {text}: expected a LOW below HIGH")
    if is_log and low <= 0.0:
        raise UsageError(f"--param {text}: expected a LOW above 0 for a logarithmic range")
    return Parameter(name, low, high, is_log)


def _number(text: str, number: str) -> float:
    try:
        value = float(number)
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise UsageError(f"--param {text}: {number!r} is no number; expected {EXPECTED}")
    return value


def grid_points(parameters: Sequence[Parameter], steps: int) -> list[Point]:
    """Every combination of the values of all parameters."""
    positions = [one.grid(steps) for one in parameters]
    count = 1
    for values in positions:
        count *= len(values)
    if count > MOST_POINTS:
        raise UsageError(f"the grid has {count} points, at most {MOST_POINTS} are allowed; --runs draws some at random")
    return list(product(*positions))


def random_points(parameters: Sequence[Parameter], runs: int, seed: int) -> list[Point]:
    """So many points by chance, less those that are drawn again; equal seeds give equal points."""
    random = Random(seed)  # noqa: S311 - no secret
    return list(dict.fromkeys(tuple(one.drawn(random) for one in parameters) for _ in range(runs)))
