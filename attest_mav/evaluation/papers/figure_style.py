"""How all figures look: plain axes, units on them, one colour a meaning."""

from typing import TYPE_CHECKING, Final, Literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE: Final = "#1f5fa8"
ORANGE: Final = "#d9731a"
GREEN: Final = "#2f8f5b"
GREY: Final = "#8a8a8a"


def sheet(width: float, height: float, title: str) -> "Figure":
    """An empty figure, in inches, with a title."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - an extra, and slow to import

    figure = Figure(figsize=(width, height), layout="constrained", dpi=120)
    figure.suptitle(title, fontsize=11)
    return figure


def dress(axes: "Axes", title: str, x_label: str, y_label: str) -> None:
    """Labels, a light grid, and no box."""
    axes.set_title(title, fontsize=9, loc="left")
    axes.set_xlabel(x_label, fontsize=8)
    axes.set_ylabel(y_label, fontsize=8)
    axes.tick_params(labelsize=8)
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.spines[["top", "right"]].set_visible(False)


def legend(axes: "Axes", place: Literal["best", "upper right", "upper center"] = "best", columns: int = 1) -> None:
    """The legend, without a frame."""
    axes.legend(loc=place, fontsize=8, frameon=False, ncols=columns)
