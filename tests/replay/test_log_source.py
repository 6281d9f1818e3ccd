"""The engine on a source that is no MAVLink log, with errors that the test knows from its own angles."""

from dataclasses import replace
from io import BytesIO
from math import cos, isnan, radians, sin

import pytest

from attest_mav.errors import UnreadableDataError, UsageError
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.logs.source import AnnotatableSource, LogSummary, MessageRoles, SampleBatch, VehicleSummary
from attest_mav.replay.engine import record, replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window
from attest_mav.samples import AttitudeSample, ImuSample
from attest_mav.types import AttitudeRole
from attest_mav.vehicle_settings import VehicleSettings

G = 9.80665
ROLES = MessageRoles(
    inertial=("IMU[0]", "IMU[1]"),
    truth=("TRUTH",),
    reference=("TRUTH", "EKF"),
    named_reference=("TRUTH", "EKF"),
    autopilot=("EKF",),
    untimed=(),
)
LOG_ROLL_DEG = 10.0
"""The roll that the readings show; the nose points to magnetic north."""


def rolled(roll_deg, yaw_deg):
    """Body to NED: a yaw, then a roll about the nose."""
    c, s = cos(radians(roll_deg) / 2), sin(radians(roll_deg) / 2)
    w, z = cos(radians(yaw_deg) / 2), sin(radians(yaw_deg) / 2)
    return (w * c, w * s, z * s, z * c)


class StillSource:
    """A rolled vehicle at rest for ``seconds``, in batches of ``batch`` instants at 100 Hz."""

    def __init__(self, truth=(LOG_ROLL_DEG, 0.0), own=(LOG_ROLL_DEG, 0.0), seconds=4.0, batch=64, refusals=()):
        self.truth, self.own, self.count, self.batch = truth, own, int(100 * seconds), batch
        self.refused = refusals
        self.plans = []

    def summary(self, progress=None):
        if progress is not None:
            progress(1.0)
        counts = {"IMU[0]": self.count, "TRUTH": self.count, "EKF": self.count}
        vehicle = VehicleSummary(
            vehicle=(1, 1),
            is_autopilot=True,
            counts=counts,
            inertial=("IMU[1]", "IMU[0]"),
            in_simulator=False,
            position=None,
            velocity_lack="this source has none",
            settings=VehicleSettings(),
            parameters=(),
        )
        return LogSummary("still", ROLES, 3 * self.count, 7, 0.01 * (self.count - 1), {(1, 1): vehicle})

    def samples(self, plan):
        self.plans.append(plan)
        for start in range(0, self.count, self.batch):
            samples = []
            for k in range(start, min(start + self.batch, self.count)):
                samples += self.instant(k)
            yield SampleBatch(samples, [0] * len(samples), min(1.0, (start + self.batch) / self.count))

    def instant(self, k):
        t_ns = k * 10_000_000
        c, s = cos(radians(LOG_ROLL_DEG)), sin(radians(LOG_ROLL_DEG))
        # Specific force is up and the field is north and down, both turned back by the roll.
        accel, mag = (0.0, -s * G, -c * G), (0.2, s * 0.44, c * 0.44)
        return [
            AttitudeSample("EKF", 1, 1, t_ns, t_ns, rolled(*self.own), None, AttitudeRole.AUTOPILOT),
            ImuSample("IMU[0]", 1, 1, t_ns, t_ns, (0.0, 0.0, 0.0), accel, mag),
            AttitudeSample("TRUTH", 1, 1, t_ns, t_ns, rolled(*self.truth), None, AttitudeRole.TRUTH),
        ]

    def notes(self, plan):
        return [f"{plan.imu} was made by a test"]

    def refusals(self, plan):
        return list(self.refused)


class SilentSource(StillSource):
    """A source of which no inertial reading can be decoded."""

    def instant(self, k):
        return [sample for sample in super().instant(k) if not isinstance(sample, ImuSample)]


ALL = Request((GradientDescent(),), window=Window(skip_s=0.0))


def report(source, request=ALL, outputs=None):
    return as_json("flight", replay(source, request, outputs or Outputs()))


