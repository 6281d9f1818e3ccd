"""The unit table, row by row, through the decoder: what each autopilot's numbers become."""

import math

import pytest
from pymavlink.dialects.v20 import all as pymav

from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.decode.units import MagnitudeCheck, RawScales
from attest_mav.mavlink.wire.framer import Framer

G = 9.80665
ARDUPILOT, PX4, INVALID = pymav.MAV_AUTOPILOT_ARDUPILOTMEGA, pymav.MAV_AUTOPILOT_PX4, pymav.MAV_AUTOPILOT_INVALID
GENERIC = 0
MAG_BITS = 0x1C0


class Vehicle:
    """Messages of one system into a decoder."""

    def __init__(self, dialect, sender, autopilot, raw_scales=None):
        self.framer = Framer(dialect, None)
        self.decoder = Decoder(dialect, raw_scales)
        self.sender = sender
        if autopilot is not None:
            self.hear(pymav.MAVLink_heartbeat_message(2, autopilot, 0, 0, 4, 3))

    def hear(self, message, sender=None):
        (frame,) = self.framer.feed((sender or self.sender).pack(message), 77)
        return self.decoder.decode(frame)

    def hear_often(self, make, count=5):
        """The samples of ``count`` messages: so many the start-up checks want to see."""
        return [sample for number in range(count) for sample in self.hear(make(number))]


@pytest.fixture
def vehicle(dialect, sender):
    def make(autopilot, raw_scales=None):
        return Vehicle(dialect, sender, autopilot, raw_scales)

    return make


def raw_imu(number, accel=(100, -200, -950), gyro=(10, -20, 30), mag=(210, -40, 430), sensor=0):
    return pymav.MAVLink_raw_imu_message(1_000_000 + 20_000 * number, *accel, *gyro, *mag, id=sensor)


def scaled(message, number, accel=(100, -200, -950), gyro=(10, -20, 30), mag=(210, -40, 430)):
    return message(1000 + 20 * number, *accel, *gyro, *mag)


def highres(number, accel=(1.0, -2.0, -9.5), gyro=(0.25, -0.5, 1.0), mag=(0.25, -0.0625, 0.5), bits=0x1FF, sensor=0):
    return pymav.MAVLink_highres_imu_message(
        1_000_000 + 4000 * number, *accel, *gyro, *mag, 1013.0, 0.0, 0.0, 20.0, bits, id=sensor
    )


# --- the rows ------------------------------------------------------------------------------------------------------

SCALED = [
    pymav.MAVLink_scaled_imu_message,
    pymav.MAVLink_scaled_imu2_message,
    pymav.MAVLink_scaled_imu3_message,
]


def assert_milli(sample, has_field=True):
    """mG, mrad/s and mgauss, from the numbers above."""
    assert sample.accel == pytest.approx((0.1 * G, -0.2 * G, -0.95 * G), rel=1e-12)
    assert sample.gyro == pytest.approx((0.010, -0.020, 0.030), rel=1e-12)
    assert sample.mag == (pytest.approx((0.210, -0.040, 0.430), rel=1e-12) if has_field else None)
    assert not sample.saturated


def test_raw_imu_of_ardupilot_is_milli_units(vehicle):
    samples = vehicle(ARDUPILOT).hear_often(raw_imu)
    assert len(samples) == 5
    assert_milli(samples[0])
    assert [sample.t_ns for sample in samples] == [1_000_000_000 + 20_000_000 * i for i in range(5)]
    assert (samples[0].source, samples[0].system, samples[0].component, samples[0].rx_ns) == ("RAW_IMU", 1, 1, 77)


@pytest.mark.parametrize("autopilot", [PX4, GENERIC])
def test_raw_imu_of_others_is_refused_without_scales(vehicle, autopilot):
    other = vehicle(autopilot)
    assert other.hear_often(raw_imu) == []
    assert "configure the scales" in other.decoder.refusals["RAW_IMU"]
    assert other.decoder.refused == {"RAW_IMU": 5}


