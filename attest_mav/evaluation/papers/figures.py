"""The papers' figures with ours, for ``evaluate --plot``. Needs matplotlib (the extra ``report``).

A figure is a name, the paper it belongs to, and a function that draws it from a seed and a map over processes; whoever
calls writes it. Nothing here touches matplotlib's global state.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Final

from attest_mav.errors import UsageError
from attest_mav.evaluation.harness import TrialMap
from attest_mav.evaluation.papers import figures_paper1, figures_paper2, figures_paper3

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Draw = Callable[[int, TrialMap], "Figure"]


@dataclass(frozen=True)
class PaperFigure:
    """name: of the file, without ending. scenarios: beginning of the ids it goes with. draw: seed and map in."""

    name: str
    scenarios: str
    draw: Draw


ALL: Final = (
    PaperFigure("paper1-fig3-euler-angles", "P1", figures_paper1.euler_angles),
    PaperFigure("paper2-fig2-plain-filter", "P2", figures_paper2.plain_filter),
    PaperFigure("paper2-fig3-robust-adaptive", "P2", figures_paper2.robust_adaptive),
    PaperFigure("paper3-fig3-fig4-covariance", "P3", figures_paper3.covariances),
    PaperFigure("paper3-fig6-fig7-moving", "P3", figures_paper3.moving),
    PaperFigure("paper3-fig8-fig9-standing", "P3", figures_paper3.standing),
)


def figures_for(scenario_ids: Sequence[str]) -> list[PaperFigure]:
    """The figures of the papers that the scenarios belong to; UsageError without matplotlib."""
    if find_spec("matplotlib") is None:
        raise UsageError("figures need matplotlib: pip install 'attest-mav[report]'")
    return [figure for figure in ALL if any(name.startswith(figure.scenarios) for name in scenario_ids)]
