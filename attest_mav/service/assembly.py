"""From the configuration to the settings of the parts: pipeline, decoder, companion, and the outputs of each link.

The configuration holds what a user may write, in a user's units; here its degrees become radians, and its words become
the records of the packages that act on them.
"""

from collections.abc import Mapping
from dataclasses import replace
from difflib import get_close_matches
from math import nan, radians
from typing import Final

from attest_mav.config.link_url import Scheme, parse_link
from attest_mav.config.records import AidingConfig, Config, LinkConfig, RawImuConfig, StreamsConfig, VerdictConfig
from attest_mav.errors import ConfigError, UsageError
from attest_mav.estimation.arrivals import Arrivals
from attest_mav.estimation.pipeline import PipelineSettings
from attest_mav.estimation.vehicle import AidSettings
from attest_mav.estimation.verdict import VerdictSettings
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.mavlink.component.channel import PortSettings
from attest_mav.mavlink.component.companion_settings import CompanionSettings
from attest_mav.mavlink.component.own_parameters import HOLD, MAX_SIGMA, RATE, TILT_LIMIT, OwnParameters
from attest_mav.mavlink.component.vehicle_data import POSITION_MESSAGES, DataSettings
from attest_mav.mavlink.decode.units import RawScales
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.mavlink.signing.settings import SigningSettings
from attest_mav.service.settings import ServiceSettings

SERIAL_BITS: Final = 10
"""Bits on a serial line for each byte: one to start, eight of data, one to stop."""


def service_settings(config: Config, keys: Mapping[str, bytes] | None = None) -> ServiceSettings:
    """The settings of all parts of the service. keys: the contents of the ``key_file`` of each link that signs."""
    declination_deg = config.estimate.declination_deg
    return ServiceSettings(
        companion=companion_settings(config),
        ports=tuple(port_settings(link, keys or {}) for link in config.link),
        raw_scales=raw_scales(config.raw_imu),
        pipeline=pipeline_settings(config),
        attitude_filter=config.filter.build(),
        declination=nan if declination_deg == "auto" else radians(declination_deg),
        learns=config.state.calibration,
    )


def pipeline_settings(config: Config) -> PipelineSettings:
    """The settings of the pipeline, in radians."""
    return PipelineSettings(
        config.estimate.stale_s,
        radians(config.output.max_sigma_deg),
        _verdict_settings(config.verdict),
        _aid_settings(config.aiding),
        Arrivals.LIVE,
    )


def companion_settings(config: Config) -> CompanionSettings:
    """Our ids, the rate of the attitude, and the messages to ask for."""
    output = config.output
    data = _data_settings(config)
    return CompanionSettings(
        config.vehicle.system_id,
        output.system_id,
        output.component_id,
        output.rate_hz,
        data,
        config.estimate.timesync,
        _own_parameters(config),
    )


def port_settings(link: LinkConfig, keys: Mapping[str, bytes]) -> PortSettings:
    """The outputs and the signatures of one link."""
    signing = None
    if link.signing != "off":
        signing = SigningSettings(keys[link.key_file], link.signing == "require", link.accept_unsigned)
    return PortSettings(
        link.publish, link.yield_to_onboard, link.yield_to_stations, parameters=link.parameters, signing=signing
    )


def retuned(settings: PipelineSettings, parameters: OwnParameters) -> PipelineSettings:
    """The settings of the pipeline with the values of our parameters that are in force."""
    tilt_deg = parameters.value(TILT_LIMIT.name)
    verdict = VerdictConfig(tilt_deg=tilt_deg or "auto", hold_s=parameters.value(HOLD.name))
    thresholds = _verdict_settings(verdict)
    return replace(
        settings,
        max_sigma=radians(parameters.value(MAX_SIGMA.name)),
        verdict=replace(
            settings.verdict, tilt=thresholds.tilt, proven_tilt=thresholds.proven_tilt, hold_s=thresholds.hold_s
        ),
    )


def raw_scales(raw_imu: RawImuConfig) -> RawScales | None:
    """The meaning of one count of RAW_IMU, None where none is configured."""
    if raw_imu.accel_mps2 == 0.0 or raw_imu.gyro_radps == 0.0:
        return None
    return RawScales(raw_imu.accel_mps2, raw_imu.gyro_radps, raw_imu.mag_gauss)