def test_raw_imu_of_others_is_scaled_as_configured(vehicle):
    samples = vehicle(PX4, RawScales(accel=0.01, gyro=0.002, mag=0.0015)).hear_often(raw_imu)
    assert samples[0].accel == pytest.approx((1.0, -2.0, -9.5), rel=1e-12)
    assert samples[0].gyro == pytest.approx((0.02, -0.04, 0.06), rel=1e-12)
    assert samples[0].mag == pytest.approx((0.315, -0.06, 0.645), rel=1e-12)


def test_configured_scales_do_not_touch_ardupilot(vehicle):
    assert_milli(vehicle(ARDUPILOT, RawScales(1.0, 1.0, 1.0)).hear_often(raw_imu)[0])


@pytest.mark.parametrize("autopilot", [ARDUPILOT, PX4, GENERIC])
@pytest.mark.parametrize("message", SCALED)
def test_scaled_imu_is_milli_units_everywhere(vehicle, autopilot, message):
    samples = vehicle(autopilot).hear_often(lambda number: scaled(message, number))
    assert len(samples) == 5
    assert_milli(samples[0], has_field=autopilot != PX4)
    assert samples[0].source == message.msgname
    assert [sample.t_ns for sample in samples] == [1_000_000_000 + 20_000_000 * i for i in range(5)]


@pytest.mark.parametrize("autopilot", [ARDUPILOT, PX4, GENERIC])
def test_highres_imu_is_si_and_gauss(vehicle, autopilot):
    samples = vehicle(autopilot).hear_often(highres)
    assert len(samples) == 5
    assert samples[0].accel == (1.0, -2.0, -9.5)
    assert samples[0].gyro == (0.25, -0.5, 1.0)
    assert samples[0].mag == (0.25, -0.0625, 0.5)
    assert samples[1].t_ns == 1_004_000_000


def test_highres_imu_of_older_ardupilots_has_its_field_corrected_and_says_so(vehicle):
    copter = vehicle(ARDUPILOT)
    samples = copter.hear_often(lambda number: highres(number, mag=(250_000.0, -62_500.0, 500_000.0)), 7)
    assert len(samples) == 7
    for sample in samples:
        assert sample.mag == pytest.approx((0.25, -0.0625, 0.5), rel=1e-12)
    assert "1000000 times too large" in copter.decoder.notes["HIGHRES_IMU"]
    assert copter.decoder.refusals == {}


def test_the_same_field_from_px4_is_refused_not_corrected(vehicle):
    px4 = vehicle(PX4)
    samples = px4.hear_often(lambda number: highres(number, mag=(250_000.0, -62_500.0, 500_000.0)))
    assert [sample.mag for sample in samples] == [None] * 5
    assert "magnetometer reads 562500 gauss" in px4.decoder.refusals["HIGHRES_IMU magnetometer"]
    assert "0.1 to 2.5" in px4.decoder.refusals["HIGHRES_IMU magnetometer"]


def test_the_field_in_scaled_imu_of_px4_is_none(vehicle):
    """It is in the axes of the compass, with the vehicle's own field: a heading from it is wrong by any angle."""
    samples = vehicle(PX4).hear_often(lambda number: scaled(SCALED[0], number))
    assert [sample.mag for sample in samples] == [None] * 5
    samples = vehicle(ARDUPILOT).hear_often(lambda number: scaled(SCALED[0], number))
    assert None not in [sample.mag for sample in samples]


def test_only_px4s_highres_imu_depends_on_its_estimator(vehicle):
    px4 = vehicle(PX4)
    px4.hear_often(highres)
    px4.hear_often(lambda number: scaled(SCALED[0], number))
    assert px4.decoder.independent == {"HIGHRES_IMU": False, "SCALED_IMU": True}
    assert "not independent" in px4.decoder.notes["HIGHRES_IMU"]
    assert "uncalibrated" in px4.decoder.notes["SCALED_IMU"]
    copter = vehicle(ARDUPILOT)
    copter.hear_often(highres)
    copter.hear_often(raw_imu)
    assert copter.decoder.independent == {"HIGHRES_IMU": True, "RAW_IMU": True}


