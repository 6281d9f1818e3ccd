from math import cos, pi, sin, sqrt
from statistics import fmean, pstdev

import numpy as np
import pytest

from attest_mav.sim.inertial import ACCEL_RANGE, GYRO_RANGE, InertialUnit, Lowpass
from attest_mav.sim.settings import PERFECT, SensorErrors

RATE_HZ = 400


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
