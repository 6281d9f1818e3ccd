"""Python's search for cycles of garbage, which the work on a log has none of."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

SELDOM: Final = 100_000
"""So many more containers made than freed lead to a search; Python's own number is some hundred."""


@contextmanager
def seldom_collected() -> Iterator[None]:
    """Search seldom, and pass over everything that exists by now: records and their tuples are freed by counting.

    What the block has left counts as old at its end: a search for it alone would cost a replay 6 ms.
    """
    before = gc.get_threshold()
    gc.freeze()
    gc.set_threshold(SELDOM, *before[1:])
    try:
        yield
    finally:
        gc.freeze()
        gc.set_threshold(*before)
        gc.unfreeze()
