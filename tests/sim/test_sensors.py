import numpy as np
import pytest

from attest_mav.algebra import rotate_back
from attest_mav.sim.earth import Earth
from attest_mav.sim.faults import FaultSchedule
from attest_mav.sim.personality import ARDUPILOT
from attest_mav.sim.scenarios import make_trajectory
from attest_mav.sim.sensors import Magnetometer, SensorSuite
from attest_mav.sim.settings import PERFECT, SensorErrors, SimSettings

FIELD = Earth().field_ned()


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


def test_sensors_draw_from_generators_of_their_own():
    trajectory = make_trajectory("still", 1)

    def suite(mag_noise):
        settings = SimSettings(errors=SensorErrors(mag_noise=mag_noise))
        sensors = SensorSuite(settings, ARDUPILOT, trajectory, FaultSchedule(()), 400, 5)
        for tick in range(200):
            sensors.update(tick * 2_500_000, trajectory.at(0.0))
        return sensors

    one, other = suite(0.0), suite(0.1)
    assert one.mags[0].held != other.mags[0].held
    assert one.imus[0].gyro.reading == other.imus[0].gyro.reading
    assert one.imus[0].gyro.reading != one.imus[1].gyro.reading
