"""The filters that are compared, by the names users type, with the limits that ours keep."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from importlib.util import find_spec

from attest_mav.errors import UsageError
from attest_mav.evaluation.broad import ours, peers
from attest_mav.evaluation.broad.trial import Trial
from attest_mav.evaluation.motion import Array
from attest_mav.filters.base import AttitudeFilter

Run = Callable[[Trial, bool], Array]
"""Attitudes (sensor to ENU) over a trial, with the magnetometer or without it."""


@dataclass(frozen=True)
class Candidate:
    """A filter.

    library: what must be installed for it, empty for ours. limits: largest means over the trials, degrees, by the
    names of ``summary.Figures``; they are meant for the even trials.
    """

    name: str
    run: Run
    library: str = ""
    limits: Mapping[str, float] = field(default_factory=dict)

    @property
    def installed(self) -> bool:
        """Whether it can run here."""
        return not self.library or find_spec(self.library) is not None


def all_candidates() -> tuple[Candidate, ...]:
    """All, in the order in which they are shown."""
    return (
        Candidate("gradient-descent-paper", partial(_ours, ours.printed)),
        Candidate("gradient-descent", partial(_ours, ours.with_options), limits=_limits(2.2, 0.73)),
        Candidate("velocity-aided", partial(_ours, _in_place), limits=_limits(1.795, 0.495)),
        Candidate("smoothed", ours.smoothed, limits=_limits(1.35, 0.45)),
        Candidate("vqf", peers.vqf, library="vqf"),
        Candidate("imufusion", peers.imufusion, library="imufusion"),
    )


def chosen(names: Sequence[str]) -> tuple[Candidate, ...]:
    """The candidates of these names, without any all that are installed.

    UsageError for an unknown name, and for one whose library is not installed.
    """
    known = {candidate.name: candidate for candidate in all_candidates()}
    if not names:
        return tuple(candidate for candidate in known.values() if candidate.installed)
    for name in names:
        if name not in known:
            raise UsageError(f"unknown filter {name!r}; known filters: {', '.join(known)}")
        if not known[name].installed:
            raise UsageError(f"{name} is not installed: pip install {known[name].library}")
    return tuple(known[name] for name in dict.fromkeys(names))


def _ours(make: Callable[[bool], AttitudeFilter], trial: Trial, with_mag: bool) -> Array:
    return ours.attitudes(make(with_mag), trial, with_mag)


def _in_place(_with_mag: bool) -> AttitudeFilter:
    return ours.in_place()


def _limits(total: float, inclination: float) -> dict[str, float]:
    """Both inclinations, with and without the magnetometer, have the same limit."""
    return {"total": total, "inclination": inclination, "inclination_6d": inclination}
