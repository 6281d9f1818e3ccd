"""Edits of whole blocks of the covariance, by the name of the error: for starts, resets, and hypotheses.

Those that are no part of a usual step work on the list of blocks, and no other module has to name the blocks.
"""

from enum import IntEnum
from typing import Final

from attest_mav.filters.velocity_aided.covariance import Covariance
from attest_mav.matrices import diagonal, floor_diagonal, mat_add, mat_mul, mat_mul_t, transpose
from attest_mav.types import Mat3, Vec3

COUNT: Final = 8
"""Number of error vectors."""


class ErrorBlock(IntEnum):
    """The vectors of the error state, in the order of the covariance."""

    ATTITUDE = 0
    """Rotation in NED, rad."""
    VELOCITY = 1
    """NED, m/s."""
    GYRO_BIAS = 2
    """Body, rad/s."""
    GYRO_SCALE = 3
    """Per axis of the body, 1."""
    ACCEL_BIAS = 4
    """Body, m/s^2."""
    HARD_IRON = 5
    """Body, gauss."""
    DELAYS = 6
    """Lag of the magnetometer (s), lag of the velocity fixes (s), declination error (rad)."""
    GYRO_DRIFT = 7
    """Drift rate of the gyro bias, body, rad/s^2."""


MAG_LAG: Final = 0
"""Component of ``ErrorBlock.DELAYS``."""
FIX_LAG: Final = 1
"""Component of ``ErrorBlock.DELAYS``."""
DECLINATION: Final = 2
"""Component of ``ErrorBlock.DELAYS``."""


def diagonal_covariance(diagonals: list[Mat3]) -> Covariance:
    """The covariance of errors that are independent of each other; one block for each ``ErrorBlock``, in its order."""
    blocks: list[Mat3] = []
    for i in range(COUNT):
        blocks.append(diagonals[i])
        blocks += [diagonal(0.0)] * (COUNT - 1 - i)
    return Covariance(*blocks)


def with_added_variance(p: Covariance, error: ErrorBlock, variance: Vec3) -> Covariance:
    """P with variances added to one error, per axis and in its unit squared; correlations stay."""
    blocks = p.blocks()
    place = _place(error, error)
    blocks[place] = mat_add(blocks[place], _diagonal(variance))
    return Covariance(*blocks)


def with_gyro_bias_floor(p: Covariance, least: float) -> Covariance:
    """P with no variance of the gyro bias below ``least``, (rad/s)^2; written out, since rest asks it all the time.

    A bias that hides within ``least`` may drift unseen: its drift rate becomes independent of all other errors.
    """
    none = diagonal(0.0)
    return Covariance(
        p.tt, p.tv, p.tb, p.ts, p.ta, p.tm, p.td, none,
        p.vv, p.vb, p.vs, p.va, p.vm, p.vd, none,
        floor_diagonal(p.bb, least), p.bs, p.ba, p.bm, p.bd, none,
        p.ss, p.sa, p.sm, p.sd, none,
        p.aa, p.am, p.ad, none,
        p.mm, p.md, none,
        p.dd, none,
        p.rr,
    )  # fmt: skip


def decoupled(p: Covariance, error: ErrorBlock, own: Mat3) -> Covariance:
    """P with one error independent of all others; ``own``: its own block."""
    blocks = p.blocks()
    for other in range(COUNT):
        blocks[_place(error, other)] = diagonal(0.0)
    blocks[_place(error, error)] = own
    return Covariance(*blocks)


def with_component_restarted(p: Covariance, error: ErrorBlock, axis: int, variance: float) -> Covariance:
    """P with one component of an error independent of everything else, and of this variance."""
    blocks = p.blocks()
    for other in range(COUNT):
        place = _place(error, other)
        is_row = other >= error
        block = blocks[place] if is_row else transpose(blocks[place])
        block = _without_row(block, axis)
        if other == error:
            block = transpose(_without_row(transpose(block), axis))
            own: Vec3 = (variance if axis == 0 else 0.0, variance if axis == 1 else 0.0, variance if axis == 2 else 0.0)
            block = mat_add(block, _diagonal(own))
        blocks[place] = block if is_row else transpose(block)
    return Covariance(*blocks)


def turned(p: Covariance, turn: Mat3) -> Covariance:
    """P after the attitude and the velocity have been turned in NED, and with them their errors."""
    blocks = p.blocks()
    for row in (ErrorBlock.ATTITUDE, ErrorBlock.VELOCITY):
        for column in range(row, COUNT):
            place = _place(row, column)
            block = mat_mul(turn, blocks[place])
            blocks[place] = mat_mul_t(block, turn) if column <= ErrorBlock.VELOCITY else block
    return Covariance(*blocks)


def _place(a: int, b: int) -> int:
    """Index of the block of two errors in the list of upper blocks."""
    row, column = (a, b) if a <= b else (b, a)
    return row * COUNT - row * (row - 1) // 2 + column - row


def _diagonal(v: Vec3) -> Mat3:
    """The diagonal matrix of v."""
    return ((v[0], 0.0, 0.0), (0.0, v[1], 0.0), (0.0, 0.0, v[2]))


def _without_row(m: Mat3, row: int) -> Mat3:
    """m with one row zero."""
    zero: Vec3 = (0.0, 0.0, 0.0)
    return (zero if row == 0 else m[0], zero if row == 1 else m[1], zero if row == 2 else m[2])
