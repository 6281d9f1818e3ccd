"""Figures made of errors, and lines of them beside their limits."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, isfinite, nan

import numpy as np

from attest_mav.evaluation.flight_study.flying import Column, Errors
from attest_mav.evaluation.harness import Bound

Figures = dict[str, float]
"""By name; degrees, seconds, or per cent where the name says so."""


@dataclass(frozen=True)
class Line:
    """One row of a table: what was done, what came of it, and what must hold."""

    label: str
    figures: Mapping[str, float]
    limits: Mapping[str, Bound] = field(default_factory=dict)

    def within(self, name: str) -> bool:
        """Whether one figure keeps its limit; one without a limit does, one that is not a number does not."""
        low, high = self.limits.get(name, (-inf, inf))
        return name not in self.limits or low <= self.figures[name] <= high

    @property
    def passed(self) -> bool:
        """Whether all figures keep their limits."""
        return all(self.within(name) for name in self.limits)

    def as_json(self) -> dict[str, object]:
        """The line as a JSON object; what is not a number becomes null."""
        return {
            "label": self.label,
            "figures": {name: value if isfinite(value) else None for name, value in self.figures.items()},
            "limits": {
                name: [side if isfinite(side) else None for side in bound] for name, bound in self.limits.items()
            },
            "pass": self.passed,
        }


def at_most(high: float) -> Bound:
    """An upper limit."""
    return (-inf, high)


def at_least(low: float) -> Bound:
    """A lower limit."""
    return (low, inf)


def rms(errors: Column) -> float:
    """Root mean square of what is a number; NaN for nothing."""
    known = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else nan


def p95(errors: Column) -> float:
    """95th percentile of the sizes; NaN for nothing."""
    known = np.abs(errors[np.isfinite(errors)])
    return float(np.percentile(known, 95.0)) if len(known) else nan


def largest(errors: Column) -> float:
    """Largest size; NaN for nothing."""
    known = np.abs(errors[np.isfinite(errors)])
    return float(np.max(known)) if len(known) else nan


def share_within(errors: Column, sigma: Column, times: float) -> float:
    """Per cent of the errors within that many sigmas of their own; NaN where there are none with a sigma."""
    known = np.isfinite(errors) & np.isfinite(sigma)
    return float(100.0 * np.mean(np.abs(errors[known]) <= times * sigma[known])) if known.any() else nan


def accuracy(errors: Errors) -> Figures:
    """Tilt and heading."""
    return {
        "tilt rms": rms(errors.tilt),
        "tilt p95": p95(errors.tilt),
        "tilt max": largest(errors.tilt),
        "heading rms": rms(errors.heading),
    }


def honesty(errors: Errors) -> Figures:
    """How many per cent of the errors lie within three sigmas."""
    return {
        "tilt in 3s %": share_within(errors.tilt, errors.tilt_sigma, 3.0),
        "heading in 3s %": share_within(errors.heading, errors.heading_sigma, 3.0),
    }
