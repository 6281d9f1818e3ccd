from collections import deque
from random import Random

import pytest

from attest_mav.ring_buffer import RingBuffer


@pytest.mark.parametrize("seed", range(5))
def test_a_ring_buffer_holds_what_a_deque_holds(seed):
    rng, ring, expected = Random(seed), RingBuffer(), deque()
    for value in range(2000):
        # Grows for a while, then shrinks, so that the slots are doubled with the oldest value anywhere in them.
        if expected and rng.random() < (0.3 if value % 400 < 200 else 0.7):
            assert ring.pop_oldest() == expected.popleft()
        else:
            ring.append(value)
            expected.append(value)
        if value % 999 == 998:
            ring.clear()
            expected.clear()
        assert [ring.at(index) for index in range(ring.count)] == list(expected)
        if expected:
            assert (ring.oldest, ring.newest) == (expected[0], expected[-1])


def test_a_value_that_has_left_is_not_kept_alive():
    class Value:
        alive = 0

        def __init__(self):
            Value.alive += 1

        def __del__(self):
            Value.alive -= 1

    ring = RingBuffer()
    for _ in range(20):
        ring.append(Value())
    for _ in range(12):
        ring.pop_oldest()
    assert Value.alive == 8
    ring.clear()
    assert Value.alive == 0


@pytest.mark.parametrize("index", [-1, 2, 8])
def test_a_place_without_a_value_is_refused(index):
    ring = RingBuffer()
    ring.append("a")
    ring.append("b")
    with pytest.raises(IndexError, match=f"place {index} of 2 values"):
        ring.at(index)
    ring.clear()
    for look in (lambda: ring.oldest, lambda: ring.newest, ring.pop_oldest):
        with pytest.raises(IndexError):
            look()