# --- fields_updated ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("missing", [1 << bit for bit in range(6)])
def test_highres_without_all_bits_of_accelerometer_and_gyro_is_no_reading(vehicle, missing):
    px4 = vehicle(PX4)
    assert px4.hear_often(lambda number: highres(number, bits=0x1FF & ~missing)) == []
    assert "fields_updated" in px4.decoder.refusals["HIGHRES_IMU"]
    assert px4.decoder.refused == {"HIGHRES_IMU": 5}


@pytest.mark.parametrize("missing", [0x40, 0x80, 0x100, MAG_BITS])
def test_highres_without_all_bits_of_the_magnetometer_has_no_field(vehicle, missing):
    px4 = vehicle(PX4)
    px4.hear_often(highres)
    (sample,) = px4.hear(highres(6, bits=0xFFFF & ~missing))
    assert sample.mag is None
    (sample,) = px4.hear(highres(7, mag=(0.25, 0.0, 0.5)))
    assert sample.mag == (0.25, 0.0, 0.5)


# --- zero, stale and broken readings -------------------------------------------------------------------------------


def test_scaled_imu3_with_a_magnetometer_alone_is_no_lane(vehicle):
    plane = vehicle(ARDUPILOT)
    assert plane.hear_often(lambda number: scaled(SCALED[2], number, (0, 0, 0), (0, 0, 0))) == []
    assert "no accelerometer and no gyro" in plane.decoder.refusals["SCALED_IMU3"]
    assert plane.decoder.refused == {"SCALED_IMU3": 5}


def test_a_gyro_of_zero_at_rest_is_a_reading(vehicle):
    samples = vehicle(ARDUPILOT).hear_often(lambda number: raw_imu(number, gyro=(0, 0, 0)))
    assert [sample.gyro for sample in samples] == [(0.0, 0.0, 0.0)] * 5


def test_a_field_of_zero_is_no_field_and_later_ones_are_checked_first(vehicle):
    copter = vehicle(ARDUPILOT)
    samples = copter.hear_often(lambda number: raw_imu(number, mag=(0, 0, 0)), 8)
    assert [sample.mag for sample in samples] == [None] * 8
    samples = copter.hear_often(lambda number: raw_imu(8 + number), 5)
    assert [sample.mag is None for sample in samples] == [True] * 4 + [False]
    assert_milli(samples[4])
    (sample,) = copter.hear(raw_imu(13, mag=(0, 0, 0)))
    assert sample.mag is None


def test_a_field_that_sticks_while_the_vehicle_turns_is_no_field(vehicle):
    copter = vehicle(ARDUPILOT)
    turning = [copter.hear(raw_imu(number, gyro=(0, 0, 1500))) for number in range(60)]
    samples = [sample for heard in turning for sample in heard]
    stuck = [sample.t_ns for sample in samples if sample.mag is None]
    # 1 rad at 1.5 rad/s takes 0.67 s, 34 samples at 50 Hz.
    assert stuck[0] - samples[0].t_ns == pytest.approx(0.68e9, abs=0.03e9)
    assert len(stuck) == 60 - 34
    (sample,) = copter.hear(raw_imu(60, gyro=(0, 0, 1500), mag=(211, -40, 430)))
    assert sample.mag == pytest.approx((0.211, -0.040, 0.430))


def test_a_field_that_stays_the_same_at_rest_is_a_field(vehicle):
    samples = vehicle(ARDUPILOT).hear_often(lambda number: raw_imu(number, gyro=(1, 0, 0)), 300)
    assert all(sample.mag is not None for sample in samples)


