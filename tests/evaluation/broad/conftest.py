"""Small trials in the format of BROAD, with perfect sensors on a motion that is known."""

from math import sin

import h5py
import numpy as np
import pytest
from scipy.io import savemat

RATE_HZ = 50.0
FIELD_ENU = (0.0, 20.0, -45.0)
FORCE_ENU = (0.0, 0.0, 9.80665)


def product(a, b):
    w, v = a[0] * b[0] - a[1:] @ b[1:], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.array([w, *v])


def matrix(q):
    """Columns: the sensor's axes in the world."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def about(axis, angle):
    """Rotation by an angle (rad) about an axis."""
    axis = np.array(axis) / np.linalg.norm(axis)
    return np.array([np.cos(0.5 * angle), *(np.sin(0.5 * angle) * axis)])


def fields(seconds=20.0, first=(0.9, 0.1, -0.2, 0.3)):
    """Two seconds of rest, then rotations about changing axes, about 1 rad/s."""
    q = np.array(first) / np.linalg.norm(first)
    columns = {name: [] for name in ("imu_gyr", "imu_acc", "imu_mag", "opt_quat", "movement")}
    for k in range(round(seconds * RATE_HZ)):
        t = k / RATE_HZ - 2.0
        rate = np.array([sin(1.3 * t), 0.8 * sin(0.7 * t), 0.6 * sin(0.4 * t)]) if t > 0.0 else np.zeros(3)
        angle = np.linalg.norm(rate) / RATE_HZ
        q = product(q, about(rate, angle)) if angle > 0.0 else q
        to_sensor = matrix(q).T
        readings = (rate, to_sensor @ FORCE_ENU, to_sensor @ FIELD_ENU, q, t > 0.0)
        for column, value in zip(columns.values(), readings, strict=True):
            column.append(value)
    return {name: np.array(column) for name, column in columns.items()}


def write_hdf5(path, content):
    with h5py.File(path, "w") as file:
        for name, column in content.items():
            file[name] = column
        file.attrs["sampling_rate"] = RATE_HZ


def write_mat(path, content):
    column = content["movement"].astype(np.uint8)[:, None]
    savemat(path, {**content, "movement": column, "sampling_rate": RATE_HZ, "info": "synthetic"}, do_compression=True)


@pytest.fixture
def multiply():
    """Hamilton product of two quaternions."""
    return product


@pytest.fixture
def turn():
    """Quaternion of a rotation by an angle (rad) about an axis."""
    return about


@pytest.fixture
def trial_fields():
    """The fields of a trial, ``movement`` in booleans: the true motion and what perfect sensors read."""
    return fields


@pytest.fixture
def write_trial():
    """Writes fields to a path in the format of its ending."""

    def write(path, content):
        (write_hdf5 if path.suffix == ".hdf5" else write_mat)(path, content)

    return write
