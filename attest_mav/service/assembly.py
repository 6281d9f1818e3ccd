"""What the companion is told of the configuration: who we are, what we ask for, and what each link carries."""

from attest_mav.config.records import Config, LinkConfig
from attest_mav.mavlink.component.companion import CompanionSettings
from attest_mav.mavlink.component.ports import PortSettings
from attest_mav.mavlink.component.vehicle_data import POSITION_MESSAGES, DataSettings


def port_settings(link: LinkConfig) -> PortSettings:
    """What a link carries, from its configuration."""
    return PortSettings(
        attitude="attitude_quaternion" in link.publish,
        covariance="attitude_quaternion_cov" in link.publish,
        named_values="named_values" in link.publish,
        yields=link.yield_to_onboard,
    )


def companion_settings(config: Config) -> CompanionSettings:
    """Who we are and what we ask for, from the configuration."""
    streams = config.streams
    used = (config.aiding.forward_speed, config.aiding.velocity)
    data = DataSettings(
        asks=streams.request,
        restores=streams.request and streams.restore,
        imu_messages=streams.imu_messages,
        imu_hz=streams.imu_hz,
        attitude_hz=streams.attitude_hz,
        aiding_hz=streams.aiding_hz,
        positions=tuple(name for name in POSITION_MESSAGES if name in used),
        default_settings=config.filter.build().default_settings,
    )
    output = config.output
    return CompanionSettings(config.vehicle.system_id, output.system_id, output.component_id, output.rate_hz, data)
