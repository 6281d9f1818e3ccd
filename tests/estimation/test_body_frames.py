"""The frame of each message: every rule against rotations that scipy makes of the autopilot's own formulas."""

from math import degrees, nan, pi, radians

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as pymav
from scipy.spatial.transform import Rotation

from attest_mav.estimation.body_frames import ARDUPILOT, PX4, RULES
from attest_mav.estimation.imu_frame import ImuFrame
from attest_mav.estimation.vehicle import AidSettings, Vehicle
from attest_mav.samples import AttitudeSample
from attest_mav.types import AttitudeForm, AttitudeRole, VehicleKind
from attest_mav.vehicle_reports import EstimatorSample, FirmwareSample, HeartbeatSample, ParameterSample
from attest_mav.vehicle_settings import Estimator, Setting

TRIM = (0.10, -0.12, 0.05)
POSES = ((0.0, 0.0, 0.0), (35.0, -20.0, 140.0), (-50.0, 30.0, -95.0), (170.0, -60.0, 10.0), (2.0, 70.0, 179.9))
"""Roll, pitch and yaw of the IMU, degrees."""

COPTER, PLANE, TAILSITTER = 2, 1, 19
FBWA, AUTO, QSTABILIZE = 5, 10, 17
DCM, EKF3, SIM, EXTERNAL = Estimator.DCM, Estimator.EKF3, Estimator.SIMULATOR, Estimator.EXTERNAL
V40, V41, V42, V46, V48 = (4, 0, 3), (4, 1, 5), (4, 2, 0), (4, 6, 1), (4, 8, 0)


def rotation_of(euler):
    return Rotation.from_euler("ZYX", euler[::-1])


def euler_of(rotation):
    return tuple(float(angle) for angle in rotation.as_euler("ZYX")[::-1])


def quaternion_of(rotation):
    x, y, z, w = rotation.as_quat()
    return (float(w), float(x), float(y), float(z))


def matrix_form(imu, trim=TRIM):
    return imu * rotation_of(trim).inv()


def euler_difference(imu, trim=TRIM):
    return tuple(a - t for a, t in zip(euler_of(imu), trim, strict=True))


def rotation_vector(imu, trim=TRIM):
    return imu * Rotation.from_rotvec(trim).inv()


def sent_euler(source, euler, role=AttitudeRole.AUTOPILOT, t_ms=1000):
    q = quaternion_of(rotation_of(euler))
    t_ns = t_ms * 1_000_000
    return AttitudeSample(source, 1, 1, t_ns, t_ns, q, None, role, AttitudeForm.EULER, tuple(euler))


def sent_quaternion(source, rotation, role=AttitudeRole.AUTOPILOT, t_ms=1000):
    t_ns = t_ms * 1_000_000
    return AttitudeSample(source, 1, 1, t_ns, t_ns, quaternion_of(rotation), None, role, AttitudeForm.QUATERNION)


class Told:
    """A vehicle that has told this much."""

    def __init__(self, autopilot=ARDUPILOT, kind=COPTER, mode=0, version=None, estimator=None, **settings):
        self.vehicle = Vehicle(AidSettings())
        self.frame = ImuFrame(self.vehicle)
        self.autopilot, self.kind = autopilot, kind
        self.fly(mode)
        if version is not None:
            self.vehicle.take(FirmwareSample("AUTOPILOT_VERSION", 1, 1, 0, version))
        if estimator is not None:
            self.vehicle.take(EstimatorSample("STATUSTEXT", 1, 1, 0, estimator))
        for name, value in settings.items():
            self.tell(Setting[name.upper()], value)

    def fly(self, mode):
        kind = VehicleKind.WING if self.kind in {PLANE, TAILSITTER} else VehicleKind.ROTARY
        self.vehicle.take(HeartbeatSample("HEARTBEAT", 1, 1, 0, self.kind, self.autopilot, False, 3, kind, mode))

    def tell(self, setting, value):
        self.vehicle.take(ParameterSample("PARAM_VALUE", 1, 1, 0, setting.name, setting, value))

    def error_deg(self, sample, imu):
        """Angle between the attitude that is found and the IMU's, degrees."""
        found = self.frame.attitude(sample)
        w, x, y, z = found.q_nb
        return degrees((Rotation.from_quat((x, y, z, w)).inv() * imu).magnitude())


