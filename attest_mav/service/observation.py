"""Parts of the service as records of a snapshot."""

from attest_mav.estimation.clock_offset import ClockOffset
from attest_mav.estimation.lane import Lane
from attest_mav.estimation.pipeline import Pipeline
from attest_mav.estimation.vehicle import Vehicle
from attest_mav.estimation.verdict import VerdictSettings
from attest_mav.mavlink.component.discovery import VehicleDiscovery
from attest_mav.mavlink.component.ports import Port
from attest_mav.mavlink.component.streams import StreamManager
from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.service.link_input import LinkInput
from attest_mav.service.link_records import LinkSnapshot, Refusal, StreamSnapshot, Traffic
from attest_mav.service.signing_status import SigningSnapshot
from attest_mav.service.vehicle_records import ClockSnapshot, LaneSnapshot, VehicleSnapshot
from attest_mav.service.verdict_records import AutopilotAttitude


def link_snapshot(framer: LinkInput, port: Port, signing: SigningSnapshot | None, traffic: Traffic) -> LinkSnapshot:
    """One link, from its receiving side, its sending side, its signatures and its host's counters."""
    return LinkSnapshot(
        name=port.name,
        frames=framer.frames,
        bad_bytes=framer.bad_bytes,
        bad_crc=framer.bad_crc,
        lost_frames=framer.lost,
        attitudes_sent=port.attitudes_sent,
        held_back=port.held_for != 0,
        held_for=port.held_for,
        changes=tuple(port.changes),
        signing=signing,
        traffic=traffic,
    )


def vehicle_snapshot(discovery: VehicleDiscovery, vehicle: Vehicle) -> VehicleSnapshot | None:
    """The vehicle, None before one is found. ``vehicle``: the contents of its messages."""
    found = discovery.vehicle
    if found is None:
        return None
    return VehicleSnapshot(
        system=found.system,
        component=found.component,
        autopilot=found.autopilot,
        vehicle_type=found.vehicle_type,
        link=found.link,
        is_present=discovery.present,
        kind=vehicle.kind,
        armed=vehicle.armed,
        firmware=vehicle.firmware,
        settings=vehicle.settings,
        field=vehicle.field,
        speed_source=vehicle.speed_source,
    )


def stream_snapshots(manager: StreamManager, is_present: bool, now_ns: int) -> tuple[StreamSnapshot, ...]:
    """The messages that are asked for. Rates are not measured while the vehicle is away: nothing comes then."""
    return tuple(
        StreamSnapshot(
            stream.name,
            stream.hz,
            stream.answer,
            stream.refused,
            stream.achieved_hz if is_present else 0.0,
            stream.ceiling_hz,
            manager.hindrance(stream, now_ns),
        )
        for stream in manager.streams
    )


def refusals(decoder: Decoder) -> tuple[Refusal, ...]:
    """All sources that were ever refused."""
    reasons, counts = decoder.refusals, decoder.refused
    return tuple(Refusal(name, reasons.get(name, ""), counts.get(name, 0)) for name in sorted(reasons | counts))


def clock_snapshot(clock: ClockOffset, answers: int) -> ClockSnapshot:
    """The autopilot's clock; ``answers`` of TIMESYNC."""
    return ClockSnapshot(answers, clock.round_trip_s, clock.skew, clock.jumps)


def lane_snapshots(pipeline: Pipeline | None) -> tuple[LaneSnapshot, ...]:
    """All lanes; none without a pipeline."""
    if pipeline is None:
        return ()
    return tuple(_lane_snapshot(lane, pipeline) for lane in pipeline.lanes.values())


def autopilot_attitude(pipeline: Pipeline | None) -> AutopilotAttitude | None:
    """The autopilot's newest attitude, None before the first."""
    sample = None if pipeline is None else pipeline.autopilot_attitude
    return None if sample is None else AutopilotAttitude(sample.source, sample.q_nb, sample.rx_ns)


def tilt_threshold(pipeline: Pipeline | None, settings: VerdictSettings) -> float | None:
    """The threshold beside the estimate that is compared, rad; None without one."""
    estimate = None if pipeline is None else pipeline.estimate
    if estimate is None:
        return None
    return settings.proven_tilt if estimate.sigma_is_proven else settings.tilt


def _lane_snapshot(lane: Lane, pipeline: Pipeline) -> LaneSnapshot:
    estimate = pipeline.estimate
    return LaneSnapshot(
        source=lane.source,
        is_primary=lane.source == pipeline.primary,
        estimate=estimate if estimate is not None and estimate.lane == lane.source else None,
        fault=pipeline.fault_of(lane.source),
        rests_on=lane.rests_on,
        is_calibrated=lane.calibration.is_used,
        field_lost_s=lane.field_lost_s,
        samples=lane.samples,
        repeats=lane.repeats,
        late=lane.late,
        strays=lane.strays,
        delay_s=lane.delay_s,
        rejected=lane.rejected,
        frozen=lane.frozen,
        gaps=lane.gaps,
        restarts=lane.restarts,
    )
