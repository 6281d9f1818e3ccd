"""Readings and solutions as files."""

import numpy as np
import pytest

from attest_mav import ArgumentError, GradientDescent, Readings, read_table, run_readings, write_table
from attest_mav.errors import UnreadableDataError

HEADER = "t,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z,mag_x,mag_y,mag_z"
ROWS = ["0,0,0,0.1,0,0,-9.8,0.2,0,0.4", "0.02,0,0,0.1,0,0,-9.8,,,", "0.04,0,0,0.1,0,0,-9.8,0.2,0,0.4"]


def table(tmp_path, *lines, name="readings.csv"):
    path = tmp_path / name
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_a_csv_is_read_with_its_empty_fields(tmp_path):
    readings = read_table(table(tmp_path, HEADER, *ROWS))
    assert np.array_equal(readings.t, [0.0, 0.02, 0.04])
    assert np.array_equal(readings.gyro[1], [0.0, 0.0, 0.1])
    assert np.isnan(readings.mag[1]).all()
    assert readings.velocity is None


@pytest.mark.parametrize("kind", ["csv", "npz", "parquet"])
def test_a_solution_is_written_and_read_back(tmp_path, kind):
    if kind == "parquet":
        pytest.importorskip("pyarrow")
    solution = run_readings(GradientDescent(), read_table(table(tmp_path, HEADER, *ROWS)))
    path = tmp_path / f"solution.{kind}"
    write_table(path, solution)
    if kind == "npz":
        columns = dict(np.load(path))
    elif kind == "csv":
        columns = np.genfromtxt(path, delimiter=",", names=True)
    else:
        import pyarrow.parquet as pq  # noqa: PLC0415 - not always installed

        columns = pq.read_table(path).to_pydict()
    assert np.allclose(columns["q_w"], solution.attitudes[:, 0])
    assert np.allclose(columns["gyro_bias_z"], solution.gyro_biases[:, 2])
    assert list(tmp_path.glob(".*")) == []


def test_readings_come_back_from_npz(tmp_path):
    t = np.arange(5) / 10.0
    zeros = np.zeros(5)
    columns = {f"{name}_{axis}": zeros + 1.0 for name in ("gyro", "accel", "velocity") for axis in "xyz"}
    np.savez(tmp_path / "a.npz", t=t, **columns)
    readings = read_table(tmp_path / "a.npz", frames="FLU/ENU")
    assert np.array_equal(readings.velocity[0], [1.0, 1.0, -1.0])
    assert isinstance(readings, Readings)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["t,gyro_x", "0,1"], "no column gyro_y; expected it, and it has t, gyro_x"),
        ([HEADER, "0,1,2"], "3 columns and 10 names"),
        ([HEADER, ROWS[0], ROWS[0]], r"t\[1\] = 0 does not follow 0"),
        ([HEADER], "no rows"),
    ],
)
def test_a_table_that_does_not_fit_says_why(tmp_path, lines, words):
    with pytest.raises(UnreadableDataError, match=words):
        read_table(table(tmp_path, *lines))


def test_a_file_that_is_no_table_says_why(tmp_path):
    with pytest.raises(UnreadableDataError, match="no such file"):
        read_table(tmp_path / "none.csv")
    with pytest.raises(UnreadableDataError, match="expected a table"):
        read_table(table(tmp_path, "no archive", name="a.npz"))
    with pytest.raises(UnreadableDataError, match="expected a name that ends in"):
        read_table(table(tmp_path, HEADER, name="a.xls"))
    with pytest.raises(ArgumentError, match="expected a name that ends in"):
        write_table(tmp_path / "a.xls", run_readings(GradientDescent(), read_table(table(tmp_path, HEADER, *ROWS))))
