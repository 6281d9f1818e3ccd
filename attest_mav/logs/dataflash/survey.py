"""The first pass over a DataFlash log: it counts all records and reads those that tell of the vehicle and the place."""

from collections.abc import Iterator
from typing import Final

from attest_mav.logs.dataflash.motion_readers import Accuracy, FirstFixReader, OriginReader
from attest_mav.logs.dataflash.reader import RecordReader, TimeReader
from attest_mav.logs.dataflash.roles import DATAFLASH_ROLES
from attest_mav.logs.dataflash.routes import Router
from attest_mav.logs.dataflash.streams import SENSORS
from attest_mav.logs.dataflash.unit_readers import unit_readers
from attest_mav.logs.dataflash.units import UnitTable
from attest_mav.logs.dataflash.vehicle_readers import (
    ArmReader,
    EventReader,
    ParameterReader,
    TextReader,
    VehicleState,
    VersionReader,
)
from attest_mav.logs.facts import FlightFacts
from attest_mav.mavlink.constants import MAV_TYPE_GENERIC
from attest_mav.samples import Sample


class Survey:
    """What the first pass has found."""

    def __init__(self) -> None:
        self.units: Final = UnitTable()
        self.facts: Final = FlightFacts()
        self.texts: Final = TextReader()
        self.state: Final = VehicleState(MAV_TYPE_GENERIC, armed=True)
        self.router: Final = Router(self._readers(), self.units)

    def _readers(self) -> dict[str, RecordReader]:
        readers: dict[str, RecordReader] = {
            **unit_readers(self.units),
            **{name: TimeReader() for name in DATAFLASH_ROLES.inertial},
            "MSG": self.texts,
            "VER": VersionReader(),
            "PARM": ParameterReader(),
            "ORGN": OriginReader("ORGN"),
            "EV": EventReader(self.state),
            "ARM": ArmReader("ARM", "ArmState", self.state),
            "STAT": ArmReader("STAT", "Armed", self.state),
        }
        for name in SENSORS["GPS"]:
            readers[name] = FirstFixReader(name, Accuracy())
        return readers

    def take(self, windows: Iterator[list[Sample]]) -> Iterator[None]:
        """Take all of the log; yields once a window."""
        for samples in windows:
            for sample in samples:
                self.facts.take(sample)
            yield

    @property
    def vehicle_type(self) -> int:
        """MAV_TYPE, GENERIC where no text tells it."""
        told = self.texts.vehicle_type
        return MAV_TYPE_GENERIC if told is None else told

    @property
    def duration_s(self) -> float:
        """Time from the first to the last record, s."""
        return self.router.clock.span_ns * 1e-9

    @property
    def pace_ns(self) -> float:
        """Interval of inertial records without a time, ns; 0 where they have one."""
        return self.router.clock.mean_pace_ns()

    def begin(self) -> VehicleState:
        """The vehicle at the begin of the log; armed where nothing tells it, which allows any motion."""
        armed = self.state.armed_at_first
        return VehicleState(self.vehicle_type, armed is not False)

    @property
    def receiver(self) -> str:
        """The receiver whose velocity is used: the first one with any."""
        with_velocity = [name for name in SENSORS["GPS"] if name in self.facts.velocities]
        return with_velocity[0] if with_velocity else SENSORS["GPS"][0]
