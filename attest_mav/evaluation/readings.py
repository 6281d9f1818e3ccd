"""Simulated readings as the samples that filters take."""

from attest_mav.evaluation.motion import Array
from attest_mav.samples import ImuSample
from attest_mav.types import Vec3


def samples_of(gyro: Array, accel: Array, mag: Array | None, dt_s: float) -> list[ImuSample]:
    """One sample a row, dt_s apart, the first at dt_s. Shapes (n, 3); rad/s, m/s^2, any linear unit; body."""
    step_ns = round(dt_s * 1e9)
    fields = [None] * len(gyro) if mag is None else [_vector(row) for row in mag.tolist()]
    return [
        ImuSample("SIMULATED", 1, 1, k * step_ns, k * step_ns, _vector(rate), _vector(force), field)
        for k, (rate, force, field) in enumerate(zip(gyro.tolist(), accel.tolist(), fields, strict=True), 1)
    ]


def _vector(row: list[float]) -> Vec3:
    return (row[0], row[1], row[2])
