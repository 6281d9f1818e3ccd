"""The series of a flight: values, units, and what becomes a chart."""

from math import degrees

import pytest

from attest_mav.estimation.events import Agreement, Verdict
from attest_mav.logs.source import SMOOTHED
from attest_mav.replay.comparison import Attitude, ComparedAttitude
from attest_mav.report.charts import charts_of
from attest_mav.report.kinds import Chart
from attest_mav.report.marks import MOST_MARKS, MOST_TEXTS
from attest_mav.report.recorder import Key
from attest_mav.samples import PositionSample, VelocitySample
from attest_mav.types import North, VehicleKind, VelocityOrigin
from attest_mav.vehicle_reports import EstimatorNews, EstimatorNewsSample, HeartbeatSample, LandedSample, TextSample

FILTER = "velocity-aided"


def values(recorder, *key):
    return [value for _, value in recorder.series[Key(*key)].points]


def chart_of(charts, title):
    return next(one for one in charts if one["title"].startswith(title))


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ((Chart.ROLL, FILTER), 0.0),
        ((Chart.YAW, "reference"), 0.0),
        ((Chart.TILT, FILTER, "reference"), degrees(0.01)),
        ((Chart.HEADING, FILTER, "reference"), degrees(0.02)),
        ((Chart.TILT, FILTER, "sigma"), degrees(0.01)),
        ((Chart.GYRO_BIAS, FILTER, "x"), degrees(0.01)),
        ((Chart.GYRO_BIAS, FILTER, "y"), 0.0),
        ((Chart.ACCEL_BIAS, FILTER, "x"), 0.05),
        ((Chart.ACCEL_BIAS, FILTER, "z"), -0.1),
        ((Chart.INTERVAL, "RAW_IMU"), 20.0),
        ((Chart.FIELD_STRENGTH, "RAW_IMU"), 0.5),
        ((Chart.INCLINATION, FILTER), 53.13010),
        ((Chart.VIBRATION, "RAW_IMU"), 0.0),
        ((Chart.INNOVATION, FILTER, "north", "velocity"), 1.0),
        ((Chart.INNOVATION, FILTER, "east", "velocity"), -2.0),
        ((Chart.NIS, FILTER, "velocity"), 2.5),
    ],
)
def test_a_series_has_the_values_of_the_flight(recorder, key, value):
    assert values(recorder, *key) == pytest.approx([value] * len(values(recorder, *key)), abs=1e-5)


def test_saturated_samples_are_counted_by_the_second(recorder):
    assert values(recorder, Chart.CLIPPING, "RAW_IMU") == [0.0, 2.0, *[0.0] * 10]


def test_charts_have_their_series_with_colour_and_lines(recorder, report):
    recorder.verdict(FILTER, Verdict(Agreement.AGREE, "agrees", 0.02, 0.0, "ATTITUDE", 0, 0), 3.0)
    recorder.verdict("leveling", Verdict(Agreement.AGREE, "agrees", 0.03, 0.0, "ATTITUDE", 0, 0), 3.0)
    charts = charts_of(recorder, report)
    tilt = chart_of(charts, "Tilt")
    assert [(one["label"], one["role"]) for one in tilt["series"]] == [
        ("sigma of velocity-aided", "sigma"),
        ("autopilot against velocity-aided", "verdict"),
        ("velocity-aided against reference", "ours"),
    ]
    assert tilt["lines"] == [{"value": 10.0, "label": "threshold 10°"}]
    assert chart_of(charts, "Heading")["lines"][0]["value"] == 20.0
    assert chart_of(charts, "Inclination")["lines"][0]["value"] == pytest.approx(degrees(0.9), abs=1e-3)
    assert [one["label"] for one in chart_of(charts, "Innovation over")["series"]] == ["north", "east"]
    assert "Velocity uncertainty" not in " ".join(one["title"] for one in charts)


def test_each_subject_of_a_chart_has_a_colour_of_its_own(recorder, report):
    for name in ("autopilot", "leveling", "gradient-descent", "robust"):
        recorder.series[Key(Chart.ROLL, name)] = recorder.series[Key(Chart.ROLL, FILTER)]
    roll = chart_of(charts_of(recorder, report), "Roll")
    assert [(one["label"], one["role"]) for one in roll["series"]] == [
        ("reference (SIM_STATE)", "reference"),
        ("autopilot", "autopilot"),
        ("leveling", "part2"),
        ("robust", "part3"),
        ("gradient-descent", "part4"),
        ("velocity-aided", "ours"),
    ]


def test_times_are_differences_in_milliseconds(recorder, report):
    (interval,) = chart_of(charts_of(recorder, report), "Interval")["series"]
    assert interval["t"] == [20] * 599


def test_a_proven_sigma_has_the_small_threshold(recorder, report):
    recorder.proven.add(FILTER)
    assert chart_of(charts_of(recorder, report), "Tilt")["lines"][0]["value"] == 3.0


