"""A motion that is known exactly, and the readings that perfect sensors have of it."""

from types import SimpleNamespace

import numpy as np
import pytest

from attest_mav.types import G_MPS2

FIELD = np.array([0.2, 0.0, 0.45])  # north and down: magnetic north is true north


def products(q, r):
    """Hamilton products by the rule for scalar and vector parts."""
    scalar = q[:, 0] * r[:, 0] - (q[:, 1:] * r[:, 1:]).sum(axis=1)
    vector = q[:, :1] * r[:, 1:] + r[:, :1] * q[:, 1:] + np.cross(q[:, 1:], r[:, 1:])
    return np.column_stack((scalar, vector))


def into_body(q, v):
    """Vectors in NED as the body sees them."""
    inverse = q * [1.0, -1.0, -1.0, -1.0]
    flat = np.column_stack((np.zeros(len(q)), np.broadcast_to(v, (len(q), 3))))
    return products(products(inverse, flat), q)[:, 1:]


@pytest.fixture(scope="session")
def flown():
    """40 s at 50 Hz: a vehicle that circles, sways in roll and pitch, and is never still."""
    t = np.arange(0.0, 40.0, 0.02)
    zero = np.zeros_like(t)
    roll, pitch, yaw = 0.3 * np.sin(0.9 * t), 0.2 * np.sin(0.7 * t + 1.0), 0.4 * t
    about = [
        np.column_stack((np.cos(yaw / 2), zero, zero, np.sin(yaw / 2))),
        np.column_stack((np.cos(pitch / 2), zero, np.sin(pitch / 2), zero)),
        np.column_stack((np.cos(roll / 2), np.sin(roll / 2), zero, zero)),
    ]
    q = products(products(about[0], about[1]), about[2])
    roll_rate, pitch_rate = 0.27 * np.cos(0.9 * t), 0.14 * np.cos(0.7 * t + 1.0)
    gyro = np.column_stack(
        (
            roll_rate - 0.4 * np.sin(pitch),
            pitch_rate * np.cos(roll) + 0.4 * np.sin(roll) * np.cos(pitch),
            0.4 * np.cos(roll) * np.cos(pitch) - pitch_rate * np.sin(roll),
        )
    )
    velocity = np.column_stack((8.0 * np.sin(0.5 * t), 6.0 * np.cos(0.3 * t), 1.0 * np.sin(0.8 * t)))
    acceleration = np.column_stack((4.0 * np.cos(0.5 * t), -1.8 * np.sin(0.3 * t), 0.8 * np.cos(0.8 * t)))
    accel = into_body(q, acceleration - [0.0, 0.0, G_MPS2])
    fixes = np.full_like(velocity, np.nan)
    fixes[::10] = velocity[::10]
    return SimpleNamespace(t=t, q=q, gyro=gyro, accel=accel, mag=into_body(q, FIELD), velocity=fixes)
