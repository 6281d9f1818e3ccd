"""Two filters over arrays: a turn that only one of them takes for a turn.

.venv/bin/python examples/two_filters.py
"""

import numpy as np

from attest_mav import BARE_SENSOR, GradientDescent, VelocityAided, run

t = np.arange(3000) / 50.0  # s: a minute at 50 Hz
bank = np.radians(40.0) * np.clip((t - 20.0) / 2.0, 0.0, 1.0)  # straight, then a banked turn at 60 m/s
turn = 9.80665 * np.tan(bank) / 60.0  # rad/s about the vertical
yaw = np.cumsum(turn) / 50.0
zero = np.zeros_like(t)
gyro = np.column_stack((np.gradient(bank, t), turn * np.sin(bank), turn * np.cos(bank)))  # rad/s; forward, right, down
accel = np.column_stack((zero, zero, -9.80665 / np.cos(bank)))  # specific force, m/s^2
velocity = 60.0 * np.column_stack((np.cos(yaw), np.sin(yaw), zero))  # over ground, m/s; north, east, down
for one in (GradientDescent(), VelocityAided(BARE_SENSOR)):
    solution = run(one, t, gyro, accel, velocity=velocity)
    print(f"{one.name}: roll {np.degrees(solution.euler[-1, 0]):.1f} of 40.0 degrees")