@pytest.mark.parametrize("where", ["accel", "gyro"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_refused_and_forgotten(vehicle, where, value):
    px4 = vehicle(PX4)
    px4.hear_often(highres)
    assert px4.hear(highres(6, **{where: (1.0, value, -9.0)})) == []
    assert "not finite" in px4.decoder.refusals["HIGHRES_IMU"]
    assert len(px4.hear(highres(7))) == 1
    assert px4.decoder.refusals == {}
    assert px4.decoder.refused == {"HIGHRES_IMU": 1}


def test_a_field_that_is_not_finite_is_no_field(vehicle):
    px4 = vehicle(PX4)
    px4.hear_often(highres)
    (sample,) = px4.hear(highres(6, mag=(math.nan, 0.2, 0.3)))
    assert sample.mag is None


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("where", ["accel", "gyro"])
@pytest.mark.parametrize(("value", "expected"), [(32440, True), (-32440, True), (-32768, True), (32439, False)])
def test_saturation_is_99_percent_of_the_range(vehicle, where, axis, value, expected):
    copter = vehicle(ARDUPILOT)
    copter.hear_often(raw_imu)
    reading = [0, 0, -1000] if where == "accel" else [0, 0, 0]
    reading[axis] = value
    (sample,) = copter.hear(raw_imu(6, **{where: tuple(reading)}))
    assert sample.saturated is expected


def test_floats_do_not_saturate(vehicle):
    px4 = vehicle(PX4)
    px4.hear_often(highres)
    (sample,) = px4.hear(highres(6, accel=(0.0, 0.0, 40000.0)))
    assert sample.saturated is False


# --- magnitudes at the start ---------------------------------------------------------------------------------------


def test_an_accelerometer_in_the_wrong_unit_is_refused_with_message_value_and_expectation(vehicle):
    copter = vehicle(ARDUPILOT)
    assert copter.hear_often(lambda number: scaled(SCALED[1], number, accel=(0, 0, -9807)), 20) == []
    refusal = copter.decoder.refusals["SCALED_IMU2"]
    for part in ("SCALED_IMU2", "accelerometer reads 96.17", "4.9 to 19.6", "0.5 to 2 g"):
        assert part in refusal
    # The first readings are still held back: they will be given out if the next ones are plausible.
    assert copter.decoder.refused == {"SCALED_IMU2": 16}


@pytest.mark.parametrize(("milli_g", "passes"), [(499, False), (501, True), (1999, True), (2001, False)])
def test_the_limits_are_half_and_twice_gravity(vehicle, milli_g, passes):
    samples = vehicle(ARDUPILOT).hear_often(lambda number: raw_imu(number, accel=(0, 0, -milli_g)))
    assert bool(samples) is passes


@pytest.mark.parametrize(
    ("milli_gauss", "passes"), [(99, False), (101, True), (760, True), (2499, True), (2501, False)]
)
def test_the_limits_of_the_field(vehicle, milli_gauss, passes):
    copter = vehicle(ARDUPILOT)
    samples = copter.hear_often(lambda number: raw_imu(number, mag=(milli_gauss, 0, 0)))
    assert len(samples) == 5
    assert [sample.mag is not None for sample in samples] == [passes] * 5
    assert ("RAW_IMU magnetometer" in copter.decoder.refusals) is not passes


def test_one_shock_at_the_start_refuses_nothing(vehicle):
    copter = vehicle(ARDUPILOT)
    samples = copter.hear_often(lambda number: raw_imu(number, accel=(0, 0, -9000 if number == 1 else -1000)))
    assert len(samples) == 5
    assert copter.decoder.refusals == {}


def test_a_start_in_a_hard_manoeuvre_is_refused_until_it_is_over(vehicle):
    copter = vehicle(ARDUPILOT)
    assert copter.hear_often(lambda number: raw_imu(number, accel=(0, 0, -5000)), 50) == []
    assert "RAW_IMU" in copter.decoder.refusals
    samples = copter.hear_often(lambda number: raw_imu(50 + number), 5)
    assert samples
    assert copter.decoder.refusals == {}


def test_a_field_that_becomes_plausible_is_taken_from_then_on(vehicle):
    copter = vehicle(ARDUPILOT)
    samples = copter.hear_often(lambda number: raw_imu(number, mag=(4000, 0, number)), 10)
    assert [sample.mag for sample in samples] == [None] * 10
    samples = copter.hear_often(lambda number: raw_imu(10 + number, mag=(400, 0, number)), 5)
    assert samples[-1].mag == pytest.approx((0.4, 0.0, 0.004))
    assert copter.decoder.refusals == {}


def test_nothing_is_refused_for_magnitude_after_the_start(vehicle):
    copter = vehicle(ARDUPILOT)
    copter.hear_often(raw_imu)
    (sample,) = copter.hear(raw_imu(6, accel=(0, 0, -9000), mag=(2000, 0, 0)))
    assert sample.accel[2] == pytest.approx(-9 * G)
    assert sample.mag == pytest.approx((2.0, 0.0, 0.0))


def test_the_check_is_a_median_of_the_last_five():
    check = MagnitudeCheck(1.0, 2.0, (1.0, 0.001))
    for value in (9.0, 9.0, 1.5, 9.0):
        check.offer(value)
        assert (check.passed, check.failed) == (False, False)
    check.offer(1.5)
    assert (check.passed, check.failed, check.median) == (False, True, 9.0)
    check.offer(1.4)
    assert (check.passed, check.failed, check.factor) == (True, False, 1.0)


# --- lanes ---------------------------------------------------------------------------------------------------------


def test_sensors_of_one_message_are_sources_of_their_own(vehicle):
    copter = vehicle(ARDUPILOT)
    samples = [s for n in range(10) for s in copter.hear(raw_imu(n, sensor=n % 2))]
    assert sorted({sample.source for sample in samples}) == ["RAW_IMU", "RAW_IMU#1"]
    samples = [s for n in range(10) for s in copter.hear(highres(n, sensor=2 * (n % 2)))]
    assert sorted({sample.source for sample in samples}) == ["HIGHRES_IMU", "HIGHRES_IMU#2"]


def test_every_sensor_says_the_resolution_of_its_readings(vehicle):
    copter = vehicle(ARDUPILOT)
    for sample in (s for n in range(10) for s in copter.hear(raw_imu(n, sensor=n % 2))):
        assert (sample.quantum.gyro, sample.quantum.accel, sample.quantum.mag) == (1e-3, 1e-3 * G, 1e-3)
    for sample in (s for n in range(10) for s in copter.hear(highres(n, sensor=2 * (n % 2)))):
        assert (sample.quantum.gyro, sample.quantum.accel, sample.quantum.mag) == (0.0, 0.0, 0.0)


def test_each_system_has_its_own_units(dialect, sender, make_sender):
    both = Vehicle(dialect, sender, ARDUPILOT)
    px4 = make_sender(2, 1)
    both.hear(pymav.MAVLink_heartbeat_message(2, PX4, 0, 0, 4, 3), px4)
    for number in range(5):
        both.hear(raw_imu(number))
        assert both.hear(raw_imu(number), px4) == []
    (sample,) = both.hear(raw_imu(6))
    assert sample.system == 1


def test_nothing_is_decoded_before_the_autopilot_is_known(vehicle):
    unknown = vehicle(None)
    assert unknown.hear_often(raw_imu) == []
    assert "HEARTBEAT" in unknown.decoder.refusals["RAW_IMU"]
    unknown.hear(pymav.MAVLink_heartbeat_message(26, INVALID, 0, 0, 4, 3))
    assert unknown.hear_often(raw_imu) == []
    unknown.hear(pymav.MAVLink_heartbeat_message(2, ARDUPILOT, 0, 0, 4, 3))
    assert_milli(unknown.hear_often(raw_imu)[0])
    assert unknown.decoder.refusals == {}
    assert unknown.decoder.refused == {"RAW_IMU": 10}


def test_another_component_does_not_overrule_the_autopilot(dialect, sender, make_sender):
    companion = make_sender(1, 191)
    before = Vehicle(dialect, sender, None)
    before.hear(pymav.MAVLink_heartbeat_message(18, GENERIC, 0, 0, 4, 3), companion)
    assert before.decoder.autopilots == {1: GENERIC}
    before.hear(pymav.MAVLink_heartbeat_message(2, ARDUPILOT, 0, 0, 4, 3))
    before.hear(pymav.MAVLink_heartbeat_message(18, GENERIC, 0, 0, 4, 3), companion)
    assert before.decoder.autopilots == {1: ARDUPILOT}
    assert_milli(before.hear_often(raw_imu)[0])