def test_a_filter_and_an_autopilot_are_off_by_the_angles_of_the_test():
    north = replace(ALL, declination_deg=0.0)
    result = report(StillSource(truth=(LOG_ROLL_DEG + 2.0, 5.0), own=(LOG_ROLL_DEG - 1.0, 5.0)), north)
    (ours,) = result["filters"]
    for figure in ("rms", "p95", "max"):
        assert ours["tilt_deg"][figure] == pytest.approx(2.0, abs=0.01)
        assert ours["heading_deg"][figure] == pytest.approx(5.0, abs=0.01)
        assert result["autopilot"]["tilt_deg"][figure] == pytest.approx(3.0, abs=1e-5)
        assert result["autopilot"]["heading_deg"][figure] == pytest.approx(0.0, abs=1e-5)


def test_the_report_names_the_formats_own_messages_and_counts():
    result = report(StillSource(own=(LOG_ROLL_DEG + 1.0, 0.0)))
    assert (result["format"], result["frames"], result["bad_bytes"]) == ("still", 1200, 7)
    assert result["imu"] == {"message": "IMU[0]", "samples": 400, "rate_hz": pytest.approx(100.0), "gaps": 0}
    assert result["reference"] == {"message": "TRUTH", "samples": 400, "sigma": None}
    assert result["autopilot"]["message"] == "EKF"
    assert "IMU[0] was made by a test" in result["notes"]


def test_the_second_pass_is_told_what_was_chosen_from_the_summary():
    source = StillSource()
    report(source, replace(ALL, reference="EKF"))
    (plan,) = source.plans
    assert plan.vehicle == (1, 1)
    assert plan.messages == {"IMU[0]", "EKF"}
    assert (plan.reference, plan.autopilot, plan.timing) == ("EKF", None, None)


@pytest.mark.parametrize("batch", [1, 7, 10_000])
def test_the_size_of_the_batches_changes_nothing(batch):
    source = {"truth": (12.0, 5.0), "own": (9.0, 5.0)}
    assert report(StillSource(**source, batch=batch)) == report(StillSource(**source))


def test_without_a_velocity_the_reason_is_the_sources():
    result = report(StillSource(), Request(window=Window(skip_s=0.0)))
    assert result["notes"][0].startswith("no velocity in the log: this source has none;")


def test_a_message_that_the_source_lacks_is_an_error_with_its_own_names():
    with pytest.raises(UnreadableDataError, match=r"^no IMU\[1\] in it: .*; it has IMU\[0\]$"):
        report(StillSource(), replace(ALL, imu="IMU[1]"))


@pytest.mark.parametrize(
    ("refusals", "reason"), [((), "the part to be read has none"), (("one", "another"), "one; another")]
)
def test_without_a_reading_the_refusals_of_the_source_are_the_reason(refusals, reason):
    with pytest.raises(UnreadableDataError, match=rf"^no usable IMU\[0\]: {reason}$"):
        report(SilentSource(refusals=refusals))


def test_a_format_that_cannot_hold_attitudes_is_refused_before_anything_is_written():
    source, sink = StillSource(), BytesIO()
    assert not isinstance(source, AnnotatableSource)
    with pytest.raises(UsageError, match="cannot hold our attitudes"):
        report(source, outputs=Outputs(annotated=sink))
    assert (source.plans, sink.getvalue()) == ([], b"")


def test_progress_grows_to_one_over_both_passes():
    shares = []
    report(StillSource(batch=100), outputs=Outputs(progress=shares.append))
    assert shares == pytest.approx([0.2, 0.4, 0.6, 0.8, 1.0])


def test_a_recording_is_all_samples_in_order():
    recording = record(StillSource(seconds=1.0))
    assert [sample.source for sample in recording.samples] == ["EKF", "IMU[0]", "TRUTH"] * 100
    assert recording.plan.imu == "IMU[0]"
    assert recording.earth_field is None
    assert isnan(recording.settings.low_pass_hz)


def test_a_log_without_senders_has_nothing_to_estimate_from():
    source = StillSource()
    empty = LogSummary("still", ROLES, 0, 0, 0.0, {})
    source.summary = lambda _=None: empty
    with pytest.raises(UnreadableDataError, match=r"no IMU\[0\] or IMU\[1\] in it"):
        report(source)
