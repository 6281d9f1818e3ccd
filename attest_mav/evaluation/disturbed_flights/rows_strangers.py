"""Rows: others on the link, by accident or on purpose."""

from typing import Final

from attest_mav.evaluation.disturbed_flights.forgeries import (
    ONBOARD,
    REQUEST,
    SECOND_VEHICLE,
    among,
    burst,
    extreme_reading,
    heartbeat,
    inertial_reading,
    interval,
    lowering_rates,
    message,
    parameter,
    second_vehicle,
    spinning,
    true_attitude,
    wrong_attitude,
    wrong_fix,
)
from attest_mav.evaluation.disturbed_flights.row import ACCUSE, DOUBT, SYSTEM, Disturbance
from attest_mav.mavlink.constants import MAV_AUTOPILOT_ARDUPILOTMEGA, MAV_TYPE_GIMBAL

TWO_SENDERS: Final = f"two vehicles use system {SYSTEM}"
GIMBAL: Final = 154

ROWS: Final = (
    Disturbance("a second vehicle's heartbeats, system 2", among(1.0, SECOND_VEHICLE)),
    Disturbance("a second vehicle with the same ids", second_vehicle, sign=TWO_SENDERS, verdicts=DOUBT, sent_hz=1.0),
    Disturbance("a minute of a second vehicle with the same ids comes at once, from now on", burst(60.0, 0.02)),
    Disturbance("20 s of a second vehicle with the same ids come at once, of long ago", burst(20.0, -15.0)),
    Disturbance(
        "20 s of a second vehicle with the same ids come within 2 s",
        burst(20.0, 0.02, 2.0),
        sign=TWO_SENDERS,
        verdicts=DOUBT,
    ),
    Disturbance(
        "a gimbal's heartbeats that claim an autopilot",
        among(1.0, heartbeat(SYSTEM, GIMBAL, MAV_TYPE_GIMBAL, MAV_AUTOPILOT_ARDUPILOTMEGA)),
    ),
    Disturbance("a gimbal's attitude under the vehicle's system", among(0.1, message("ATTITUDE", spinning, GIMBAL))),
    Disturbance("another onboard computer's heartbeats", among(1.0, ONBOARD), sign="held back on", recovered_s=5.5),
    Disturbance(
        "a station sets all rates to 4 Hz every 4 s",
        lowering_rates(4.0, 4),
        lasts_s=60.0,
        sign="lowers the rate",
        detected_s=20.0,
        verdicts=DOUBT,
    ),
    Disturbance(
        "a station sets all rates to 4 Hz every 15 s",
        lowering_rates(15.0, 4),
        lasts_s=60.0,
        sign="lowers the rate",
        detected_s=40.0,
        verdicts=DOUBT,
    ),
    Disturbance(
        "a station stops our messages",
        among(60.0, interval(-1.0)),
        after_s=35.0,
        recovered_s=31.0,
        sign="set to 0 Hz by 255/190",
    ),
    Disturbance("a station asks for our messages at 1 MHz", among(60.0, interval(1.0)), sign="set to 100 Hz"),
    Disturbance("a station requests our attitude 50 times a second", among(0.02, REQUEST), sign="more than 20"),
    Disturbance(
        "the autopilot is wrong; truth is forged every 0.9 s",
        among(0.9, message("ATTITUDE", true_attitude)),
        faults=("attitude-offset-north=28@15+10",),
        verdicts=ACCUSE,
        accused_s=1.2,
    ),
    Disturbance(
        "wrong attitudes are forged 20 times a second",
        among(0.05, message("ATTITUDE", wrong_attitude)),
        sign=TWO_SENDERS,
        verdicts=ACCUSE,
    ),
    Disturbance("a reading is forged 0.9 s ahead every 2 s", among(2.0, message("RAW_IMU", inertial_reading(0.9)))),
    Disturbance("a reading is forged 5 s ahead every 2 s", among(2.0, message("RAW_IMU", inertial_reading(5.0)))),
    Disturbance(
        "readings of a vehicle at rest are forged at 50 Hz",
        among(0.02, message("RAW_IMU", inertial_reading(0.005))),
        sign=TWO_SENDERS,
        verdicts=DOUBT,
        tilt_deg=3.0,
    ),
    Disturbance(
        "extreme readings are forged at 50 Hz",
        among(0.02, message("RAW_IMU", extreme_reading)),
        sign=TWO_SENDERS,
        verdicts=DOUBT,
    ),
    Disturbance(
        "fixes of 200 m/s are forged ten times a second",
        among(0.1, message("GPS_RAW_INT", wrong_fix)),
        sign=TWO_SENDERS,
        verdicts=DOUBT,
    ),
    Disturbance(
        "a low-pass of 1 to 1000 Hz is forged 50 times a second",
        among(0.02, message("PARAM_VALUE", parameter(b"INS_GYRO_FILTER", lambda tools: tools.rng.uniform(1, 1000)))),
        sign="INS_GYRO_FILTER",
    ),
    Disturbance(
        "a receiver's delay of 1 s is forged every second",
        among(1.0, message("PARAM_VALUE", parameter(b"GPS1_DELAY_MS", lambda _tools: 1000.0))),
        sign="GPS1_DELAY_MS",
    ),
    Disturbance(
        "a parameter that is no number is forged ten times a second",
        among(0.1, message("PARAM_VALUE", parameter(b"INS_GYRO_FILTER", lambda _tools: float("nan")))),
    ),
)
