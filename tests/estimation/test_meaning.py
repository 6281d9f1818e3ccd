"""What a value means stands in its fields: names of messages decide nothing."""

from math import radians

import pytest

from attest_mav.estimation.pipeline import Pipeline, PipelineSettings
from attest_mav.estimation.vehicle import AidSettings
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.lags import nominal_fix_lag_s
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.reading import read
from attest_mav.samples import AirDataSample, ImuSample, VelocitySample
from attest_mav.types import G_MPS2, EarthField, Quantum, VehicleKind, VelocityOrigin
from attest_mav.vehicle_reports import HeartbeatSample

SPEED = 8.0
DT = 0.02


def drive(imu, pipeline, kind, start_s, stop_s, fixes):
    """A level vehicle that goes north at a steady speed, with or without its receiver."""
    for k in range(round(start_s / DT), round(stop_s / DT)):
        t_ns = round(k * DT * 1e9)
        if k % 50 == 0:
            pipeline.handle(HeartbeatSample("HEARTBEAT", 1, 1, t_ns, 0, 3, True, 4, kind))
        if k % 10 == 0:
            pipeline.handle(AirDataSample("VFR_HUD", 1, 1, t_ns, SPEED, SPEED, 0.0))
            if fixes:
                v_ned = (SPEED, 0.0, 0.0)
                pipeline.handle(VelocitySample("GPS_RAW_INT", 1, 1, t_ns, t_ns, v_ned, False, VelocityOrigin.RECEIVER))
        pipeline.handle(imu(k * DT, rate=1e-5 * (k % 2)))


@pytest.mark.parametrize(
    ("kind", "choice", "rests_on"),
    [
        (VehicleKind.SURFACE, "auto", "no velocity: gravity only"),
        (VehicleKind.WING, "auto", "no velocity: airspeed"),
        (VehicleKind.WING, "none", "no velocity: airspeed"),
        (VehicleKind.WING, "groundspeed", "no velocity: airspeed"),
    ],
)
def test_a_lost_receiver_leaves_an_airspeed_to_wings_alone(imu, kind, choice, rests_on):
    """A rover's groundspeed is the autopilot's own estimate: resting on it, the witness would rest on the accused."""
    pipeline = Pipeline(PipelineSettings(aids=AidSettings(forward_speed=choice)), VelocityAided())
    pipeline.set_field(EarthField(0.0, radians(-64.0)))
    drive(imu, pipeline, kind, 0.0, 10.0, fixes=True)
    assert pipeline.lanes["RAW_IMU"].rests_on == "velocity from GPS_RAW_INT"
    drive(imu, pipeline, kind, 10.0, 40.0, fixes=False)
    assert pipeline.lanes["RAW_IMU"].rests_on == rests_on


@pytest.mark.parametrize("source", ["RAW_IMU", "RAW_IMU#1", "IMU[2]"])
def test_a_truncated_reading_gets_half_a_count_back_whatever_its_stream_is_called(source):
    quantum = Quantum(1e-3, 1e-3 * G_MPS2, 1e-3)
    sample = ImuSample(source, 1, 1, 0, 0, (0.002, -0.002, 0.0), (0.0, 0.0, -G_MPS2), None, quantum=quantum)
    reading = read(sample, (0.0, 0.0, 0.0))
    assert reading.gyro == pytest.approx((0.0025, -0.0025, 0.0))
    assert reading.accel == pytest.approx((0.0, 0.0, -1.0005 * G_MPS2))


def test_an_exact_reading_stays_even_if_its_stream_has_the_name_of_a_truncated_one():
    sample = ImuSample("RAW_IMU", 1, 1, 0, 0, (0.002, -0.002, 0.0), (0.0, 0.0, -G_MPS2), None)
    assert read(sample, (0.0, 0.0, 0.0)).gyro == (0.002, -0.002, 0.0)


@pytest.mark.parametrize(
    ("source", "origin", "delay_s"),
    [
        ("GPS_RAW_INT", VelocityOrigin.RECEIVER, 0.1),
        ("GPS[0]", VelocityOrigin.RECEIVER, 0.1),
        ("vehicle_gps_position", VelocityOrigin.RECEIVER, 0.1),
        ("GLOBAL_POSITION_INT", VelocityOrigin.ESTIMATOR, 0.01),
    ],
)
def test_a_velocity_is_late_by_its_origin(source, origin, delay_s):
    fix = VelocitySample(source, 1, 1, 0, 0, (1.0, 0.0, 0.0), False, origin)
    assert nominal_fix_lag_s(fix.origin, FlightParameters(low_pass_hz=0.0)) == delay_s
