from math import cos, pi, sin, sqrt
from statistics import fmean, pstdev

import numpy as np
import pytest

from attest_mav.algebra import rotate_back
from attest_mav.sim.earth import Earth
from attest_mav.sim.scenarios import make_trajectory
from attest_mav.sim.sensors import (
    ACCEL_RANGE,
    GPS_DELAY_S,
    GYRO_RANGE,
    Gps,
    InertialUnit,
    Lowpass,
    Magnetometer,
    SensorSuite,
)
from attest_mav.sim.settings import PERFECT, SensorErrors

RATE_HZ = 400
FIELD = Earth().field_ned()


def response(lowpass, frequency_hz, rate_hz):
    """Gain and delay (s) of a filter for a sine, by correlation over whole periods after settling."""
    omega = 2.0 * pi * frequency_hz / rate_hz
    period = round(rate_hz / frequency_hz)
    in_phase = quadrature = 0.0
    for k in range(20 * period):
        y = lowpass.step((sin(omega * k), 0.0, 0.0))[0]
        if k >= 10 * period:
            in_phase += y * sin(omega * k)
            quadrature += y * cos(omega * k)
    in_phase, quadrature = in_phase / (5 * period), quadrature / (5 * period)
    return sqrt(in_phase**2 + quadrature**2), np.arctan2(-quadrature, in_phase) / (2.0 * pi * frequency_hz)


@pytest.mark.parametrize("rate_hz", [400, 1000])
def test_the_lowpass_delays_slow_motion_by_11_25_ms(rate_hz):
    gain, delay_s = response(Lowpass(rate_hz, 20.0), 1.0, rate_hz)
    assert gain == pytest.approx(1.0, abs=1e-3)
    # sqrt(2) / (2 pi 20 Hz); the bilinear transform takes 0.08 ms off at 400 Hz, 0.01 ms at 1000 Hz.
    assert delay_s == pytest.approx(0.01125, abs=1e-4)


def test_the_lowpass_is_a_second_order_butterworth():
    assert response(Lowpass(RATE_HZ, 20.0), 20.0, RATE_HZ)[0] == pytest.approx(sqrt(0.5), abs=1e-6)
    # Two octaves up: 12 dB an octave, prewarped by the bilinear transform.
    warped = np.tan(pi * 80.0 / RATE_HZ) / np.tan(pi * 20.0 / RATE_HZ)
    assert response(Lowpass(RATE_HZ, 20.0), 80.0, RATE_HZ)[0] == pytest.approx(1.0 / sqrt(1.0 + warped**4), abs=1e-6)


def test_the_lowpass_starts_settled():
    lowpass = Lowpass(RATE_HZ, 20.0)
    for _ in range(3):
        assert lowpass.step((0.0, 2.0, -9.8)) == pytest.approx((0.0, 2.0, -9.8))


def test_a_perfect_unit_without_filter_reads_the_truth():
    unit = InertialUnit(PERFECT, RATE_HZ, None, "x")
    unit.update((0.1, -0.2, 0.3), (1.0, -2.0, -9.0))
    assert unit.gyro.reading == (0.1, -0.2, 0.3)
    assert unit.accel.reading == (1.0, -2.0, -9.0)