def trimmed(trim=TRIM, **others):
    return Told(trim_x=trim[0], trim_y=trim[1], trim_z=trim[2], **others)


OWN, OTHER, TRUTH = AttitudeRole.AUTOPILOT, AttitudeRole.SECONDARY, AttitudeRole.TRUTH
AS_EULER = AttitudeForm.EULER
A, B, C, NONE = "euler difference", "matrix", "rotation vector", "none"
ROWS = (
    ("ATTITUDE", OWN, None, EKF3, A),
    ("ATTITUDE", OWN, V46, EKF3, A),
    ("ATTITUDE", OWN, None, Estimator.EKF2, A),
    ("ATTITUDE", OWN, V46, DCM, B),
    ("ATTITUDE", OWN, V46, SIM, B),
    ("ATTITUDE", OWN, V46, EXTERNAL, B),
    ("ATTITUDE", OWN, V48, EXTERNAL, NONE),
    ("ATT", OWN, V46, EKF3, A),
    ("ATT", OWN, V46, DCM, B),
    ("ATT", OWN, V48, EXTERNAL, NONE),
    ("ATTITUDE_QUATERNION", OWN, V42, EKF3, C),
    ("ATTITUDE_QUATERNION", OWN, V46, DCM, C),
    ("ATTITUDE_QUATERNION", OWN, V46, EXTERNAL, NONE),
    ("AHRS2", OTHER, V46, EKF3, B),
    ("AHRS2", OTHER, V46, DCM, A),
    ("AHR2", OTHER, V46, EKF3, B),
    ("AHR2", OTHER, V46, DCM, A),
    ("AHR2 quaternion", OTHER, V46, EKF3, C),
    ("AHR2 quaternion", OTHER, V41, EKF3, NONE),
    ("XKF1", OWN, V46, EKF3, A),
    ("XKF1", OTHER, V46, DCM, A),
    ("NKF1", OWN, V40, EKF3, A),
    ("XKQ", OWN, V46, EKF3, NONE),
    ("NKQ", OWN, V40, EKF3, NONE),
    *((source, OTHER, V40, EKF3, A) for source in ("XKF6", "XKF11", "NKF6", "NKF11", "EKF1")),
    *((source, OTHER, V40, EKF3, NONE) for source in ("XKQ2", "XKQ3", "NKQ2", "NKQ3")),
    ("DCM", OTHER, V46, EKF3, B),
    ("SIM_STATE", TRUTH, V46, EKF3, NONE),
    ("SIMSTATE", TRUTH, V46, EKF3, NONE),
)
QUATERNIONS = {"ATTITUDE_QUATERNION", "AHR2 quaternion", "SIM_STATE", "XKQ", "XKQ2", "XKQ3", "NKQ", "NKQ2", "NKQ3"}


def reported(source, role, form, imu):
    """The sample that an autopilot sends whose IMU has this attitude."""
    name = source.removesuffix(" quaternion")
    if source in QUATERNIONS:
        turned = {C: rotation_vector, NONE: lambda it: it}[form](imu)
        return sent_quaternion(name, turned, role)
    angles = {A: euler_difference, B: lambda it: euler_of(matrix_form(it)), NONE: euler_of}[form](imu)
    return sent_euler(name, angles, role)


@pytest.mark.parametrize(("source", "role", "version", "estimator", "form"), ROWS)
def test_every_rule_gives_the_attitude_of_the_imu(source, role, version, estimator, form):
    told = trimmed(version=version, estimator=estimator)
    for pose in POSES:
        imu = rotation_of(np.radians(pose))
        assert told.error_deg(reported(source, role, form, imu), imu) < 1e-6


def test_every_rule_of_ardupilot_has_a_row_above():
    tested = {(source.removesuffix(" quaternion"), source in QUATERNIONS) for source, *_ in ROWS}
    written = {(rule.source, rule.written == AttitudeForm.QUATERNION) for rule in RULES if rule.autopilot == ARDUPILOT}
    assert written <= tested


def test_a_record_that_writes_its_attitude_twice_has_two_forms():
    told, imu = trimmed(version=V46, estimator=EKF3), rotation_of(np.radians(POSES[1]))
    for _ in range(2):
        assert told.error_deg(reported("AHR2", OTHER, B, imu), imu) < 1e-6
        assert told.error_deg(reported("AHR2 quaternion", OTHER, C, imu), imu) < 1e-6


