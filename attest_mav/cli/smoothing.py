"""The smoother for a replay, loaded when a log is to be smoothed: with it comes numpy."""

from collections.abc import Iterator
from contextlib import contextmanager

from attest_mav.replay.smoothed import FlightToSmooth, SmoothedFlight


@contextmanager
def smoothed(flight: FlightToSmooth) -> Iterator[SmoothedFlight | None]:
    """Smooth a flight, in temporary files that last as long as the context; None where no attitude can be found."""
    from attest_mav.runtime.scratch import ScratchFile  # noqa: PLC0415 (these cost 150 ms)
    from attest_mav.smoothing.log import smoothed_flight  # noqa: PLC0415
    from attest_mav.smoothing.tables import Scratch  # noqa: PLC0415

    with Scratch(ScratchFile) as scratch:
        yield smoothed_flight(flight, scratch)