def test_noise_has_the_stated_density():
    errors = SensorErrors(2e-4, 0.0, 0.0, 3e-3, 0.0, 0.0)
    unit = InertialUnit(errors, RATE_HZ, None, "noise")
    gyro, accel = [], []
    for _ in range(4000):
        unit.update((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        gyro += unit.gyro.reading
        accel += unit.accel.reading
    # Deviations of 12000 numbers are good to 0.7 %.
    assert pstdev(gyro) == pytest.approx(2e-4 * sqrt(RATE_HZ), rel=0.03)
    assert pstdev(accel) == pytest.approx(3e-3 * sqrt(RATE_HZ), rel=0.03)
    assert abs(fmean(gyro)) < 5.0 * pstdev(gyro) / sqrt(len(gyro))


def test_biases_are_drawn_once_and_for_each_axis():
    errors = SensorErrors(0.0, 0.01, 0.0, 0.0, 0.1, 0.0)
    biases = []
    for seed in range(300):
        unit = InertialUnit(errors, RATE_HZ, None, f"bias {seed}")
        unit.update((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        first = unit.gyro.reading
        for _ in range(100):
            unit.update((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        assert unit.gyro.reading == first
        biases += first
    assert pstdev(biases) == pytest.approx(0.01, rel=0.1)


def test_drift_is_a_random_walk_of_the_stated_deviation():
    errors = SensorErrors(0.0, 0.0, 1e-3, 0.0, 0.0, 0.0)
    after = {4: [], 16: []}
    for seed in range(150):
        unit = InertialUnit(errors, 50, None, f"drift {seed}")
        for tick in range(16 * 50):
            unit.update((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
            if (tick + 1) in {200, 800}:
                after[(tick + 1) // 50] += unit.gyro.reading
    assert pstdev(after[4]) == pytest.approx(2e-3, rel=0.12)
    assert pstdev(after[16]) == pytest.approx(4e-3, rel=0.12)


def test_readings_stop_at_the_end_of_the_range():
    unit = InertialUnit(PERFECT, RATE_HZ, None, "x")
    unit.update((1e3, -1e3, 1.0), (-1e4, 1e4, -9.0))
    assert unit.gyro.reading == (GYRO_RANGE, -GYRO_RANGE, 1.0)
    assert unit.accel.reading == (-ACCEL_RANGE, ACCEL_RANGE, -9.0)


def test_the_default_field_is_that_of_the_home_near_canberra():
    assert pytest.approx((0.2301, 0.0517, -0.5310), abs=2e-4) == FIELD


def test_the_magnetometer_holds_the_mean_of_the_last_tenth_of_a_second():
    trajectory = make_trajectory("tumbling", 1)
    mag = Magnetometer(PERFECT, FIELD, 100_000_000, 10, "m")
    seen = []
    for tick in range(400 * 20):
        t_ns = tick * 2_500_000
        mag.update(t_ns, trajectory.at(t_ns * 1e-9).q_nb)
        if tick % 8 == 0 and (not seen or mag.count != seen[-1][0]):
            seen.append((mag.count, t_ns * 1e-9, mag.held))
    assert seen[0][2] == (0.0, 0.0, 0.0)  # before the first mean
    assert len(seen) == 1 + 199

    def residual(lag_s):
        """RMS difference to the field lag_s before a 50 Hz stream first showed the value."""
        differences = [
            np.subtract(held, rotate_back(trajectory.at(t - lag_s).q_nb, FIELD)) for _, t, held in seen if t > 8.0
        ]
        return float(np.sqrt(np.mean(np.square(differences))))

    lags_ms = range(120)
    best_ms = min(lags_ms, key=lambda lag_ms: residual(lag_ms * 1e-3))
    assert 55 <= best_ms <= 60  # ArduPilot in its simulator: 56 to 60 ms
    assert residual(best_ms * 1e-3) < 0.02 * residual(0.0) + 1e-3


def test_a_magnetometer_of_one_reading_a_value_is_hardly_late():
    trajectory = make_trajectory("tumbling", 1)
    mag = Magnetometer(PERFECT, FIELD, 20_000_000, 1, "m")
    for tick in range(12_000):
        before = mag.count
        mag.update(tick * 1_000_000, trajectory.at(tick * 1e-3).q_nb)
        if mag.count != before:
            assert mag.held == pytest.approx(rotate_back(trajectory.at(tick * 1e-3).q_nb, FIELD), abs=1e-12)
    assert mag.count == 598


def test_gps_tells_of_a_tenth_of_a_second_before_its_time():
    trajectory = make_trajectory("coordinated-turns", 1)
    gps = Gps(trajectory, 3.0, 1)
    late, now = [], []
    for tick in range(400 * 60):
        before = gps.fix_ns
        gps.update(tick * 2_500_000)
        if gps.fix_ns != before and tick > 400 * 26:
            t = gps.fix_ns * 1e-9
            late.append(np.subtract(gps.velocity, trajectory.at(t - GPS_DELAY_S).v_ned))
            now.append(np.subtract(gps.velocity, trajectory.at(t).v_ned))
    assert len(late) == pytest.approx(170, abs=1)  # five a second
    assert np.std(late) == pytest.approx(0.04, rel=0.15)
    assert np.std(now) > 5.0 * np.std(late)


def test_sensors_draw_from_generators_of_their_own():
    trajectory = make_trajectory("still", 1)

    def suite(mag_noise):
        errors = SensorErrors(mag_noise=mag_noise)
        sensors = SensorSuite(trajectory, errors, FIELD, RATE_HZ, 20.0, 100_000_000, 10, 3.0, 5)
        for tick in range(200):
            sensors.update(tick * 2_500_000, trajectory.at(0.0), saturated=False)
        return sensors

    one, other = suite(0.0), suite(0.1)
    assert one.mags[0].held != other.mags[0].held
    assert one.imus[0].gyro.reading == other.imus[0].gyro.reading
    assert one.imus[0].gyro.reading != one.imus[1].gyro.reading
