"""Rows: sensors, the receiver, the autopilot and its answers."""

from math import inf
from typing import Final

from attest_mav.evaluation.disturbed_flights.forgeries import denying, with_field
from attest_mav.evaluation.disturbed_flights.link_faults import without
from attest_mav.evaluation.disturbed_flights.row import ACCUSE, BEGIN_S, DOUBT, Disturbance

SET_ASIDE: Final = "RAW_IMU set aside"

ROWS: Final = (
    Disturbance(
        "the autopilot reboots",
        faults=("reboot@15",),
        lasts_s=2.0,
        sign="went back",
        verdicts=DOUBT,
        detected_s=4.0,
        recovered_s=3.0,
    ),
    Disturbance("gyro 1 is off by 5 deg/s", faults=("gyro1-bias-x=5@15+10",), sign=SET_ASIDE, verdicts=ACCUSE),
    Disturbance("gyro 1 stops", faults=("gyro1-stop@15+10",), sign=SET_ASIDE, verdicts=ACCUSE, detected_s=6.0),
    Disturbance(
        "both gyros are off by 3 deg/s",
        faults=("gyro-bias-x=3@15+10",),
        verdicts=ACCUSE,
        tilt_deg=10.0,
        after_s=45.0,
        recovered_s=40.0,
    ),
    Disturbance("accelerometer 1 reads 5 m/s2", faults=("accel1-stuck=5@15+10",), sign=SET_ASIDE, verdicts=DOUBT),
    Disturbance("accelerometer 1 is off by 1 m/s2", faults=("accel1-bias-x=1@15+10",), verdicts=DOUBT),
    Disturbance(
        "sensor 1 repeats one reading", faults=("imu1-freeze@15+10",), sign=SET_ASIDE, verdicts=ACCUSE, detected_s=6.0
    ),
    Disturbance(
        "both sensors repeat one reading of a turn",
        faults=("imu-freeze@24+6",),
        begin_s=24.0,
        lasts_s=6.0,
        sign="repeats one reading",
        verdicts=ACCUSE,
        tilt_deg=3.0,
        recovered_s=inf,
    ),
    Disturbance(
        "both sensors are saturated for 0.3 s",
        faults=("imu-saturated@15+0.3",),
        lasts_s=0.3,
        verdicts=DOUBT,
        recovered_s=4.0,
    ),
    Disturbance(
        "both sensors read NaN",
        faults=("imu-nan@15+10",),
        personality="px4",
        verdicts=DOUBT,
        sign="not finite|samples stopped",
        recovered_s=4.0,
    ),
    Disturbance("sensor 1 falls silent", faults=("imu1-silent@15+10",), sign="RAW_IMU.*no samples"),
    Disturbance("the frame vibrates with 20 m/s2", faults=("vibration=20@15+10",)),
    Disturbance("the magnetometers read zero", with_field(0.0, 0), sign="without magnetometer", detected_s=3.0),
    Disturbance(
        "a magnet of 300 mG along the nose", with_field(1.0, 300), sign="withheld: contradicted", verdicts=DOUBT
    ),
    Disturbance("magnetometer 1 is off by 300 mG", faults=("compass1=300@15+10",)),
    Disturbance(
        "no fix for 40 s; the autopilot drifts by 4 deg",
        faults=("receiver-off@15+40",),
        lasts_s=40.0,
        verdicts=ACCUSE,
        recovered_s=4.0,
        accused_s=30.0,
    ),
    Disturbance(
        "the receiver is off by 5 m/s",
        faults=("receiver-offset-north=5@15+10",),
        verdicts=DOUBT,
        sign="receiver",
        recovered_s=4.0,
    ),
    Disturbance(
        "fixes are late by 0.4 s more",
        faults=("receiver-late=0.4@15+10",),
        verdicts=DOUBT,
        sign="receiver",
        detected_s=5.0,
    ),
    Disturbance("the autopilot is off by 5 deg", faults=("trim-x=5@15+10",), verdicts=ACCUSE, accused_s=1.2),
    Disturbance(
        "the autopilot repeats one attitude", faults=("attitude-frozen@15+10",), verdicts=ACCUSE, accused_s=5.0
    ),
    Disturbance("the autopilot's attitudes are lost", without("ATTITUDE"), sign="no-reference", verdicts=DOUBT),
    Disturbance(
        "no command is acknowledged",
        without("COMMAND_ACK"),
        begin_s=0.0,
        lasts_s=BEGIN_S + 10.0,
        verdicts=DOUBT,
        recovered_s=inf,
    ),
    Disturbance(
        "every command is denied, and no SCALED_IMU2 comes",
        denying("SCALED_IMU2"),
        begin_s=0.0,
        lasts_s=BEGIN_S + 10.0,
        sign="denied|one sensor",
        verdicts=DOUBT,
        recovered_s=inf,
    ),
)