@pytest.mark.parametrize("source", ["ATTITUDE", "ATTITUDE_QUATERNION", "vehicle_attitude"])
def test_px4_turns_its_sensors_and_nothing_is_undone(source):
    told = trimmed(autopilot=PX4, pitch_trim=radians(5.0))
    imu = rotation_of(np.radians(POSES[1]))
    sample = sent_euler(source, euler_of(imu)) if source == "ATTITUDE" else sent_quaternion(source, imu)
    assert told.error_deg(sample, imu) < 1e-6
    assert told.frame.attitude(sample).frame_known


def test_the_numbers_are_mavlinks():
    assert (ARDUPILOT, PX4) == (pymav.MAV_AUTOPILOT_ARDUPILOTMEGA, pymav.MAV_AUTOPILOT_PX4)


@pytest.mark.parametrize(
    ("trim", "reading"), [((0.0873, 0.0, 0.0), (-5.0, 0.0, 0.0)), ((0.0, -0.0698, 0.0), (0.0, 4.0, 0.0))]
)
def test_a_board_that_stands_level_as_seen_in_the_simulator(trim, reading):
    level = rotation_of((0.0, 0.0, 0.0))
    assert trimmed(trim).error_deg(sent_euler("ATTITUDE", np.radians(reading)), level) < 0.01


def test_the_wrong_form_errs_by_degrees_in_a_bank_as_seen_in_the_simulator():
    """Trims of 5.7 and -6.9 degrees, banks up to 35: form A fits ATTITUDE exactly, B errs by up to 4.0 degrees."""
    told = trimmed((0.10, -0.12, 0.0), estimator=DCM)
    imu = rotation_of(np.radians((35.0, 0.0, 50.0)))
    sample = sent_euler("ATTITUDE", euler_difference(imu, (0.10, -0.12, 0.0)))
    assert 3.0 < told.error_deg(sample, imu) < 4.5
    told.vehicle.take(EstimatorSample("STATUSTEXT", 1, 1, 0, EKF3))
    assert told.error_deg(sample, imu) < 1e-6


@pytest.mark.parametrize(
    ("told", "pitch_deg", "quaternion_deg"),
    [
        ({"pitch_trim": radians(5.0)}, -4.99, 0.01),
        ({"pitch_trim": radians(5.0), "flight_options": 256.0}, 0.01, 0.01),
        ({"pitch_trim": radians(5.0), "flight_options": 512.0}, -4.99, 0.01),
        ({"pitch_trim": radians(5.0), "trim_y": radians(5.0)}, -9.99, -4.99),
        ({"pitch_trim": radians(5.0), "hovers": 1.0, "hover_pitch_trim": radians(3.0), "mode": FBWA}, -4.99, 0.01),
        ({"pitch_trim": radians(5.0), "hovers": 1.0, "hover_pitch_trim": radians(3.0), "mode": QSTABILIZE}, -2.99, 0.0),
        ({"pitch_trim": radians(5.0), "hovers": 1.0, "hover_pitch_trim": radians(6.0), "mode": QSTABILIZE}, -5.98, 0.0),
    ],
)
def test_a_plane_whose_board_stands_level_as_seen_in_the_simulator(told, pitch_deg, quaternion_deg):
    plane = Told(kind=PLANE, version=V46, **told)
    level = rotation_of((0.0, 0.0, 0.0))
    assert plane.error_deg(sent_euler("ATTITUDE", (0.0, radians(pitch_deg), 0.0)), level) < 0.03
    turned = rotation_of((0.0, radians(quaternion_deg), 0.0))
    assert plane.error_deg(sent_quaternion("ATTITUDE_QUATERNION", turned), level) < 0.03


def test_a_plane_in_a_bank():
    """Fixed-wing view: the Euler difference, less the pitch trim; in the hover: the matrix form, turned about y."""
    trim, pitch_trim, hover_trim = TRIM, radians(4.0), radians(-3.0)
    told = trimmed(kind=PLANE, pitch_trim=pitch_trim, hovers=1.0, hover_pitch_trim=hover_trim, version=V46)
    for pose in POSES[:3]:
        imu = rotation_of(np.radians(pose))
        roll, pitch, yaw = euler_difference(imu, trim)
        told.fly(FBWA)
        assert told.error_deg(sent_euler("ATTITUDE", (roll, pitch - pitch_trim, yaw)), imu) < 1e-6
        told.fly(QSTABILIZE)
        view = matrix_form(imu) * rotation_of((0.0, hover_trim, 0.0)).inv()
        assert told.error_deg(sent_euler("ATTITUDE", euler_of(view)), imu) < 1e-6


