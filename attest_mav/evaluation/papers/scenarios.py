"""All scenarios by their ids."""

from collections.abc import Sequence

from attest_mav.errors import UsageError
from attest_mav.evaluation.harness import Scenario
from attest_mav.evaluation.papers import paper1, paper2, paper3


def all_scenarios() -> tuple[Scenario, ...]:
    """Every scenario, in the order in which they are shown."""
    return (*paper1.SCENARIOS, *paper2.SCENARIOS, *paper3.SCENARIOS)


def select(names: Sequence[str]) -> list[Scenario]:
    """The scenarios that any of the names means: an id, or the beginning of some. No names: all.

    UsageError lists the ids when a name means none.
    """
    known = all_scenarios()
    for name in names:
        if not name or not any(_means(name, scenario) for scenario in known):
            raise UsageError(f"unknown scenario {name!r}; known: {', '.join(scenario.id for scenario in known)}")
    return [scenario for scenario in known if not names or any(_means(name, scenario) for name in names)]


def _means(name: str, scenario: Scenario) -> bool:
    return scenario.id.lower().startswith(name.lower())