def check_simulations(config: Config, name: str) -> None:
    """ConfigError if a ``sim:`` link of the file ``name`` asks for a scenario or a fault that the simulator lacks."""
    for index, link in enumerate(config.link):
        url = parse_link(link.url)
        if url.scheme is Scheme.SIM:
            # Imported here: a real vehicle needs no simulation.
            from attest_mav.sim.fault_text import parse_faults  # noqa: PLC0415
            from attest_mav.sim.scenarios import check_scenario  # noqa: PLC0415

            try:
                if url.scenario:
                    check_scenario(url.scenario)
                parse_faults(url.faults)
            except UsageError as error:
                raise ConfigError(f"{name}: link[{index}].url: {error}") from None


def check_unsigned_messages(config: Config, name: str) -> None:
    """ConfigError if ``accept_unsigned`` of the file ``name`` lists a message that the dialect does not have."""
    if not any(link.accept_unsigned for link in config.link):
        return
    known = load_dialect().by_name
    for index, link in enumerate(config.link):
        for message in link.accept_unsigned:
            if message not in known:
                near = get_close_matches(message, known, n=1)
                hint = f"did you mean {near[0]}?" if near else "expected a name such as RADIO_STATUS"
                raise ConfigError(f"{name}: link[{index}].accept_unsigned: no message {message:.60}; {hint}")


def _verdict_settings(verdict: VerdictConfig) -> VerdictSettings:
    """The thresholds of the verdict; one number in the configuration replaces both thresholds of the tilt."""
    defaults = VerdictSettings()
    tilt_deg = verdict.tilt_deg
    return VerdictSettings(
        tilt=defaults.tilt if tilt_deg == "auto" else radians(tilt_deg),
        proven_tilt=defaults.proven_tilt if tilt_deg == "auto" else radians(tilt_deg),
        hold_s=verdict.hold_s,
        release=verdict.release,
        max_sigma=radians(verdict.max_sigma_deg),
        stale_s=verdict.stale_s,
    )


def _own_parameters(config: Config) -> dict[str, float]:
    """The configured values of our parameters; none where no link allows them, so that kept values do not count."""
    if not any(link.parameters for link in config.link):
        return {}
    tilt_deg = config.verdict.tilt_deg
    return {
        RATE.name: config.output.rate_hz,
        MAX_SIGMA.name: config.output.max_sigma_deg,
        TILT_LIMIT.name: 0.0 if tilt_deg == "auto" else tilt_deg,
        HOLD.name: config.verdict.hold_s,
    }


def _aid_settings(aiding: AidingConfig) -> AidSettings:
    return AidSettings(aiding.forward_speed, aiding.velocity)


def _data_settings(config: Config) -> DataSettings:
    """The messages to ask for; a position message, which the autopilot's filter makes, only where an aid needs it."""
    streams, aiding, attitude_filter = config.streams, config.aiding, config.filter.build()
    return DataSettings(
        asks=streams.request,
        restores=streams.request and streams.restore,
        imu_messages=streams.imu_messages,
        further_imu_messages=_further_imu(streams, attitude_filter),
        imu_bytes_per_s=streams.imu_bytes_per_s or _serial_share(config),
        imu_hz=streams.imu_hz,
        attitude_hz=streams.attitude_hz,
        aiding_hz=streams.aiding_hz,
        positions=tuple(name for name in POSITION_MESSAGES if name in (aiding.forward_speed, aiding.velocity)),
        default_settings=attitude_filter.default_settings,
        identifies=config.state.calibration and isinstance(attitude_filter, VelocityAided),
    )


def _further_imu(streams: StreamsConfig, attitude_filter: AttitudeFilter) -> tuple[str, ...] | None:
    """The messages of other sensors; none without a filter that compares sensors."""
    if not isinstance(attitude_filter, VelocityAided):
        return ()
    return None if streams.further_imu_messages == "auto" else streams.further_imu_messages


def _serial_share(config: Config) -> float:
    """Half of the bytes that the slowest serial link carries in a second; 0 without one."""
    urls = [parse_link(link.url) for link in config.link]
    rates = [url.baud / SERIAL_BITS for url in urls if url.scheme is Scheme.SERIAL]
    return 0.5 * min(rates, default=0.0)