def test_a_vtol_plane_before_the_view_of_the_hover():
    told = Told(kind=PLANE, pitch_trim=radians(5.0), hovers=1.0, mode=QSTABILIZE, version=V40)
    level = rotation_of((0.0, 0.0, 0.0))
    assert told.error_deg(sent_euler("ATTITUDE", (0.0, radians(-5.0), 0.0)), level) < 1e-6


def test_a_mode_that_flies_both_ways_leaves_the_view_open_where_the_views_differ():
    told = trimmed(kind=PLANE, pitch_trim=radians(5.0), hovers=1.0, mode=AUTO, version=V46)
    sample = sent_euler("ATTITUDE", (0.0, 0.0, 0.0))
    assert told.frame.attitude(sample) is None
    assert "ATTITUDE is not compared" in told.frame.notes[0]
    told.tell(Setting.HOVER_PITCH_TRIM, radians(5.0))
    assert told.frame.attitude(sample) is not None
    assert all("not compared" not in note for note in told.frame.notes)


@pytest.mark.parametrize(
    "told", [{"kind": PLANE, "hovers": 1.0, "tailsitter": 1.0}, {"kind": PLANE, "hovers": 1.0, "hover_frame": 10.0},
             {"kind": TAILSITTER}]
)  # fmt: skip
def test_only_the_quaternion_tells_the_attitude_of_a_tailsitter(told):
    vehicle = trimmed(version=V46, mode=QSTABILIZE, **told)
    nose_up = rotation_of(np.radians((0.0, 89.0, 30.0)))
    assert vehicle.frame.attitude(sent_euler("ATTITUDE", (0.0, 0.0, 0.5))) is None
    assert vehicle.error_deg(sent_quaternion("ATTITUDE_QUATERNION", rotation_vector(nose_up)), nose_up) < 1e-6


def test_the_angles_as_sent_are_used_and_not_those_of_the_quaternion():
    """The pitch as sent may lie beyond 90 degrees, where a quaternion cannot keep it apart from its mirror image."""
    trim = (0.0, -0.3, 0.0)
    imu = rotation_of(np.radians((20.0, 80.0, 40.0)))
    sent = euler_difference(imu, trim)
    assert sent[1] > 0.5 * pi
    assert trimmed(trim).error_deg(sent_euler("ATTITUDE", sent), imu) < 1e-6


def test_near_the_vertical_an_euler_difference_is_not_undone():
    told = trimmed(estimator=EKF3)
    steep = sent_euler("ATTITUDE", euler_difference(rotation_of(np.radians((0.0, 88.0, 0.0)))))
    assert told.frame.attitude(steep) is None
    assert "too near 90 degrees" in told.frame.notes[0]
    plain = trimmed((0.0, 0.0, 0.0))
    assert plain.frame.attitude(sent_euler("ATTITUDE", np.radians((0.0, 88.0, 0.0)))) is not None


def test_before_4_1_the_quaternion_is_another_estimators():
    told = trimmed(version=V40)
    assert told.frame.attitude(sent_quaternion("ATTITUDE_QUATERNION", rotation_of((0.0, 0.0, 0.0)))) is None
    assert "secondary" in told.frame.notes[0]


@pytest.mark.parametrize(("version", "form"), [(None, C), (None, NONE), (V41, C), (V41, NONE)])
def test_where_the_version_does_not_tell_the_form_that_fits_attitude_is_taken(version, form):
    told = trimmed((0.07, 0.03, 0.0), version=version)
    imu = rotation_of(np.radians((10.0, 5.0, 60.0)))
    angles = euler_difference(imu, (0.07, 0.03, 0.0))
    turned = rotation_vector(imu, (0.07, 0.03, 0.0)) if form == C else imu
    errors = []
    for step in range(10):
        told.frame.attitude(sent_euler("ATTITUDE", angles, t_ms=1000 + 100 * step))
        errors.append(told.error_deg(sent_quaternion("ATTITUDE_QUATERNION", turned, t_ms=1001 + 100 * step), imu))
    assert max(errors[1:]) < 1e-6


