"""The smoothed attitude in a replay, on a recorded flight of 20 s: as the reference, and beside the truth."""

import csv
import tempfile
from io import BytesIO, StringIO
from pathlib import Path

import pytest

from attest_mav.cli.smoothing import smoothed
from attest_mav.config.calibration import kept_calibration
from attest_mav.errors import UnreadableDataError, UnwritableError
from attest_mav.filters.calibration import SensorCalibration, UncertainVector
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.logs.formats import open_source
from attest_mav.replay.csv_table import CsvTable
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window
from attest_mav.replay.smoothed import SmoothedAttitude
from attest_mav.replay.table_rows import TableRows
from attest_mav.runtime import scratch
from attest_mav.smoothing.log import smooth

LAPS = (Path(__file__).parents[1] / "data" / "copter_square_laps.tlog").read_bytes()
QUICK = (GradientDescent(),)
QUICK_AND_SURE = (*QUICK, VelocityAided(FlightParameters(accel_bias_sigma=0.0)))


def report(filters=QUICK, outputs=None, **options):
    request = Request(filters, window=Window(skip_s=0.0), smooth=smoothed, **options)
    return as_json("laps", replay(open_source(LAPS, "laps"), request, outputs or Outputs()))


def test_a_truth_is_preferred_and_not_smoothed():
    result = report()
    assert result["reference"]["message"] == "SIM_STATE"
    assert result["smoothed"] is None


def test_beside_a_truth_it_has_a_row_and_its_figures():
    found = report(smooths_beside_truth=True)["smoothed"]
    assert found["tilt_deg"]["rms"] < 0.1
    assert found["heading_deg"]["rms"] < 0.1
    assert found["consistency"]["tilt"]["rms"] < 1.2
    assert found["noise"] == "good"


def test_an_error_is_the_same_against_it_as_against_the_truth():
    by_truth, by_smoothed = report(QUICK_AND_SURE), report(QUICK_AND_SURE, reference="smoothed")
    true, seen = (one["filters"][0]["tilt_deg"]["rms"] for one in (by_truth, by_smoothed))
    assert true > 1.0
    assert seen == pytest.approx(true, rel=0.05)
    reference = by_smoothed["reference"]
    assert reference["message"] == "smoothed"
    assert reference["samples"] > 900
    assert 0.0 < reference["sigma"]["tilt_deg"]["rms"] < 1.0
    assert any("whose own sigma is" in note for note in by_smoothed["notes"])


def test_where_its_sigma_is_large_it_says_so_and_judges_nothing():
    result = report(reference="smoothed")  # 20 s show no bias of the accelerometer
    assert result["filters"][0]["samples"] == 0
    assert result["reference"]["sigma"]["unsure"] > 900
    assert any("sigma is above 1 deg of tilt" in note for note in result["notes"])


def kept(z_bias):
    """A calibration of the accelerometer to 4 mg, the iron as it is for any sensor."""
    sigmas = tuple(tuple(0.0016 * (row == column) for column in range(3)) for row in range(3))
    iron = UncertainVector(
        (0.0, 0.0, 0.0), tuple(tuple(1e-4 * (row == column) for column in range(3)) for row in range(3))
    )
    return {"1/RAW_IMU": kept_calibration(SensorCalibration(UncertainVector((0.0, 0.0, z_bias), sigmas), iron), None)}


def test_with_a_calibration_it_is_sure_from_the_beginning():
    result = report(reference="smoothed", calibrations=kept(0.0))
    assert result["filters"][0]["samples"] > 900
    assert not any("smoothed without" in note for note in result["notes"])


def test_a_calibration_that_the_flight_contradicts_is_not_used_and_a_note_says_so():
    result = report(reference="smoothed", calibrations=kept(1.0))
    assert result["filters"][0]["samples"] == 0
    assert "the flight contradicts the calibration: it is smoothed without" in result["notes"]


def test_its_rows_are_in_the_table_and_in_the_annotated_log():
    text, annotated = StringIO(), BytesIO()
    rows = TableRows("laps", [CsvTable(text)])
    report(outputs=Outputs(annotated=annotated, observer=rows), reference="smoothed")
    rows = [row for row in csv.DictReader(StringIO(text.getvalue())) if row["filter"] == "smoothed"]
    assert len(rows) > 900
    assert all(row[column] for row in rows for column in ("roll_deg", "pitch_deg", "yaw_deg", "tilt_sigma_deg"))
    assert len(annotated.getvalue()) > len(LAPS)


def test_a_log_too_short_for_an_attitude_is_refused_in_words():
    request = Request(QUICK, reference="smoothed", window=Window(end_s=0.1, skip_s=0.0), smooth=smoothed)
    with pytest.raises(UnreadableDataError, match="no attitude that the smoother could begin with"):
        replay(open_source(LAPS, "laps"), request, Outputs())


def test_a_flight_that_finds_no_room_on_the_disk_is_refused_in_words(monkeypatch, tmp_path):
    monkeypatch.setattr(scratch, "MEMORY_BYTES", 1000)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "none"))
    with pytest.raises(UnwritableError, match=r"cannot keep a long flight in a temporary file in .*none"):
        report(reference="smoothed")


def test_python_has_the_same_attitude():
    found = smooth(open_source(LAPS, "laps"))
    assert len(found.q_nb) == len(found.t_ns) == len(found.tilt_sigma) > 900
    assert found.noise == "good"


@pytest.mark.parametrize(("tilt", "heading", "is_sure"), [(0.01, 0.04, True), (0.02, 0.04, False), (0.01, 0.06, False)])
def test_nothing_is_compared_with_a_large_sigma(tilt, heading, is_sure):
    assert SmoothedAttitude((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), tilt, heading).is_sure is is_sure
