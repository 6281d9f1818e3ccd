"""What faults do to the autopilot's attitude. Limits are those of ArduPilot's EKF3 in its own simulator, flown."""

from math import degrees, inf

import pytest

from attest_mav.algebra import heading_between, q_from_euler, tilt_between
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings

S = 1_000_000_000
START_S = 20.0


class Flown:
    """A flight and the errors of its reported attitude."""

    def __init__(self, decode, *faults, until_s=40.0, **choices):
        usual = {"scenario": "square", "fast_rate_hz": 50.0, "attitude_error": (0.0, 0.0, 0.0)}
        self.vehicle = FakeAutopilot(SimSettings(**(usual | choices), faults=parse_faults(faults)), 1)
        self.messages = decode(self.vehicle.frames_until(round(until_s * S)))
        self.errors = [self._error(attitude) for attitude in self.messages["ATTITUDE"]]

    def _error(self, attitude):
        """(time since the fault in s, tilt error in degrees, heading error in degrees)."""
        truth = self.vehicle.truth(attitude.time_boot_ms * 1_000_000).q_nb
        reported = q_from_euler(attitude.roll, attitude.pitch, attitude.yaw)
        tilt, heading = tilt_between(reported, truth), heading_between(reported, truth)
        return attitude.time_boot_ms * 1e-3 - START_S, degrees(tilt), abs(degrees(heading))

    def worst(self, from_s=-inf, to_s=inf):
        """The largest tilt and heading errors, degrees, of a span since the fault."""
        span = [error for error in self.errors if from_s <= error[0] < to_s]
        return max(tilt for _, tilt, _ in span), max(heading for _, _, heading in span)

    def texts(self):
        """What the autopilot has said."""
        return [message.text for message in self.messages.get("STATUSTEXT", [])]


SWITCHED = ["EKF3 lane switch 1", "EKF primary changed:1"]


def test_a_large_gyro_bias_moves_the_attitude_until_the_lane_switch(decode):
    flown = Flown(decode, "gyro1-bias-x=5@20+15")
    assert flown.worst(to_s=0.0)[0] < 0.01
    assert 2.0 < flown.worst(0.4, 0.52)[0] < 2.5  # at first it follows the bias
    assert 9.0 < flown.worst(0.0, 3.2)[0] < 12.0
    assert flown.worst(3.2)[0] < 0.1
    assert flown.texts() == SWITCHED


@pytest.mark.parametrize("scenario", ["hover", "coordinated-turns"])
def test_the_lane_switch_comes_after_three_seconds(decode, scenario):
    flown = Flown(decode, "gyro1-bias-y=-5@20+15", scenario=scenario)
    (gone_s,) = (
        after
        for (after, tilt, _), (_, before, _) in zip(flown.errors[1:], flown.errors, strict=False)
        if tilt < before - 5
    )
    assert gone_s == pytest.approx(3.0, abs=0.1)
    assert flown.texts() == SWITCHED


def test_a_small_gyro_bias_is_learned_without_a_lane_switch(decode):
    flown = Flown(decode, "gyro1-bias-x=1@20+20", until_s=80.0)
    assert 2.2 < flown.worst(0.0, 20.0)[0] < 2.9
    assert flown.worst(50.0)[0] < 0.5
    assert flown.texts() == []


def test_the_sensor_that_is_not_selected_moves_nothing(decode):
    flown = Flown(decode, "gyro2-bias-x=5@20", "accel2-stuck=5@20")
    assert max(flown.worst()) < 0.01
    assert flown.texts() == []


def test_with_both_sensors_wrong_there_is_nothing_to_switch_to(decode):
    flown = Flown(decode, "gyro-bias-x=3@20+15")
    assert 7.0 < flown.worst()[0] < 9.5
    assert flown.texts() == []


def test_it_switches_back_when_the_other_sensor_fails(decode):
    flown = Flown(decode, "gyro1-bias-x=5@20+5", "gyro2-bias-x=5@40+5", until_s=60.0)
    assert flown.texts() == [*SWITCHED, "EKF3 lane switch 0", "EKF primary changed:0"]