def test_the_receiver_and_the_autopilot_have_speeds_of_their_own(recorder):
    for origin, speed in ((VelocityOrigin.RECEIVER, 3.0), (VelocityOrigin.ESTIMATOR, 6.0)):
        velocity = (speed, 4.0 / 3.0 * speed, 1.0)
        recorder.vehicle(VelocitySample("GPS", 1, 1, 0, 0, velocity, True, origin, 0.4), 2.0)
    assert values(recorder, Chart.SPEED, "receiver") == [5.0]
    assert values(recorder, Chart.SPEED, "autopilot") == [10.0]
    assert values(recorder, Chart.SPEED_SIGMA, "receiver") == [0.4]


def test_the_receiver_has_satellites_and_dilution_where_it_tells_them(recorder):
    recorder.vehicle(PositionSample("GPS", 1, 1, 0, 0, 47.0, 8.0, 400.0, 11, 0.8), 2.0)
    recorder.vehicle(PositionSample("GPS", 1, 1, 0, 0, 47.0, 8.0, 400.0), 3.0)
    assert recorder.series[Key(Chart.SATELLITES, "receiver")].points == [(2.0, 11.0)]
    assert recorder.series[Key(Chart.DILUTION, "receiver")].points == [(2.0, 0.8)]


def smoothed(recorder):
    """The smoothed attitude of the flight, with its sigma."""
    for k in range(600):
        attitude = Attitude(0, 0.02 * k, (1.0, 0.0, 0.0, 0.0), North.TRUE, 0.001, 0.002, True)
        recorder.write(ComparedAttitude(SMOOTHED, attitude, None, None))


def test_the_sigma_of_a_smoothed_reference_stands_beside_the_differences(recorder, report):
    smoothed(recorder)
    report["reference"]["message"] = SMOOTHED
    charts = charts_of(recorder, report)
    tilt, heading = (
        next(one for one in chart_of(charts, title)["series"] if one["label"] == "sigma of smoothed")
        for title in ("Tilt", "Heading")
    )
    assert tilt["role"] == "reference"
    assert tilt["v"] == pytest.approx([degrees(0.001)] * len(tilt["v"]), rel=1e-4)
    assert heading["v"] == pytest.approx([degrees(0.002)] * len(heading["v"]), rel=1e-4)
    labels = [one["label"] for one in chart_of(charts, "Roll")["series"]]
    assert labels == ["reference (smoothed)", FILTER]


def test_a_smoothed_attitude_beside_another_reference_has_a_series_of_its_own(recorder, report):
    smoothed(recorder)
    labels = [one["label"] for one in chart_of(charts_of(recorder, report), "Roll")["series"]]
    assert labels == ["reference (SIM_STATE)", SMOOTHED, FILTER]


def heartbeat(armed, mode):
    return HeartbeatSample("HEARTBEAT", 1, 1, 0, 2, 3, armed, 4, VehicleKind.UNKNOWN, mode)


def test_events_of_the_autopilot_are_marks(recorder):
    for t_s, sample in enumerate(
        [
            heartbeat(armed=False, mode=0),
            heartbeat(armed=True, mode=0),
            LandedSample("EXTENDED_SYS_STATE", 1, 1, 0, True),
            LandedSample("EXTENDED_SYS_STATE", 1, 1, 0, False),
            heartbeat(armed=True, mode=5),
            heartbeat(armed=True, mode=5),
            EstimatorNewsSample("STATUSTEXT", 1, 1, 0, EstimatorNews.LANE_SWITCH, "EKF3 lane switch 1"),
            TextSample("STATUSTEXT", 1, 1, 0, "Mission: 3 WP"),
            heartbeat(armed=False, mode=5),
        ]
    ):
        recorder.vehicle(sample, float(t_s))
    assert [(one.t_s, one.text) for one in recorder.marks.marks] == [
        (1.0, "armed"),
        (3.0, "took off"),
        (4.0, "flight mode 5"),
        (6.0, "EKF3 lane switch 1"),
        (7.0, "Mission: 3 WP"),
        (8.0, "disarmed"),
    ]


def test_a_flood_of_texts_is_bounded_and_counted(recorder):
    for k in range(MOST_MARKS + 7):
        recorder.vehicle(EstimatorNewsSample("STATUSTEXT", 1, 1, 0, EstimatorNews.VARIANCE, f"text {k}"), float(k))
    assert len(recorder.marks.marks) == MOST_MARKS
    assert recorder.marks.left_out == 7


def test_a_flood_of_other_texts_leaves_room_for_what_matters(recorder):
    for k in range(MOST_TEXTS + 5):
        recorder.vehicle(TextSample("STATUSTEXT", 1, 1, 0, f"text {k}"), float(k))
    recorder.vehicle(EstimatorNewsSample("STATUSTEXT", 1, 1, 0, EstimatorNews.VARIANCE, "EKF variance"), 200.0)
    assert [one.text for one in recorder.marks.marks] == [*[f"text {k}" for k in range(MOST_TEXTS)], "EKF variance"]
    assert recorder.marks.left_out == 5
