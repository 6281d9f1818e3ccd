"""``attest-mav evaluate``: the papers' scenarios, measured and held against their bounds."""

import json
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import click

from attest_mav.errors import UsageError
from attest_mav.runtime.files import atomic_write, check_writable

if TYPE_CHECKING:
    from attest_mav.evaluation.harness import Outcome, Scenario
    from attest_mav.evaluation.papers.figures import PaperFigure

DEFAULT_SEED = 1
MISSED = 1
"""Exit code when a bound is missed."""


@click.command()
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option("--runs", type=click.IntRange(min=1, max=100_000), help="Monte Carlo runs instead of each one's default.")
@click.option("--seed", type=click.IntRange(min=0, max=2**63 - 1), default=DEFAULT_SEED, show_default=True)
@click.option("--workers", type=click.IntRange(min=1, max=1024), help="Processes to spread the runs over; one a core.")
@click.option("--json", "as_json", is_flag=True, help="Print a list of records instead of a table.")
@click.option("--plot", "folder", metavar="DIR", help="Draw the papers' figures into DIR (needs the extra report).")
@click.pass_context
def command(
    ctx: click.Context,
    names: tuple[str, ...],
    runs: int | None,
    seed: int,
    workers: int | None,
    as_json: bool,
    folder: str | None,
) -> None:
    """Reproduce the papers' scenarios and check them against their bounds.

    A NAME is an id such as P1-a, or the beginning of several such as P1; without one, all run. The bounds are meant
    for the default number of runs: with fewer, one may be missed by chance. Exit code 1 when one is missed.
    """
    if find_spec("numpy") is None:
        raise UsageError("evaluate needs numpy, which is not installed: pip install numpy")
    from attest_mav.evaluation.papers.scenarios import select  # noqa: PLC0415 - numpy is slow to import

    chosen = select(names)
    drawings = [] if folder is None else prepare_figures(folder, chosen)
    outcomes = measure(chosen, runs, seed, workers)
    if as_json:
        click.echo(json.dumps([outcome.as_json() for outcome in outcomes], indent=2))
    else:
        show(outcomes)
    if folder is not None:
        draw(drawings, Path(folder), seed, workers)
    if not all(outcome.passed for outcome in outcomes):
        ctx.exit(MISSED)


def prepare_figures(folder: str, chosen: "list[Scenario]") -> "list[PaperFigure]":
    """The figures of the chosen scenarios' papers, once it is clear that they can be drawn and kept."""
    from attest_mav.evaluation.papers.figures import figures_for  # noqa: PLC0415 - numpy is slow to import

    found = figures_for([scenario.id for scenario in chosen])
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"cannot make the folder {folder}: {error.strerror}") from error
    for figure in found:
        check_writable(Path(folder) / f"{figure.name}.png")
    return found


def draw(drawings: "list[PaperFigure]", folder: Path, seed: int, workers: int | None) -> None:
    """Draw each figure into a PNG file of its name."""
    from attest_mav.runtime.processes import processes  # noqa: PLC0415 - with it comes multiprocessing

    with processes(workers) as trial_map:
        for figure in drawings:
            path = folder / f"{figure.name}.png"
            with atomic_write(path) as file:
                figure.draw(seed, trial_map).savefig(file, format="png")
            click.echo(f"drew {path}", err=True)


def measure(chosen: "list[Scenario]", runs: int | None, seed: int, workers: int | None) -> "list[Outcome]":
    """Evaluate one after another; on a terminal, say which one is running."""
    from rich.console import Console  # noqa: PLC0415 - only when shown

    from attest_mav.runtime.processes import processes  # noqa: PLC0415 - with it comes multiprocessing

    outcomes = []
    with processes(workers) as trial_map, Console(stderr=True).status("") as status:
        for scenario in chosen:
            status.update(f"{scenario.id}: {scenario.title}")
            outcomes.append(scenario.evaluate(runs, seed, trial_map))
    return outcomes


def show(outcomes: "list[Outcome]") -> None:
    """Print the table: a row for each measured figure."""
    from rich.console import Console  # noqa: PLC0415 - only when shown
    from rich.table import Table  # noqa: PLC0415 - only when shown

    table = Table(box=None, pad_edge=False, header_style="bold", padding=(0, 2, 0, 0))
    table.add_column("id", no_wrap=True)
    table.add_column("figure", max_width=34)
    for title in ("measured", "lowest", "highest", "paper"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    for outcome in outcomes:
        table.add_row(outcome.id, f"[bold]{outcome.title}[/], {outcome.runs} runs")
        for name in outcome.measured:
            table.add_row("", f"  {name}", *figures(outcome, name))
    console = Console()
    passed = sum(outcome.passed for outcome in outcomes)
    with console.capture() as capture:  # rich would end the process itself where nobody reads
        console.print(table)
        console.print(f"{passed} of {len(outcomes)} within their bounds, seed {outcomes[0].seed}", highlight=False)
    click.echo(capture.get(), nl=False)


def figures(outcome: "Outcome", name: str) -> list[str]:
    """Measured, lowest, highest, the paper's figure and the verdict, as text."""
    measured = f"{outcome.measured[name]:.4g}"
    paper = "-" if outcome.paper is None or name not in outcome.paper else f"{outcome.paper[name]:.4g}"
    if name not in outcome.bounds:
        return [measured, "-", "-", paper, ""]
    low, high = outcome.bounds[name]
    verdict = "[green]within[/]" if outcome.within(name) else "[bold red]MISSED[/]"
    return [measured, f"{low:.4g}", f"{high:.4g}", paper, verdict]
