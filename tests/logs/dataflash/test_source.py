"""DataFlash logs from a writer of the test's own: what a replay and the samples make of them."""

from math import cos, isnan, pi, radians, sin

import pytest

from attest_mav.errors import UnreadableDataError
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.logs.dataflash.source import DataflashSource
from attest_mav.logs.formats import open_source
from attest_mav.logs.source import Plan
from attest_mav.replay.engine import replay
from attest_mav.replay.plan import make_plan
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window
from attest_mav.samples import AirDataSample, AttitudeSample, ImuSample, PositionSample, VelocitySample
from attest_mav.types import AirspeedSource, AttitudeRole, VehicleKind, VelocityOrigin
from attest_mav.vehicle_reports import (
    EstimatorNewsSample,
    EstimatorStatusSample,
    HeartbeatSample,
    LandedSample,
    ParameterSample,
    TextSample,
)
from attest_mav.vehicle_settings import Setting

G = 9.80665
WHOLE = Request((GradientDescent(),), window=Window(skip_s=0.0))
PLAN = Plan((1, 1), "IMU", "SIM", "ATT", None)


def report(data, request=WHOLE):
    return as_json("flight", replay(open_source(data, "flight.bin"), request, Outputs()))


def summary_of(data):
    return DataflashSource(data).summary()


def samples_of(data, plan=PLAN, kind=object):
    source = DataflashSource(data)
    source.summary()
    return [sample for batch in source.samples(plan) for sample in batch.samples if isinstance(sample, kind)]


def test_an_autopilot_is_off_by_the_roll_that_the_test_wrote(writer):
    writer.still_flight(4.0, own_roll_deg=3.0)
    result = report(writer.data)
    assert (result["format"], result["bad_bytes"], result["frames"]) == ("dataflash", 0, len(writer.starts))
    assert result["duration_s"] == pytest.approx(4.0 - 0.02 + 0.999)
    assert result["imu"] == {"message": "IMU", "samples": 200, "rate_hz": pytest.approx(50.0), "gaps": 0}
    assert result["reference"] == {"message": "SIM", "samples": 200, "sigma": None}
    assert result["filters"][0]["tilt_deg"]["rms"] == pytest.approx(0.0, abs=0.01)
    assert result["autopilot"]["message"] == "ATT"
    assert result["autopilot"]["tilt_deg"]["rms"] == pytest.approx(3.0, abs=1e-5)


def test_readings_are_exact_but_for_the_compass(writer):
    writer.begin()
    for k in range(6):
        writer.add("MAG", TimeUS=k * 20_000, MagX=213, MagY=-20, MagZ=440, Health=1)
        writer.add("IMU", TimeUS=k * 20_000 + 5, GyrX=0.25, GyrY=-0.5, GyrZ=0.125, AccX=1.5, AccY=-2.5, AccZ=-9.5)
    sample = samples_of(writer.data, kind=ImuSample)[-1]
    assert (sample.t_ns, sample.gyro, sample.accel) == (100_005_000, (0.25, -0.5, 0.125), (1.5, -2.5, -9.5))
    assert sample.mag == pytest.approx((0.213, -0.02, 0.44))
    assert (sample.quantum.gyro, sample.quantum.accel, sample.quantum.mag) == (0.0, 0.0, 1e-3)


def test_a_compass_that_is_not_healthy_is_not_heard(writer):
    writer.begin()
    for k in range(10):
        writer.add("MAG", TimeUS=k * 20_000, MagX=200, MagZ=440, Health=0)
        writer.add("IMU", TimeUS=k * 20_000, AccZ=-G)
    assert all(sample.mag is None for sample in samples_of(writer.data, kind=ImuSample))


