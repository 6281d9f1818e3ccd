"""Trials of BROAD, as read from its files.

D. Laidig, M. Caruso, A. Cereatti and T. Seel, "BROAD - A Benchmark for Robust Inertial Orientation Estimation", Data
6(7), 2021, doi 10.3390/data6070072. A trial is an HDF5 file, where the sampling rate is an attribute, or a MAT file
of version 5, where it is a variable like the others.
"""

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib.util import find_spec
from io import BytesIO
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from attest_mav.errors import UnreadableDataError, UsageError
from attest_mav.evaluation.motion import Array

FORMATS: Final = (".hdf5", ".mat")
"""Endings of the files that are trials."""

WIDTHS: Final = {"imu_gyr": 3, "imu_acc": 3, "imu_mag": 3, "opt_quat": 4}
"""Columns of each field with a row a sample; ``movement`` has one value a sample."""

IRON_DIRECTION: Final = np.array([1.0, -1.0, 1.0]) / np.sqrt(3.0)
"""In which iron is added to a trial, in the sensor's axes."""

RATE: Final = "sampling_rate"

DAMAGE: Final = (OSError, RuntimeError, ValueError, TypeError, LookupError, OverflowError, MemoryError, zlib.error)
"""Exceptions that the readers raise on damaged files, as found by damaging some."""


@dataclass(frozen=True, eq=False)
class Trial:
    """One recording of n samples, in the data set's own units and frames.

    name: the file's, without ending. rate_hz: of the samples. gyr: rad/s, shape (n, 3). acc: specific force, m/s^2,
    +g up at rest, shape (n, 3). mag: microtesla, shape (n, 3). opt: true attitude, sensor to ENU with magnetic north,
    (w, x, y, z), shape (n, 4), NaN where the cameras saw too little. counted: samples in motion with a true attitude,
    shape (n,).
    """

    name: str
    rate_hz: float
    gyr: Array
    acc: Array
    mag: Array
    opt: Array
    counted: npt.NDArray[np.bool_]

    @property
    def disturbed(self) -> bool:
        """Whether the trial is one of those with tapping, vibration or magnets; the authors say it in the name."""
        return "_disturbed_" in self.name

    def with_iron(self, share: float) -> "Trial":
        """The trial with hard iron of this share of the field's usual strength, alike on all axes of the sensor."""
        size = share * float(np.median(np.linalg.norm(self.mag, axis=1)))
        return replace(self, mag=self.mag + size * IRON_DIRECTION)


def read_trial(file_name: str, data: bytes) -> Trial:
    """The trial in a file with this content.

    UnreadableDataError names the file and the field; UsageError where the reader of the format is not installed.
    """
    stem, _, ending = file_name.rpartition(".")
    fields = _hdf5(file_name, data) if ending == "hdf5" else _mat(file_name, data)
    columns = {name: _numbers(file_name, name, fields) for name in (*WIDTHS, "movement", RATE)}
    rate_hz = columns[RATE].ravel()
    if rate_hz.shape != (1,) or not 0.0 < rate_hz[0] < np.inf:
        raise UnreadableDataError(f"{file_name}: {RATE}: expected one number above 0, in Hz")
    count = len(columns["imu_gyr"]) if columns["imu_gyr"].ndim else 0
    for name, width in WIDTHS.items():
        if columns[name].shape != (count, width) or count == 0:
            raise UnreadableDataError(
                f"{file_name}: {name}: expected {count or 'some'} rows of {width} numbers, got {columns[name].shape}"
            )
    if columns["movement"].size != count:
        raise UnreadableDataError(f"{file_name}: movement: expected {count} values, got {columns['movement'].size}")
    gyr, acc, mag, opt = (columns[name] for name in WIDTHS)
    counted = (columns["movement"].ravel() == 1.0) & np.isfinite(opt).all(axis=1)
    if not counted.any():
        raise UnreadableDataError(f"{file_name}: movement: no sample has movement = 1 and a finite opt_quat")
    return Trial(stem, float(rate_hz[0]), gyr, acc, mag, opt, counted)


def _hdf5(file_name: str, data: bytes) -> Mapping[str, Any]:
    """Data sets and attributes of an HDF5 file, as arrays."""
    _require("h5py", file_name)
    import h5py  # noqa: PLC0415 - an extra

    try:
        with h5py.File(BytesIO(data), "r") as file:
            found = {name: item[()] for name, item in file.items() if isinstance(item, h5py.Dataset)}
            return found | dict(file.attrs)
    except DAMAGE as error:
        raise UnreadableDataError(f"{file_name}: not a readable HDF5 file: {_line(error)}") from error


def _mat(file_name: str, data: bytes) -> Mapping[str, Any]:
    """Variables of a MAT file of version 5."""
    _require("scipy", file_name)
    from scipy.io import loadmat  # noqa: PLC0415 - an extra
    from scipy.io.matlab import MatReadError  # noqa: PLC0415 - an extra

    try:
        found: dict[str, Any] = loadmat(BytesIO(data))
    except (MatReadError, *DAMAGE) as error:
        raise UnreadableDataError(f"{file_name}: not a readable MAT file of version 5: {_line(error)}") from error
    return found


def _require(module: str, file_name: str) -> None:
    """UsageError where the reader of a format is not installed."""
    if find_spec(module) is None:
        raise UsageError(f"reading {file_name} needs {module}: pip install 'attest-mav[broad]'")


def _numbers(file_name: str, name: str, fields: Mapping[str, Any]) -> Array:
    """One field as floats."""
    if name not in fields:
        raise UnreadableDataError(f"{file_name}: {name}: the field is missing")
    try:
        return np.ascontiguousarray(fields[name], dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise UnreadableDataError(f"{file_name}: {name}: expected numbers: {_line(error)}") from error


def _line(error: BaseException) -> str:
    """An error's text in one line."""
    return " ".join(str(error).split())
