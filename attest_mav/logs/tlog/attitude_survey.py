"""The first pass over a log's attitudes: where they begin and end, and whether their angles can be radians."""

from collections.abc import Mapping
from math import pi
from typing import Final

from attest_mav.logs.source import VehicleId
from attest_mav.samples import AttitudeSample

WIDEST: Final = 2.0 * pi + 0.1
"""No angle of an attitude in radians is larger."""
ODD_SHARE: Final = 0.01
"""Angles that are wider in more of the attitudes than this are in degrees, and not damaged."""
FEWEST_ODD: Final = 3


class AttitudeStream:
    """The attitudes of one message from one sender, as far as the counter has returned them."""

    def __init__(self, offset: int, sample: AttitudeSample) -> None:
        self.sample: Final = sample
        """The first one."""
        self.first: Final = offset
        """Its place in the log."""
        self.last = offset
        """Place of the newest one."""
        self.samples = 0
        self.odd = 0
        """Number of those with an angle that no radians can give."""
        self.widest = 0.0
        """The largest angle as sent."""

    def take(self, offset: int, sample: AttitudeSample) -> None:
        """Take the next attitude."""
        self.last = offset
        self.samples += 1
        if sample.euler is not None:
            widest = max([abs(angle) for angle in sample.euler])
            self.widest = max(self.widest, widest)
            self.odd += widest > WIDEST

    def unfit(self, name: str) -> str:
        """The reason why nothing can be compared with them; "" if all is well."""
        if self.odd < FEWEST_ODD or self.odd < ODD_SHARE * self.samples:
            return ""
        return f"the angles of {name} are no radians (up to {self.widest:.0f}): they may be degrees"


class AttitudeSurvey:
    """The streams of all senders."""

    def __init__(self) -> None:
        self._streams: Final[dict[tuple[VehicleId, str], AttitudeStream]] = {}

    def take(self, offset: int, sample: AttitudeSample) -> None:
        """Take the attitude at this place of the log."""
        key = ((sample.system, sample.component), sample.source)
        stream = self._streams.get(key)
        if stream is None:
            stream = self._streams[key] = AttitudeStream(offset, sample)
        stream.take(offset, sample)

    def spans(self, vehicle: VehicleId, length: int) -> dict[str, float]:
        """Share of the log, which has this length, from the first to the last attitude, by name."""
        return {
            name: (stream.last - stream.first) / length
            for (sender, name), stream in self._streams.items()
            if sender == vehicle
        }

    def first_of(self, vehicle: VehicleId, name: str) -> AttitudeSample | None:
        """The first attitude of that name."""
        stream = self._streams.get((vehicle, name))
        return None if stream is None else stream.sample

    def unfit(self, vehicle: VehicleId, counts: Mapping[str, int]) -> dict[str, str]:
        """The reasons by name, for the messages that are counted."""
        reasons = {}
        for name, count in counts.items():
            stream = self._streams.get((vehicle, name))
            reasons[name] = f"none of {count} {name} holds an attitude" if stream is None else stream.unfit(name)
        return {name: reason for name, reason in reasons.items() if reason}
