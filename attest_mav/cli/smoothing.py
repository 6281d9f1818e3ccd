"""The smoother for a replay, loaded when a log is to be smoothed: with it comes numpy."""

from attest_mav.replay.smoothed import FlightToSmooth, SmoothedFlight


def smoothed(flight: FlightToSmooth) -> SmoothedFlight | None:
    """Smooth a flight; None where no attitude can be found to begin with."""
    from attest_mav.smoothing.log import smoothed_flight  # noqa: PLC0415 (costs 150 ms)

    return smoothed_flight(flight)
