"""The table of tools/soak and tools/soak_live: rows over a flight, their picture, and the bounds that they may miss."""

import argparse
import os
from collections.abc import Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

GROWTH = 1.10
"""Largest memory over that after the first tenth."""
LARGEST = 1e6
"""Of a flight's length and of rows."""
FORMATS = (".svg", ".png", ".pdf")


class Row(NamedTuple):
    """One sample."""

    flown: float
    """Time since the start, in the unit of the table."""
    pace: float
    """How fast the flight went on, in the unit of the table."""
    memory_mb: float
    """Resident memory."""
    descriptors: int
    """Open descriptors."""
    cost_percent: float
    """Processor time of a core."""
    latencies_ms: tuple[float, float, float]
    """Median, 99th percentile, largest."""
    recorded_mb: float
    """Bytes recorded so far."""
    lost: int
    """Frames not recorded so far."""
    verdict: str
    """The verdict at the end of the row."""
    missed: tuple[str, ...] = ()
    """Bounds that this row misses by itself, in words."""


class Titles(NamedTuple):
    """The words of one table and its picture."""

    flown: str
    pace: str
    memory: str
    cost: str
    latency: str
    axis: str


def parsed(parser: argparse.ArgumentParser, length: str) -> argparse.Namespace:
    """The command line, with the options of both tools. length: the name of the option for the flight's length."""
    parser.add_argument("--rows", type=int, default=20, help="rows of the table; default: 20")
    parser.add_argument("--plot", metavar="FILE", help="a picture of the curves (.svg, .png, .pdf)")
    arguments = parser.parse_args()
    for name, least in ((length, 0.001), ("rows", 1)):
        value = getattr(arguments, name)
        if not least <= value <= LARGEST:
            parser.error(f"--{name} {value:g}: expected a number from {least:g} to {LARGEST:g}")
    if arguments.plot:
        if find_spec("matplotlib") is None:
            parser.error("--plot needs matplotlib: pip install 'attest-mav[report]'")
        if Path(arguments.plot).suffix not in FORMATS or not Path(arguments.plot).parent.is_dir():
            parser.error(
                f"--plot {arguments.plot}: expected a file in a folder that exists, ending in {' '.join(FORMATS)}"
            )
    return arguments


def gyro_faults(hours: float) -> list[str]:
    """A fault of the first gyro each ten minutes, for ten seconds."""
    return [f"gyro1-bias-x=5@{60 + 600 * k}+10" for k in range(max(1, round(6 * hours)))]


def memory_mb(process: int) -> float:
    """Resident memory of a process."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def descriptors(process: int) -> int:
    """Open descriptors of a process."""
    return len([*Path(f"/proc/{process}/fd").iterdir()])


def distribution(latencies_ms: Iterable[float]) -> tuple[float, float, float]:
    """Median, 99th percentile and largest; zeros of none."""
    ordered = sorted(latencies_ms) or [0.0]
    return ordered[len(ordered) // 2], ordered[int(0.99 * len(ordered))], ordered[-1]


def report(rows: Iterator[Row], titles: Titles, picture: str | None) -> int:
    """Print the rows as they come, draw them, and say which bounds were missed; the exit code, 130 after Ctrl-C."""
    print(f"{titles.flown:>7} {titles.pace:>8}      MB  fds  cost %  ms: med     p99     max  rec. MB  lost  verdict")
    seen: list[Row] = []
    interrupted = True
    try:
        for row in rows:
            seen.append(row)
            print(text_of(row), flush=True)
        interrupted = False
    except KeyboardInterrupt:
        pass
    finally:
        if seen and picture:
            draw(seen, titles, Path(picture))
    failures = failures_of(seen) if seen else []
    print("MISSED: " + ", ".join(failures) if failures else "all bounds hold" if seen else "nothing was measured")
    if interrupted:
        return 130
    return 1 if failures else 0


def text_of(row: Row) -> str:
    """A line of the table."""
    times = " ".join(f"{one:>7.2f}" for one in row.latencies_ms)
    return (
        f"{row.flown:>7.2f} {row.pace:>8.1f} {row.memory_mb:>7.1f} {row.descriptors:>4} "
        f"{row.cost_percent:>7.2f}  {times} {row.recorded_mb:>8.1f} {row.lost:>5}  {row.verdict}"
    )


def early(rows: list[Row]) -> Row:
    """The row after the first tenth, which the later ones are compared with."""
    return rows[max(0, len(rows) // 10 - 1)]


def failures_of(rows: list[Row]) -> list[str]:
    """The bounds that were missed, in words."""
    failures = []
    if max(row.memory_mb for row in rows) > GROWTH * early(rows).memory_mb:
        failures.append("memory grew")
    if rows[-1].descriptors > early(rows).descriptors:
        failures.append("descriptors stayed open")
    if rows[-1].lost:
        failures.append("frames were lost")
    return failures + sorted({one for row in rows for one in row.missed})


def draw(rows: list[Row], titles: Titles, path: Path) -> None:
    """Memory, descriptors, cost and latency over time."""
    from matplotlib.figure import Figure  # noqa: PLC0415  (an extra, and slow to import)

    flown = [row.flown for row in rows]
    figure = Figure(figsize=(9.0, 9.0), layout="constrained")
    memory, opened, cost, latency = figure.subplots(4, 1, sharex=True)
    memory.plot(flown, [row.memory_mb for row in rows], marker=".")
    memory.axhline(GROWTH * early(rows).memory_mb, color="0.5", linestyle="--", label="limit")
    memory.set(title=titles.memory, ylabel="MB")
    opened.step(flown, [row.descriptors for row in rows], where="mid", marker=".")
    opened.axhline(early(rows).descriptors, color="0.5", linestyle="--", label="limit")
    opened.set(title="open descriptors", ylabel="number")
    cost.plot(flown, [row.cost_percent for row in rows], marker=".")
    cost.set(title=titles.cost, ylabel="% of a core")
    for place, name in enumerate(("median", "99th percentile", "largest")):
        latency.semilogy(flown, [row.latencies_ms[place] for row in rows], marker=".", label=name)
    latency.set(title=titles.latency, ylabel="ms", xlabel=titles.axis)
    for axes in (memory, opened, cost):
        axes.set_ylim(0.0, 1.2 * axes.get_ylim()[1])
    for axes in (memory, opened, latency):
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    for axes in (memory, opened, cost, latency):
        axes.grid(visible=True, alpha=0.3)
    figure.savefig(path, dpi=110)