def test_the_second_sensor_has_one_name_in_old_and_new_logs(writer, writer_of):
    old = writer_of(
        {
            "IMU": ("Qffffff", "TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
            "IMU2": ("Qffffff", "TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
            "MSG": ("QZ", "TimeUS,Message"),
        }
    )
    writer.begin()
    old.begin()
    for k in range(10):
        writer.add("IMU", TimeUS=k * 20_000, AccZ=-G)
        writer.add("IMU", TimeUS=k * 20_000, I=1, GyrX=0.5, AccZ=-G)
        old.add("IMU", TimeUS=k * 20_000, AccZ=-G)
        old.add("IMU2", TimeUS=k * 20_000, GyrX=0.5, AccZ=-G)
    plan = Plan((1, 1), "IMU2", None, None, None)
    for data in (writer.data, old.data):
        assert summary_of(data).vehicles[1, 1].counts["IMU2"] == 10
        read = samples_of(data, plan, ImuSample)
        assert [sample.source for sample in read] == ["IMU2"] * 10
        assert {sample.gyro for sample in read} == {(0.5, 0.0, 0.0)}


def test_milliseconds_and_the_receivers_time_since_boot(writer_of):
    writer = writer_of(
        {
            "IMU": ("Iffffff", "TimeMS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
            "ATT": ("Icccc", "TimeMS,Roll,Pitch,Yaw,X"),
            "GPS": ("BIHBcLLeeEefI", "Status,TimeMS,Week,NSats,HDop,Lat,Lng,RelAlt,Alt,Spd,GCrs,VZ,T"),
            "MSG": ("Z", "Message"),
        }
    )
    writer.raw_format(128, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    writer.add("MSG", Message="ArduCopter V3.1.3 (92cdd2a3)")
    for k in range(6):
        writer.add("IMU", TimeMS=95_000 + 20 * k, AccZ=-G)
    writer.add("GPS", Status=3, TimeMS=6_283_200, Week=1800, Lat=30.1, Lng=-97.9, Spd=5.0, GCrs=90.0, VZ=-1.0, T=95_110)
    imu = samples_of(writer.data, kind=ImuSample)
    assert [sample.t_ns for sample in imu] == [(95_000 + 20 * k) * 1_000_000 for k in range(6)]
    (fix,) = samples_of(writer.data, kind=VelocitySample)
    assert fix.t_ns == 95_110 * 1_000_000
    assert fix.v_ned == pytest.approx((0.0, 5.0, -1.0), abs=1e-9)
    # 1980-01-06 and 1800 weeks: 2014-07-06.
    assert summary_of(writer.data).vehicles[1, 1].date.unix_s == pytest.approx(1_404_604_800 + 6283.2, abs=30.0)


def test_records_without_a_time_get_that_of_the_record_before(writer_of):
    writer = writer_of({"IMU": ("Qffffff", "TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"), "EV": ("B", "Id")})
    writer.add("IMU", TimeUS=70_000, AccZ=-G)
    writer.add("EV", Id=28)
    (landed,) = samples_of(writer.data, kind=LandedSample)
    assert (landed.rx_ns, landed.on_ground) == (70_000_000, False)


def test_a_fix_in_motion(writer):
    writer.begin()
    writer.add("GPA", TimeUS=0, SAcc=0.25, VV=1)
    writer.fix(200_000, Spd=10.0, GCrs=30.0, VZ=-2.5)
    (fix,) = samples_of(writer.data, kind=VelocitySample)
    expected = (10.0 * cos(radians(30.0)), 10.0 * sin(radians(30.0)), -2.5)
    assert fix.v_ned == pytest.approx(expected)
    assert (fix.vertical_known, fix.origin, fix.sigma) == (True, VelocityOrigin.RECEIVER, pytest.approx(0.25))
    (place,) = samples_of(writer.data, kind=PositionSample)
    assert (place.latitude_deg, place.longitude_deg, place.altitude_m) == pytest.approx((51.8731, 0.171, 50.0))
    assert (place.satellites, place.dilution) == (12, pytest.approx(0.8))


def test_a_receiver_without_a_vertical_velocity_does_not_measure_zero(writer):
    writer.begin()
    writer.add("GPA", TimeUS=0, SAcc=0.25, VV=0)
    writer.fix(200_000, Spd=10.0)
    assert not samples_of(writer.data, kind=VelocitySample)[0].vertical_known
    silent = type(writer)()
    silent.begin()
    silent.fix(200_000, Spd=10.0)
    silent.fix(400_000, Spd=10.0, VZ=0.5)
    silent.fix(600_000, Spd=10.0, VZ=0.0)
    assert [fix.vertical_known for fix in samples_of(silent.data, kind=VelocitySample)] == [False, True, True]


def test_the_second_receiver_stands_in_for_one_without_a_fix(writer):
    writer.begin()
    for k in range(3):
        writer.fix(200_000 * k, Status=1, Lat=0.0, Lng=0.0)
        writer.fix(200_000 * k, I=1, Spd=float(k))
    assert [fix.source for fix in samples_of(writer.data, kind=VelocitySample)] == ["GPS2"] * 3
    assert not summary_of(writer.data).vehicles[1, 1].velocity_lack


def test_without_a_fix_the_origin_tells_the_place(writer):
    writer.begin()
    writer.fix(0, Status=1)
    writer.add("ORGN", TimeUS=10, Lat=0.0, Lng=0.0)
    writer.add("ORGN", TimeUS=20, Lat=52.0, Lng=4.5, Alt=3.0)
    vehicle = summary_of(writer.data).vehicles[1, 1]
    assert vehicle.position.latitude_deg == pytest.approx(52.0)
    assert vehicle.velocity_lack == "none of 1 GPS has a 3-D fix with one"


def test_the_vehicle_by_its_first_words_events_and_modes(writer):
    writer.begin("ArduPlane V4.3.1 (ab)")
    writer.add("MODE", TimeUS=2000, Mode=11, ModeNum=11)
    writer.add("EV", TimeUS=3000, Id=10)
    writer.add("EV", TimeUS=4000, Id=11)
    beats = samples_of(writer.data, kind=HeartbeatSample)
    assert [(beat.armed, beat.mode) for beat in beats] == [(False, 11), (True, 11), (False, 11)]
    assert {beat.kind for beat in beats} == {VehicleKind.WING}
    (opening,) = [one for one in summary_of(writer.data).vehicles[1, 1].opening if isinstance(one, HeartbeatSample)]
    assert (opening.armed, opening.autopilot) == (False, 3)


def test_a_vehicle_that_says_nothing_may_be_under_way(writer):
    writer.begin()
    (opening,) = [one for one in summary_of(writer.data).vehicles[1, 1].opening if isinstance(one, HeartbeatSample)]
    assert opening.armed


def test_parameters_that_are_written_again_are_no_change(writer):
    writer.begin()
    for value in (0.1, 0.1, 0.2, 0.2):
        writer.add("PARM", TimeUS=2000, Name="AHRS_TRIM_X", Value=value)
    writer.add("PARM", TimeUS=2000, Name="SYSID_THISMAV", Value=7.0)
    told = samples_of(writer.data, kind=ParameterSample)
    assert [one.is_listed for one in told] == [True, True, False, True]
    vehicle = summary_of(writer.data).vehicles[1, 1]
    assert vehicle.settings.get(Setting.TRIM_X) == pytest.approx(0.2)
    (first,) = [one for one in vehicle.opening if isinstance(one, ParameterSample)]
    assert first.value == pytest.approx(0.1)


def test_the_trim_is_taken_off_the_autopilots_attitude(writer):
    writer.begin()
    writer.add("PARM", TimeUS=1000, Name="AHRS_TRIM_X", Value=radians(3.0))
    writer.add("PARM", TimeUS=1000, Name="AHRS_TRIM_Y", Value=0.0)
    for k in range(200):
        writer.instant(1_000_000 + 20_000 * k, own_roll_deg=-3.0)
    result = report(writer.data)
    assert result["autopilot"]["tilt_deg"]["max"] == pytest.approx(0.0, abs=0.01)
    assert any("AHRS_TRIM" in note for note in result["notes"])


def test_a_quaternion_of_an_estimator_can_be_the_reference(writer):
    writer.begin()
    for k in range(200):
        writer.instant(1_000_000 + 20_000 * k, truth=False)
        writer.add("XKQ", TimeUS=1_000_000 + 20_000 * k, Q1=cos(radians(2.0)), Q2=sin(radians(2.0)))
        writer.add("XKQ", TimeUS=1_000_000 + 20_000 * k, C=1, Q1=1.0)
    for name, tilt in (("XKQ", 4.0), ("XKQ2", 0.0)):
        result = report(writer.data, Request((GradientDescent(),), reference=name, window=Window(skip_s=0.0)))
        assert result["reference"]["message"] == name
        assert result["autopilot"]["tilt_deg"]["max"] == pytest.approx(tilt, abs=1e-4)


def test_attitudes_have_the_role_of_their_record(writer):
    writer.begin()
    writer.instant(1000, own_roll_deg=5.0)
    own, truth = samples_of(writer.data, kind=AttitudeSample)
    assert (own.source, own.role, truth.source, truth.role) == (
        "ATT",
        AttitudeRole.AUTOPILOT,
        "SIM",
        AttitudeRole.TRUTH,
    )
    assert own.euler == pytest.approx((5.0 * pi / 180.0, 0.0, 0.0))


def test_airspeed_and_the_estimators_errors(writer):
    writer.begin()
    writer.add("ARSP", TimeUS=1000, Airspeed=21.5, H=1)
    writer.add("ARSP", TimeUS=2000, Airspeed=1.5, H=0)
    writer.add("ERR", TimeUS=3000, Subsys=16, ECode=2)
    writer.add("ERR", TimeUS=3000, Subsys=5, ECode=1)
    writer.add("ERR", TimeUS=4000, Subsys=5, ECode=0)
    writer.add("ERR", TimeUS=5000, Subsys=200, ECode=7)
    (air,) = samples_of(writer.data, kind=AirDataSample)
    assert (air.airspeed, air.airspeed_source, isnan(air.groundspeed)) == (21.5, AirspeedSource.SENSOR, True)
    (news,) = samples_of(writer.data, kind=EstimatorNewsSample)
    assert "variance" in news.text
    assert [one.text for one in samples_of(writer.data, kind=TextSample) if one.source == "ERR"] == [
        "Error: radio failsafe, code 1",
        "Error resolved: radio failsafe",
        "Error: subsystem 200, code 7",
    ]


def test_the_estimator_on_itself_is_that_of_the_core_that_flies(writer):
    writer.begin()
    writer.add("XKF4", TimeUS=1000, C=0, PI=1, SV=2.5, SS=1)
    writer.add("XKF4", TimeUS=1000, C=1, PI=1, SV=0.25, SM=1.5, SS=0x4001)
    (status,) = samples_of(writer.data, kind=EstimatorStatusSample)
    assert (status.velocity, status.compass, status.limit) == (0.25, 1.5, 0.8)
    assert (status.attitude_valid, status.receiver_glitch, status.accel_error) == (True, True, False)


def test_the_secondary_estimator_is_quoted(writer):
    writer.begin()
    for k in range(200):
        writer.instant(1_000_000 + 20_000 * k)
        writer.add("AHR2", TimeUS=1_000_000 + 20_000 * k, Roll=20.0)
    intervals = report(writer.data)["verdict"]["intervals"]
    quoted = [text for interval in intervals for text in interval["autopilot_reports"]]
    assert "shows 20 deg of tilt between AHR2 and its own attitude" in quoted


def test_the_units_are_those_that_the_log_tells(writer_of):
    formats = {
        "IMU": ("QBhhhhhh", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
        "UNIT": ("QbZ", "TimeUS,Id,Label"),
        "MULT": ("Qbd", "TimeUS,Id,Mult"),
        "FMTU": ("QBNN", "TimeUS,FmtType,UnitIds,MultIds"),
    }
    writer = writer_of(formats)
    writer.add("UNIT", Id=ord("k"), Label="deg/s")
    writer.add("UNIT", Id=ord("o"), Label="m/s/s")
    writer.add("MULT", Id=ord("A"), Mult=0.1)
    writer.add("MULT", Id=ord("B"), Mult=0.01)
    writer.describe("IMU")
    writer.add("FMTU", FmtType=writer.types["IMU"], UnitIds="s#kkkooo", MultIds="F-AAABBB")
    for k in range(6):
        writer.add("IMU", TimeUS=20_000 * k, GyrX=900, AccZ=-981)
    sample = samples_of(writer.data, kind=ImuSample)[-1]
    assert sample.gyro == pytest.approx((pi / 2.0, 0.0, 0.0))
    assert sample.accel == pytest.approx((0.0, 0.0, -9.81))


def test_too_few_records_are_no_sensor(writer):
    writer.begin()
    for k in range(4):
        writer.instant(20_000 * k)
    with pytest.raises(UnreadableDataError, match="4 IMU, fewer than the 5"):
        report(writer.data)


def test_times_that_stand_still_are_said_to(writer):
    writer.begin()
    for _ in range(100):
        writer.instant(1000)
    assert "the times of its records stand still: no filter can go by them" in report(writer.data)["notes"]


def test_a_log_without_inertial_records_says_so(writer):
    writer.begin()
    writer.add("ATT", TimeUS=1000)
    with pytest.raises(UnreadableDataError, match="no IMU or IMU2"):
        make_plan(summary_of(writer.data), None, None)


def test_every_sensor_of_the_vehicle_is_a_lane_with_its_own_compass(writer):
    writer.begin()
    for k in range(200):
        t_us = 1_000_000 + 20_000 * k
        writer.add("MAG", TimeUS=t_us, MagX=200, MagZ=440, Health=1)
        writer.add("MAG", TimeUS=t_us, I=1, MagX=210, MagZ=430, Health=1)
        for number in range(3):
            writer.add("IMU", TimeUS=t_us, I=number, AccZ=-G)
        writer.add("ATT", TimeUS=t_us)
    plan = make_plan(summary_of(writer.data), None, None)
    assert (plan.imu, plan.other_sensors) == ("IMU", ("IMU2", "IMU3"))
    fields = {one.source: one.mag for one in samples_of(writer.data, plan, ImuSample)}
    assert fields["IMU"] == pytest.approx((0.2, 0.0, 0.44))
    assert fields["IMU2"] == pytest.approx((0.21, 0.0, 0.43))
    assert fields["IMU3"] == fields["IMU"]
    assert make_plan(summary_of(writer.data), "IMU2", None).other_sensors == ()
