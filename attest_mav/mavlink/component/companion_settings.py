"""The settings of our component on the MAVLink network."""

from dataclasses import dataclass, field

from attest_mav.mavlink.component.vehicle_data import DataSettings


@dataclass(frozen=True)
class CompanionSettings:
    """Identity, rate, and the data that are requested."""

    vehicle_system: int = 0
    """The vehicle's system id; 0 takes the only one that is heard."""
    system: int = 0
    """Our system id; 0 takes the vehicle's."""
    component: int = 193
    """Our component id."""
    publish_hz: float = 20.0
    """Rate of the attitude on every link, Hz."""
    data: DataSettings = field(default_factory=DataSettings)
    """The messages and settings requested of the vehicle."""
    timesync: bool = True
    """Whether the vehicle is asked for its time."""
    parameters: dict[str, float] = field(default_factory=dict)
    """The configured values of our own parameters, by name; see ``own_parameters``."""