def test_the_estimator_is_the_one_that_is_set_until_the_autopilot_names_another():
    imu = rotation_of(np.radians((35.0, 5.0, 60.0)))
    told = trimmed(version=V46)
    told.tell(Setting.ESTIMATOR, 0.0)
    assert told.error_deg(reported("ATTITUDE", OWN, B, imu), imu) < 1e-6
    told.vehicle.take(EstimatorSample("STATUSTEXT", 1, 1, 0, EKF3))
    assert told.error_deg(reported("ATTITUDE", OWN, A, imu), imu) < 1e-6
    told.vehicle.take(EstimatorSample("STATUSTEXT", 1, 1, 0, DCM))
    assert told.error_deg(reported("ATTITUDE", OWN, B, imu), imu) < 1e-6


def test_a_changed_trim_counts_from_the_next_attitude_on():
    told = trimmed((0.0, 0.0, 0.0))
    level = rotation_of((0.0, 0.0, 0.0))
    assert told.error_deg(sent_euler("ATTITUDE", (0.0, 0.0, 0.0)), level) < 1e-6
    told.tell(Setting.TRIM_X, 0.1)
    assert told.error_deg(sent_euler("ATTITUDE", (-0.1, 0.0, 0.0)), level) < 1e-6


def test_a_trim_that_is_not_told_leaves_the_frame_unknown():
    told = Told(version=V46)
    sample = sent_euler("ATTITUDE", (0.1, 0.2, 0.3))
    assert not told.frame.attitude(sample).frame_known
    assert told.frame.attitude(sample).q_nb == sample.q_nb
    told.tell(Setting.TRIM_X, 0.0)
    assert not told.frame.attitude(sample).frame_known
    told.tell(Setting.TRIM_Y, 0.0)
    assert told.frame.attitude(sample).frame_known
    told.vehicle.forget_trims()
    assert not told.frame.attitude(sample).frame_known


def test_of_a_plane_the_pitch_trim_has_to_be_told_too():
    told = trimmed(kind=PLANE, version=V46)
    sample = sent_euler("ATTITUDE", (0.1, 0.2, 0.3))
    assert not told.frame.attitude(sample).frame_known
    assert told.frame.attitude(sent_quaternion("ATTITUDE_QUATERNION", rotation_of((0.1, 0.2, 0.3)))).frame_known
    told.tell(Setting.PITCH_TRIM, 0.0)
    assert told.frame.attitude(sample).frame_known


def test_trims_of_zero_change_no_bit():
    told = trimmed((0.0, 0.0, 0.0), kind=PLANE, pitch_trim=0.0, version=V46)
    for pose in POSES:
        angles = sent_euler("ATTITUDE", np.radians(pose))
        assert told.frame.attitude(angles).q_nb == angles.q_nb
        quaternion = sent_quaternion("ATTITUDE_QUATERNION", rotation_of(np.radians(pose)))
        assert told.frame.attitude(quaternion).q_nb == quaternion.q_nb
    assert told.frame.notes == []


def test_the_note_names_the_trim_and_the_message():
    told = trimmed((radians(4.0), radians(2.0), 0.0), kind=PLANE, version=V46)
    told.frame.attitude(sent_euler("ATTITUDE", (0.0, 0.0, 0.0)))
    assert told.frame.notes == ["AHRS_TRIM 4.0, 2.0 deg taken off ATTITUDE"]
    told.tell(Setting.PITCH_TRIM, radians(1.5))
    told.tell(Setting.TRIM_Z, radians(-1.0))
    told.frame.attitude(sent_euler("ATTITUDE", (0.0, 0.0, 0.0)))
    assert told.frame.notes == ["AHRS_TRIM 4.0, 2.0, -1.0 deg and pitch trim 1.5 deg taken off ATTITUDE"]


def test_before_the_first_heartbeat_nothing_is_known_and_nothing_done():
    frame = ImuFrame(Vehicle(AidSettings()))
    sample = sent_euler("ATTITUDE", (0.1, 0.2, nan))
    assert frame.attitude(sample) is sample
