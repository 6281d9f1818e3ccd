"""Readings and solutions as files: CSV, npz, and parquet where pyarrow is installed; the ending of the name decides.

Columns: ``t``, ``gyro_x`` to ``gyro_z``, ``accel_x`` ..., ``mag_x`` ..., ``velocity_x`` ... (a velocity in each row,
empty or NaN without a new fix); and of a solution ``q_w`` to ``q_z``, ``tilt_sigma``, ``heading_sigma``,
``gyro_bias_x`` .... Units as in ``Readings``: seconds, rad/s, m/s^2, gauss, m/s, rad.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any, Final

import numpy as np

from attest_mav.errors import ArgumentError, UnreadableDataError
from attest_mav.library.readings import Array, Readings
from attest_mav.library.solution import Solution
from attest_mav.runtime.files import atomic_write, reason_of

AXES: Final = ("x", "y", "z")
KINDS: Final = (".csv", ".npz", ".parquet")


def read_table(path: str | Path, frames: str = "FRD/NED") -> Readings:
    """The readings in a table. UnreadableDataError names the column that is missing or wrong."""
    try:
        columns = _read(Path(path))
    except OSError as error:
        raise UnreadableDataError(f"cannot read {path}: {reason_of(error)}") from None
    except ValueError as error:
        raise UnreadableDataError(f"{path}: expected a table of numbers with a row of names ({error})") from None
    try:
        return Readings(
            _column(columns, "t"),
            _vectors(columns, "gyro"),
            _vectors(columns, "accel"),
            _vectors(columns, "mag") if "mag_x" in columns else None,
            _vectors(columns, "velocity") if "velocity_x" in columns else None,
            frames=frames,
        )
    except ArgumentError as error:
        raise UnreadableDataError(f"{path}: {error}") from None


def write_table(path: str | Path, solution: Solution) -> None:
    """Write a solution. The file appears when it is whole. UnwritableError says why it cannot be written."""
    columns: dict[str, Array] = {"t": solution.t}
    for k, name in enumerate(("q_w", "q_x", "q_y", "q_z")):
        columns[name] = solution.attitudes[:, k]
    columns |= {"tilt_sigma": solution.tilt_sigma, "heading_sigma": solution.heading_sigma}
    for k, axis in enumerate(AXES):
        columns[f"gyro_bias_{axis}"] = solution.gyro_biases[:, k]
    kind = _kind(Path(path))
    with atomic_write(path) as file:
        _write(file, kind, columns)


def _kind(path: Path) -> str:
    kind = path.suffix.lower()
    if kind not in KINDS:
        raise ArgumentError(f"{path}: expected a name that ends in {', '.join(KINDS)}")
    return kind


def _read(path: Path) -> Mapping[str, Array]:
    kind = _kind(path)
    if kind == ".npz":
        with np.load(path, allow_pickle=False) as archive:
            return {name: np.asarray(archive[name], dtype=np.float64) for name in archive.files}
    if kind == ".parquet":
        table = _parquet().read_table(path)
        return {name: np.asarray(table[name].to_numpy(), dtype=np.float64) for name in table.column_names}
    with path.open(encoding="utf-8") as file:
        names = [name.strip() for name in file.readline().split(",")]
        lines = file.readlines()
    if not lines:
        raise ValueError("no rows")
    rows = np.genfromtxt(lines, delimiter=",", dtype=np.float64, ndmin=2)
    if rows.shape[1] != len(names):
        raise ValueError(f"{rows.shape[1]} columns and {len(names)} names")
    return {name: rows[:, k] for k, name in enumerate(names)}


def _write(file: IO[bytes], kind: str, columns: Mapping[str, Array]) -> None:
    if kind == ".npz":
        np.savez(file, allow_pickle=False, **columns)
    elif kind == ".parquet":
        import pyarrow as pa  # noqa: PLC0415 - not always installed

        _parquet().write_table(pa.table(dict(columns)), file)
    else:
        file.write((",".join(columns) + "\n").encode())
        np.savetxt(file, np.column_stack(list(columns.values())), fmt="%.12g", delimiter=",")


def _parquet() -> Any:
    """pyarrow's parquet; ArgumentError says what to install."""
    try:
        import pyarrow.parquet as pq  # noqa: PLC0415 - not always installed
    except ImportError:
        raise ArgumentError("parquet needs pyarrow: pip install 'attest-mav[parquet]'") from None
    return pq


def _column(columns: Mapping[str, Array], name: str) -> Array:
    if name not in columns:
        raise ArgumentError(f"no column {name}; expected it, and it has {', '.join(columns)}")
    return columns[name]


def _vectors(columns: Mapping[str, Array], name: str) -> Array:
    return np.column_stack([_column(columns, f"{name}_{axis}") for axis in AXES])
