"""The settings of the service: one record for each of its parts."""

from dataclasses import dataclass

from attest_mav.estimation.pipeline import PipelineSettings
from attest_mav.filters.base import AttitudeFilter
from attest_mav.mavlink.component.channel import PortSettings
from attest_mav.mavlink.component.companion_settings import CompanionSettings
from attest_mav.mavlink.decode.units import RawScales


@dataclass(frozen=True)
class ServiceSettings:
    """The settings of each part, in the part's own record and in SI units."""

    companion: CompanionSettings
    """Our ids, the rate of the attitude, and the messages to ask for."""
    ports: tuple[PortSettings, ...]
    """The outputs of each link, in the order of the links."""
    raw_scales: RawScales | None
    """The meaning of one count of RAW_IMU on an autopilot that sends raw values; None refuses them."""
    pipeline: PipelineSettings
    """Age limits, thresholds of the verdict, and sources of the aids."""
    attitude_filter: AttitudeFilter
    """The filter that is published."""
    declination: float
    """rad, east positive; NaN: looked up at the vehicle's position."""
    learns: bool = True
    """Whether the sensors' errors of earlier flights are used, and those of this one kept."""
