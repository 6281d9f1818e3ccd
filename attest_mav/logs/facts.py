"""The facts of a flight that the first pass over an autopilot's own log collects, and its summary made of them."""

from collections.abc import Mapping
from typing import Final

from attest_mav.logs.source import FlightDate
from attest_mav.samples import PositionSample, Sample, VelocitySample
from attest_mav.types import VelocityOrigin
from attest_mav.vehicle_reports import ClockSample, FirmwareSample, HeartbeatSample, ParameterSample
from attest_mav.vehicle_settings import VehicleSettings

NO_DATE: Final = FlightDate(0.0, "the log tells no date; the declination is that of the newest model")


class FlightFacts:
    """The first or last samples of each kind."""

    def __init__(self) -> None:
        self.heartbeat: HeartbeatSample | None = None
        self.firmware: FirmwareSample | None = None
        self.position: PositionSample | None = None
        """The first one; a receiver's rather than another."""
        self.unix_us: int | None = None
        """The first time of a receiver, us."""
        self.velocities: Final[dict[str, VelocitySample]] = {}
        """The first velocity of each receiver."""
        self._first: Final[dict[int, ParameterSample]] = {}
        self._last: Final[dict[int, ParameterSample]] = {}

    def take(self, sample: Sample) -> None:
        """Take the next sample."""
        if isinstance(sample, ParameterSample):
            if sample.is_listed:
                self._first.setdefault(sample.setting, sample)
            self._last[sample.setting] = sample
        elif isinstance(sample, VelocitySample):
            if sample.origin == VelocityOrigin.RECEIVER:
                self.velocities.setdefault(sample.source, sample)
        elif isinstance(sample, PositionSample):
            self._take_position(sample)
        elif isinstance(sample, FirmwareSample):
            self.firmware = self.firmware or sample
        elif isinstance(sample, HeartbeatSample):
            self.heartbeat = self.heartbeat or sample
        elif isinstance(sample, ClockSample):
            self.unix_us = sample.unix_us if self.unix_us is None else self.unix_us

    def _take_position(self, sample: PositionSample) -> None:
        known = self.position
        is_receiver = sample.source in self.velocities
        if known is None or (is_receiver and known.source not in self.velocities):
            self.position = sample

    @property
    def date(self) -> FlightDate | None:
        """The date of the flight; None where there is no position to look anything up for."""
        if self.position is None:
            return None
        return NO_DATE if self.unix_us is None else FlightDate(self.unix_us * 1e-6)

    @property
    def parameters(self) -> tuple[ParameterSample, ...]:
        """The last parameter of each setting."""
        return tuple(self._last.values())

    def settings(self, assumed: VehicleSettings) -> VehicleSettings:
        """The settings by the parameters. assumed: those that hold without them."""
        for sample in self._last.values():
            assumed = assumed.updated(sample.setting, sample.value)
        return assumed

    def opening(self, heartbeat: HeartbeatSample) -> tuple[Sample, ...]:
        """The first value of each parameter, the heartbeat, and the firmware."""
        known: list[Sample] = [*self._first.values(), heartbeat]
        return tuple(known if self.firmware is None else [*known, self.firmware])


def velocity_lack(counts: Mapping[str, int], records: tuple[str, ...]) -> str:
    """The reason why a log has no velocity of a receiver, whose records have these names."""
    count = sum([counts.get(name, 0) for name in records])
    name = records[0]
    return f"none of {count} {name} has a 3-D fix with one" if count else f"it has no {name}"