@pytest.mark.parametrize("fault", ["accel1-stuck=5", "accel1-stop", "gyro1-stop"])
def test_a_sensor_that_is_plainly_broken_is_left_at_once(decode, fault):
    flown = Flown(decode, f"{fault}@20+15", scenario="hover")
    assert flown.worst()[0] < 1.0
    assert flown.texts() == SWITCHED


def test_a_frozen_gyro_is_left_when_the_attitude_shows_it(decode):
    flown = Flown(decode, "gyro1-freeze@20+10", scenario="tumbling")
    assert flown.worst(0.0, 3.5)[0] > 10.0
    assert flown.worst(3.5)[0] < 0.1
    assert flown.texts() == SWITCHED


def test_a_bias_of_the_accelerometer_tilts_a_little(decode):
    flown = Flown(decode, "accel-bias-x=1@20+20", until_s=70.0)
    assert 0.2 < flown.worst()[0] < 2.4
    assert flown.worst(45.0)[0] < 0.2
    assert flown.texts() == []


def test_a_compass_turns_the_heading_a_little_or_is_rejected(decode):
    tilt, heading = Flown(decode, "compass-x=100@20+20", scenario="still").worst()
    assert 2.0 < heading < 7.0
    assert tilt < 0.2
    assert Flown(decode, "compass-x=-500@20+20", scenario="still").worst()[1] < 0.1


def test_without_a_receiver_the_attitude_drifts_after_a_while_and_comes_back(decode):
    flown = Flown(decode, "receiver-off@20+60", until_s=110.0)
    assert flown.worst(0.0, 14.0)[0] < 0.01
    assert 3.0 < flown.worst(28.0, 32.0)[0] < 5.0
    assert 3.0 < flown.worst()[0] < 5.3
    assert 2.0 < flown.worst()[1] < 6.0
    assert flown.worst(85.0)[0] < 0.5


def test_before_the_first_fix_nothing_is_missed(decode):
    flown = Flown(decode, first_fix_s=1e6, until_s=60.0)
    assert max(flown.worst()) < 0.01


@pytest.mark.parametrize(
    ("fault", "low", "high"),
    [
        ("receiver-noise=5", 0.05, 1.5),
        ("receiver-offset-north=5", 0.5, 3.2),
        ("receiver-ramp-east=0.5", 0.5, 3.5),
        ("receiver-late=0.5", 0.1, 2.0),
        ("receiver-frozen", 0.5, 4.0),
        ("vibration=20", 0.0, 0.2),
    ],
)
def test_other_faults_move_little(decode, fault, low, high):
    flown = Flown(decode, f"{fault}@20+15", until_s=60.0)
    assert low <= flown.worst()[0] < high
    assert flown.worst(35.0)[0] < 0.6
    assert flown.texts() == []


def test_the_reported_rates_have_the_bias_too(decode):
    flown = Flown(decode, "gyro1-bias-x=5@20+15", scenario="still")
    rates = {m.time_boot_ms: m.rollspeed for m in flown.messages["ATTITUDE"]}
    assert rates[19_980] == 0.0
    assert rates[20_020] == pytest.approx(0.0873, abs=0.002)
    assert rates[24_000] == 0.0


def test_highres_imu_is_that_of_the_selected_sensor_and_px4_says_nothing(decode):
    flown = Flown(decode, "accel1-stuck=5@20+15", personality="px4", scenario="still")
    force = {round(m.time_usec * 1e-6 - START_S, 2): m.zacc for m in flown.messages["HIGHRES_IMU"]}
    assert force[0.1] > 0.0
    assert force[1.0] < -9.0
    assert flown.texts() == []
    first, second = flown.messages["SCALED_IMU"][-300], flown.messages["SCALED_IMU2"][-300]
    assert (first.zacc, second.zacc) == (509, pytest.approx(-999, abs=10))


def test_a_restart_selects_the_first_lane_again(decode):
    flown = Flown(decode, "gyro1-stop@20+1", "reboot@25", "gyro1-stop@30+1")
    assert flown.texts() == SWITCHED * 2


def test_the_other_attitude_errors_come_on_top(decode):
    flown = Flown(decode, "gyro1-stop@20", "attitude-offset-north=10@22", scenario="still")
    assert flown.worst(2.0)[0] == pytest.approx(10.0, abs=0.05)
    assert flown.worst(to_s=2.0)[0] < 0.3
