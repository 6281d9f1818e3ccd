"""The tables of ``attest-mav replay``: the columns of CSV and Parquet, and one result however they are written."""

import csv
import io
import shutil
from math import degrees
from pathlib import Path

import pytest
from click.testing import CliRunner
from pyarrow import parquet
from pymavlink import mavutil

from attest_mav.algebra import tilt_between
from attest_mav.cli.replay import command
from attest_mav.errors import UsageError
from attest_mav.replay.columns import COLUMNS, Kind
from attest_mav.runtime import parquet_table
from attest_mav.runtime.parquet_table import ParquetTable

CUTS = Path(__file__).parent.parent / "data"
OLD_END = "unit_length_nis"
"""The last of the columns that programs knew before reference, rates, residuals and verdict were added."""


def replay(*arguments):
    return CliRunner().invoke(command, [*map(str, arguments), "--skip", "2"])


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """The rows of one flight with a wrong autopilot, as CSV and as Parquet."""
    folder = tmp_path_factory.mktemp("tables")
    log = CUTS / "copter_gyro_step.tlog"
    assert replay(log, "--csv", folder / "t.csv", "--parquet", folder / "t.parquet").exit_code == 0
    with (folder / "t.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    return rows, parquet.read_table(folder / "t.parquet"), log


def ours(rows):
    return [row for row in rows if row["filter"] == "velocity-aided"]


def quaternion(row, prefix=""):
    return tuple(float(row[f"{prefix}q_{part}"]) for part in "wxyz")


def test_new_columns_stand_behind_those_that_programs_know(flown):
    names = list(flown[0][0])
    assert names.index(OLD_END) == 38
    assert names.index("reference_roll_deg") == 39
    assert names[-5:] == ["verdict", "verdict_reason", "verdict_tilt_deg", "verdict_heading_deg", "utc_s"]


def test_each_row_has_its_time_of_day_once_the_log_tells_the_date(tmp_path):
    log = CUTS / "copter_standing_trim.tlog"
    assert replay(log, "--csv", tmp_path / "t.csv").exit_code == 0
    with (tmp_path / "t.csv").open(newline="") as file:
        dated = [row for row in csv.DictReader(file) if row["utc_s"]]
    source = mavutil.mavlink_connection(str(log), dialect="ardupilotmega")
    told = source.recv_match(type="SYSTEM_TIME")
    source.close()
    assert len(dated) > 100
    for row in dated[::50]:
        since_s = float(row["time_boot_s"]) - 1e-3 * told.time_boot_ms
        assert float(row["utc_s"]) == pytest.approx(1e-6 * told.time_unix_usec + since_s, abs=2e-3)


def test_the_error_is_that_between_attitude_and_reference_of_the_row(flown):
    compared = [row for row in flown[0] if row["tilt_error_deg"]]
    assert {row["filter"] for row in compared} == {"velocity-aided", "autopilot"}
    for row in compared[::50]:
        tilt = degrees(tilt_between(quaternion(row), quaternion(row, "reference_")))
        assert tilt == pytest.approx(float(row["tilt_error_deg"]), abs=1e-4)


def test_readings_and_fixes_are_those_of_the_log(flown):
    rows, _, log = flown
    source = mavutil.mavlink_connection(str(log), dialect="ardupilotmega")
    accel, fixes = {}, 0
    while (message := source.recv_match(type=["RAW_IMU", "GPS_RAW_INT"])) is not None:
        if message.get_type() == "GPS_RAW_INT":
            fixes += message.fix_type >= 3
        else:
            accel[message.time_usec] = message.zacc
    source.close()
    mine = ours(rows)
    assert fixes - 20 < sum(bool(row["gnss_velocity_north_m_s"]) for row in mine) <= fixes
    on_first = [row for row in mine if row["lane"] == "RAW_IMU"]
    assert len(on_first) > 100
    for row in on_first[::50]:
        raw = accel[round(float(row["time_boot_s"]) * 1e6)]
        assert float(row["accel_z_m_s2"]) == pytest.approx(raw * 9.80665e-3, abs=0.011)


def test_residuals_stand_beside_their_nis_and_verdicts_change(flown):
    fused = [row for row in ours(flown[0]) if row["velocity_fusion"] == "used"]
    assert fused
    assert all(row["velocity_residual_1"] and row["velocity_residual_2"] for row in fused)
    assert all(row["heading_residual"] == "" for row in fused)
    assert {row["verdict"] for row in ours(flown[0])} >= {"agree", "disagree"}
    assert all(row["verdict"] == row["lane"] == "" for row in flown[0] if row["filter"] == "autopilot")


def test_parquet_has_the_values_of_the_csv_with_types_and_units(flown):
    rows, table, _ = flown
    assert table.num_rows == len(rows)
    assert table.schema.field("rate_x_deg_s").metadata == {b"unit": b"deg/s"}
    assert str(table.schema.field("counted").type) == "bool"
    for column in COLUMNS:
        values = table.column(column.name).to_pylist()
        texts = [row[column.name] for row in rows]
        if column.kind == Kind.REAL:
            assert [None if text == "" else float(text) for text in texts] == [
                None if value is None else pytest.approx(value, abs=1e-6) for value in values
            ]
        else:
            assert texts == [
                "" if value is None else str(int(value) if value in {True, False} else value) for value in values
            ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("flights")
    for name in ("a", "b"):
        shutil.copy(CUTS / "copter_square_start.tlog", path / f"{name}.tlog")
    (path / "bad.bin").write_bytes(b"not a log at all\n" * 50)
    return path


def test_tables_are_the_same_at_every_number_of_processes_and_size_of_groups(folder, tmp_path, monkeypatch):
    written = []
    for workers, group_rows in ((1, 4096), (1, 100), (2, 4096)):
        monkeypatch.setattr(parquet_table, "GROUP_ROWS", group_rows)
        target = tmp_path / f"{workers}-{group_rows}"
        target.mkdir()
        options = ("--filter", "leveling", "--workers", workers)
        done = replay(folder, *options, "--csv", target / "t.csv", "--parquet", target / "t.parquet")
        assert done.exit_code == 65
        assert sorted(path.name for path in target.iterdir()) == ["t.csv", "t.parquet"], "no part is left"
        written.append(((target / "t.csv").read_bytes(), parquet.read_table(target / "t.parquet")))
    first = written[0]
    assert first[0].count(b"log,filter") == 1
    assert 0 < first[0].index(b"a.tlog") < first[0].index(b"b.tlog")
    assert all(text == first[0] and table == first[1] for text, table in written[1:])


def test_groups_are_written_while_rows_come():
    file = io.BytesIO()
    table = ParquetTable(file, group_rows=10)
    row = ["log", *["x" if one.kind == Kind.TEXT else 1 for one in COLUMNS[1:]]]
    sizes = []
    for _ in range(35):
        table.write(row)
        sizes.append(file.tell())
    assert len(set(sizes)) == 4, "a size before each of the three groups, and after"
    table.close()
    file.seek(0)
    assert parquet.ParquetFile(file).metadata.num_row_groups == 4


def test_without_the_extra_the_command_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setattr(parquet_table, "find_spec", lambda _: None)
    error = replay(CUTS / "copter_square_start.tlog", "--parquet", tmp_path / "t.parquet").exception
    assert isinstance(error, UsageError)
    assert "attest-mav[parquet]" in str(error)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", ["--csv", "--parquet", "--tlog"])
def test_kept_results_have_no_attitudes(option, tmp_path):
    log = CUTS / "copter_square_start.tlog"
    error = replay(log, option, tmp_path / "a", "--results", tmp_path / "b").exception
    assert isinstance(error, UsageError)
    assert str(error).startswith(f"{option} and --results")
