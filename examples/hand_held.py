"""A sensor in the hand: three filters over the same readings, beside imufusion and VQF where they are installed.

    .venv/bin/python examples/hand_held.py [PICTURE.png]

The readings are simulated with the noise and bias of a cheap sensor, so that the true attitude is known. The error is
the angle between the true vertical and the filter's.
"""

import sys
from importlib.util import find_spec
from typing import Final

import numpy as np
import numpy.typing as npt

from attest_mav import BARE_SENSOR, GradientDescent, Readings, RobustAdaptive, VelocityAided, run_readings

Array = npt.NDArray[np.float64]

RATE_HZ: Final = 100.0
G: Final = 9.80665


def rotated(q: Array, v: tuple[float, float, float]) -> Array:
    """A world vector in the body of each attitude, shape (n, 3)."""
    w, x, y, z = q.T
    rows = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
            [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
            [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    found: Array = np.einsum("ijn,j->ni", rows, np.array(v))
    return found


def in_the_hand(seconds: float) -> tuple[Readings, Array]:
    """Readings, axes forward, right, down, and the true attitudes, shape (n, 4)."""
    t = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    still = np.clip((t - 5.0) / 2.0, 0.0, 1.0)  # five seconds of rest, in which biases are learned
    rates = still[:, None] * np.column_stack((1.5 * np.sin(1.1 * t), 1.2 * np.cos(0.8 * t), 0.8 * np.sin(0.5 * t)))
    q = np.empty((len(t), 4))
    q[0] = (1.0, 0.0, 0.0, 0.0)
    for k in range(1, len(t)):
        half = 0.5 * rates[k] / RATE_HZ
        size = float(np.linalg.norm(half))
        c, s = np.cos(size), np.sinc(size / np.pi)
        w, x, y, z = q[k - 1]
        a, b, d = s * half
        q[k] = (
            w * c - x * a - y * b - z * d,
            w * a + x * c + y * d - z * b,
            w * b - x * d + y * c + z * a,
            w * d + x * b - y * a + z * c,
        )
    rng = np.random.default_rng(7)
    gyro = rates + np.radians((0.4, -0.3, 0.5)) + rng.normal(0.0, 0.005, rates.shape)
    shaken = still[:, None] * np.column_stack((2.0 * np.sin(3.0 * t), np.cos(2.3 * t), np.sin(4.1 * t)))
    accel = rotated(q, (0.0, 0.0, -G)) + shaken + rng.normal(0.0, 0.03, rates.shape)
    mag = rotated(q, (0.2, 0.0, 0.44)) + rng.normal(0.0, 0.003, rates.shape)
    return Readings(t, gyro, accel, mag), q


def tilt_errors(attitudes: Array, truth: Array) -> Array:
    """Degrees, one a row."""
    down, true_down = rotated(attitudes, (0.0, 0.0, 1.0)), rotated(truth, (0.0, 0.0, 1.0))
    found: Array = np.degrees(np.arccos(np.clip(np.sum(down * true_down, axis=1), -1.0, 1.0)))
    return found


def peers(readings: Readings) -> dict[str, Array]:
    """Attitudes of other people's filters, FRD to NED. Both take axes that are forward, left, up."""
    flip = np.array([1.0, -1.0, -1.0])
    turn = np.array([1.0, 1.0, -1.0, -1.0])
    gyro, accel = readings.gyro * flip, readings.accel * flip
    mag = np.zeros_like(gyro) if readings.mag is None else readings.mag * flip
    found: dict[str, Array] = {}
    if find_spec("vqf") is not None:
        from vqf import VQF  # noqa: PLC0415 - not always installed

        found["VQF"] = VQF(1.0 / RATE_HZ).updateBatch(gyro, accel, mag)["quat9D"] * turn
    if find_spec("imufusion") is not None:
        import imufusion  # noqa: PLC0415 - not always installed

        ahrs = imufusion.Ahrs()
        rows = np.empty((len(gyro), 4))
        for k in range(len(gyro)):
            ahrs.update(np.degrees(gyro[k]), accel[k] / G, mag[k])
            rows[k] = ahrs.get_quaternion()
        found["imufusion"] = rows * turn
    return found


def main(picture: str | None) -> None:
    """Print the errors after the first ten seconds, and draw them."""
    readings, truth = in_the_hand(60.0)
    filters = (
        GradientDescent(beta=0.02, rest_bias=True, accel_time_s=2.5),
        RobustAdaptive(),
        VelocityAided(BARE_SENSOR),
    )
    attitudes = {one.name: run_readings(one, readings).attitudes for one in filters} | peers(readings)
    errors = {name: tilt_errors(rows, truth) for name, rows in attitudes.items()}
    late = readings.t > 10.0
    for name, column in errors.items():
        print(f"{name:<18} tilt error: rms {np.sqrt(np.mean(column[late] ** 2)):5.2f} degrees")
    if picture is not None:
        import matplotlib.pyplot as plt  # noqa: PLC0415 - only for a picture

        figure, axes = plt.subplots(figsize=(8, 4))
        for name, column in errors.items():
            axes.plot(readings.t, column, label=name, linewidth=0.8)
        axes.set(xlabel="time, s", ylabel="tilt error, degrees", ylim=(0, 10))
        axes.legend()
        figure.savefig(picture, dpi=120)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else None)
