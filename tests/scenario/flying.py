"""Flights on virtual time: the fake autopilot's bytes through framer, decoder and pipeline."""

from dataclasses import dataclass, field
from math import degrees, inf, radians

from attest_mav.algebra import heading_between, tilt_between
from attest_mav.estimate import Estimate
from attest_mav.estimation.events import Agreement, LaneEvent, Verdict
from attest_mav.estimation.pipeline import Pipeline, PipelineSettings
from attest_mav.filters.registry import default_filter
from attest_mav.mavlink.decode.autopilot_parameters import facts_of_firmware
from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.mavlink.wire.framer import Framer
from attest_mav.samples import AttitudeSample
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings
from attest_mav.types import AttitudeRole, EarthField

SOURCES = {"ardupilot": "RAW_IMU", "px4": "HIGHRES_IMU"}


@dataclass
class Flight:
    """What came out of the pipeline; times are nanoseconds of the simulation."""

    vehicle: FakeAutopilot
    boot_ns: int = 0
    estimates: list[Estimate] = field(default_factory=list)
    published: list[Estimate] = field(default_factory=list)
    lane_events: list[LaneEvent] = field(default_factory=list)
    verdicts: list[Verdict] = field(default_factory=list)

    def kinds(self):
        """The lane's events, in order."""
        return [event.kind for event in self.lane_events]

    def errors(self, from_s=0.0, to_s=inf):
        """(tilt, heading) of each estimate against the truth at its own time, degrees."""
        found = []
        for estimate in self.estimates:
            if from_s <= estimate.rx_ns * 1e-9 < to_s:
                truth = self.vehicle.truth(estimate.t_ns + self.boot_ns).q_nb
                tilt, heading = tilt_between(estimate.q_nb, truth), heading_between(estimate.q_nb, truth)
                found.append((degrees(tilt), abs(degrees(heading))))
        return found

    def worst_published(self, from_s=0.0, to_s=inf):
        """The largest tilt error of those estimates that were fit to be published, degrees."""
        chosen = [one for one in self.published if from_s <= one.rx_ns * 1e-9 < to_s]
        return max(degrees(tilt_between(one.q_nb, self.vehicle.truth(one.t_ns).q_nb)) for one in chosen)

    def worst(self, from_s=0.0, to_s=inf):
        """The largest tilt and heading error, degrees."""
        errors = self.errors(from_s, to_s)
        return max(tilt for tilt, _ in errors), max(heading for _, heading in errors)

    def normalised(self, from_s=0.0):
        """Tilt and heading error of each estimate over its own sigmas."""
        found = []
        for estimate in self.estimates:
            if estimate.rx_ns * 1e-9 >= from_s:
                truth = self.vehicle.truth(estimate.t_ns + self.boot_ns).q_nb
                tilt, heading = tilt_between(estimate.q_nb, truth), heading_between(estimate.q_nb, truth)
                found.append((tilt / estimate.tilt_sigma, heading / estimate.heading_sigma))
        return found

    def first_disagreement_s(self):
        """When the verdict first was DISAGREE, s; infinity if never."""
        return min((v.rx_ns * 1e-9 for v in self.verdicts if v.agreement is Agreement.DISAGREE), default=inf)


def corrected(vehicle, sample):
    """The sample; an attitude of the autopilot's is the truth instead."""
    if isinstance(sample, AttitudeSample) and sample.role == AttitudeRole.AUTOPILOT:
        return sample.with_attitude(vehicle.truth(sample.t_ns).q_nb, frame_known=True)
    return sample


def fly(
    until_s,
    filter_name="gradient-descent",
    faults=(),
    *,
    right=False,
    armed=False,
    heard=None,
    meddle=None,
    others=(),
    calibrations=None,
    **choices,
):
    """One flight: advance to whichever deadline is next, the vehicle's or the pipeline's.

    right: the autopilot's attitudes are the truth, whatever misleads it. armed: a vehicle that stands is armed too.
    heard: a sample as it is heard, or None. meddle: called with the pipeline and the time, ns, after every deadline.
    others: names of further inertial streams. calibrations: errors of sensors by earlier flights, by stream.
    """
    settings = SimSettings(**({"fast_rate_hz": 50.0} | choices), faults=parse_faults(faults))
    dialect = load_dialect()
    vehicle = FakeAutopilot(settings, 1, dialect)
    vehicle.trajectory.flies = vehicle.trajectory.flies or armed
    decoder = Decoder(dialect)
    framer = Framer(dialect, decoder.wanted)
    pipeline = Pipeline(PipelineSettings(), default_filter(filter_name), [SOURCES[settings.personality], *others])
    pipeline.vehicle.calibrations = calibrations or {}
    pipeline.set_vehicle_settings(facts_of_firmware(vehicle.personality.autopilot, vehicle.trajectory.vehicle_type))
    pipeline.set_field(EarthField(radians(settings.earth.declination_deg), radians(settings.earth.inclination_deg)))
    flight = Flight(vehicle)
    now_ns = 0
    while now_ns < until_s * 1e9:
        now_ns = min(vehicle.next_deadline_ns, pipeline.next_deadline_ns or 2**62)
        events = []
        for frame in framer.feed(b"".join(vehicle.frames_until(now_ns)), now_ns):
            for sent in decoder.decode(frame):
                sample = heard(sent) if heard else sent
                if sample is not None:
                    events += pipeline.handle(corrected(vehicle, sample) if right else sample)
        if meddle:
            meddle(pipeline, now_ns)
        events += pipeline.poll(now_ns)
        made = [e for e in events if isinstance(e, Estimate)]
        flight.estimates += made
        flight.published += made if pipeline.publishes else []
        flight.lane_events += [e for e in events if isinstance(e, LaneEvent)]
        flight.verdicts += [e for e in events if isinstance(e, Verdict)]
    assert framer.bad_bytes == 0
    return flight
