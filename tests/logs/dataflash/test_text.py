"""DataFlash logs in text, and the times of firmware that writes them with the receiver's record alone."""

from itertools import pairwise

import pytest

from attest_mav.logs.dataflash.source import DataflashSource, TextSource
from attest_mav.logs.detect import HEAD_BYTES, detect_format
from attest_mav.logs.formats import open_source
from attest_mav.logs.source import Plan
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window
from attest_mav.samples import AttitudeSample, ImuSample, VelocitySample
from attest_mav.vehicle_reports import EstimatorNewsSample, ParameterSample

PLAN = Plan((1, 1), "IMU", "ATT", None, None)
HEAD = """FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns
FMT, 131, 31, IMU, Iffffff, TimeMS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ
FMT, 1, 19, ATT, IccccCC, TimeMS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw
FMT, 132, 67, MSG, Z, Message
FMT, 129, 23, PARM, Nf, Name,Value
"""
BANNER = "58\n\nArduCopter V3.1\nFree RAM: 1273\nAPM 2\n"


def flight(seconds=4.0):
    """Level at rest; the autopilot says that it rolls by 2 degrees."""
    lines = HEAD + "MSG, ArduCopter V3.1.3 (92cdd2a3)\nPARM, AHRS_TRIM_X, 0.000000\nPARM, AHRS_TRIM_Y, 0.000000\n"
    for k in range(int(50 * seconds)):
        t_ms = 95_000 + 20 * k
        lines += f"IMU, {t_ms}, 0.001, -0.002, 0.0005, 0.0, 0.0, -9.80665\n"
        lines += f"ATT, {t_ms}, 0.00, 2.00, 0.00, 0.00, 180.00, 0.00\n"
    return lines


def samples_of(data, kind, plan=PLAN, source=TextSource):
    opened = source(data)
    opened.summary()
    return [sample for batch in opened.samples(plan) for sample in batch.samples if isinstance(sample, kind)]


VARIANTS = {
    "plain": lambda text: text.encode(),
    "banner": lambda text: (BANNER + text).encode(),
    "windows": lambda text: (BANNER + text).replace("\n", "\r\n").encode(),
    "utf-8 mark": lambda text: b"\xef\xbb\xbf" + text.encode(),
    "utf-16": lambda text: b"\xff\xfe" + text.encode("utf-16-le"),
    "tight": lambda text: text.replace(", ", ",").encode(),
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_log_in_text_is_read_however_it_was_saved(variant):
    data = VARIANTS[variant](flight())
    assert detect_format(data[:HEAD_BYTES]) == "dataflash-text"
    whole = Request(window=Window(skip_s=0.0))
    result = as_json("flight", replay(open_source(data, "flight.log"), whole, Outputs()))
    assert (result["format"], result["bad_bytes"], result["duration_s"]) == ("dataflash-text", 0, 3.98)
    assert result["frames"] == 5 + 3 + 400
    assert result["imu"]["samples"] == result["reference"]["samples"] == 200
    assert result["filters"][0]["tilt_deg"]["max"] == pytest.approx(2.0, abs=0.3)


def test_values_are_scaled_already():
    (attitude, *_) = samples_of(
        (HEAD + "ATT, 95000, 0.00, 57.29578, 0.00, 0.00, 180.00, 90.00\n").encode(), AttitudeSample
    )
    assert attitude.t_ns == 95_000_000_000
    assert attitude.euler == pytest.approx((1.0, 0.0, 1.5707963))


def test_a_text_may_hold_commas():
    (news,) = samples_of((HEAD + "MSG, EKF variance, again\n").encode(), EstimatorNewsSample)
    assert news.text == "EKF variance, again"


def test_parameters_in_text():
    (told,) = samples_of((HEAD + "PARM, INS_GYRO_FILTER, 42.000000\n").encode(), ParameterSample)
    assert (told.name, told.value) == ("INS_GYRO_FILTER", 42.0)


def test_lines_that_are_no_records_are_damage():
    junk = "#" * 30 + "\n" + "IMU, 95\n" + "WHAT, 1, 2\n"
    lines = flight(1.0).splitlines(keepends=True)
    data = ("".join(lines[:50]) + junk + "".join(lines[50:])).encode()
    summary = TextSource(data).summary()
    assert (summary.messages, summary.bad_bytes) == (5 + 3 + 100, len(junk))


def test_a_last_line_that_is_cut_is_damage():
    data = flight(1.0).encode()
    assert TextSource(data[:-25]).summary().messages == 5 + 3 + 99


def test_a_log_longer_than_a_window_is_read_as_one(monkeypatch):
    data = flight(4.0).encode()
    at_once = [(one.t_ns, one.gyro) for one in samples_of(data, ImuSample)]
    monkeypatch.setattr("attest_mav.logs.windows.WINDOW_BYTES", 1111)
    assert [(one.t_ns, one.gyro) for one in samples_of(data, ImuSample)] == at_once
    assert len(at_once) == 200


def test_without_times_the_inertial_records_are_spread_between_the_receivers(writer_of):
    """As firmware 3.0 writes: 50 inertial records a second without a time, and the receiver's time of the week."""
    writer = writer_of(
        {
            "IMU": ("ffffff", "GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
            "ATT": ("cccc", "Roll,Pitch,Yaw,X"),
            "GPS": ("BIBcLLeeEe", "Status,Time,NSats,HDop,Lat,Lng,RelAlt,Alt,Spd,GCrs"),
        }
    )
    for k in range(500):
        if k % 10 == 0:
            writer.add("GPS", Status=3, Time=6_283_200 + 20 * k, NSats=9, HDop=1.0, Lat=30.1, Lng=-97.9, Spd=1.0)
        writer.add("IMU", AccZ=-9.80665)
        if k % 5 == 0:
            writer.add("ATT")
    times = [one.t_ns * 1e-9 for one in samples_of(writer.data, ImuSample, source=DataflashSource)]
    assert len(times) == 500
    assert all(0.015 < after - before < 0.025 for before, after in pairwise(times))
    assert [time - 6283.2 for time in times] == pytest.approx([0.02 * k for k in range(500)], abs=0.03)
    assert DataflashSource(writer.data).summary().duration_s == pytest.approx(9.8)
    assert len(samples_of(writer.data, VelocitySample, source=DataflashSource)) == 50
    plan = Plan((1, 1), "IMU", "ATT", None, None)
    attitudes = samples_of(writer.data, AttitudeSample, plan, DataflashSource)
    assert attitudes[50].t_ns * 1e-9 - 6283.2 == pytest.approx(0.02 * 250, abs=0.03)
