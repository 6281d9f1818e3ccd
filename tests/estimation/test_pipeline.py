"""The pipeline on virtual time: what a person sees when sensors, clocks and links misbehave."""

from math import isnan, nan, radians

import pytest

from attest_mav.algebra import heading_between, q_from_euler, q_norm, q_to_euler, tilt_between
from attest_mav.estimate import Estimate
from attest_mav.estimation.events import Agreement, LaneEvent, LaneEventKind, Verdict
from attest_mav.estimation.pipeline import Pipeline, PipelineSettings
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, EarthField, North, VehicleKind
from attest_mav.vehicle_reports import FirmwareSample, HeartbeatSample, ParameterSample
from attest_mav.vehicle_settings import Setting

DT = 0.02


@pytest.fixture
def pipeline():
    return Pipeline(PipelineSettings(), GradientDescent())


def run(pipeline, samples):
    """All events of those samples."""
    return [event for sample in samples for event in pipeline.handle(sample)]


def kinds(events):
    return [event.kind for event in events if isinstance(event, LaneEvent)]


def estimates(events):
    return [event for event in events if isinstance(event, Estimate)]


def still(imu, start_s, stop_s, **settings):
    count = round((stop_s - start_s) / DT)
    return [imu(start_s + k * DT, **settings) for k in range(count)]


def test_a_vehicle_at_rest_is_aligned_and_level(pipeline, imu):
    events = run(pipeline, still(imu, 0.0, 5.0, yaw=radians(40.0)))
    assert kinds(events) == [LaneEventKind.ALIGNED]
    last = estimates(events)[-1]
    assert last.north == North.MAGNETIC
    assert [round(angle, 6) for angle in q_to_euler(last.q_nb)] == pytest.approx([0.0, 0.0, radians(40.0)], abs=1e-5)


def test_declination_turns_magnetic_headings_into_true_ones(pipeline, imu):
    pipeline.set_field(EarthField(radians(12.0)))
    last = estimates(run(pipeline, still(imu, 0.0, 1.0, yaw=radians(40.0))))[-1]
    assert last.north == North.TRUE
    assert q_to_euler(last.q_nb)[2] == pytest.approx(radians(52.0), abs=1e-5)


def test_a_turn_is_followed_and_its_sign_is_right_handed_about_down(pipeline, imu):
    run(pipeline, still(imu, 0.0, 1.0))
    rate = radians(20.0)
    turning = [imu(1.0 + k * DT, yaw=rate * (k + 1) * DT, rate=rate) for k in range(100)]
    last = estimates(run(pipeline, turning))[-1]
    assert abs(heading_between(last.q_nb, q_from_euler(0.0, 0.0, rate * 2.0))) < radians(0.1)
    assert last.rates == pytest.approx((0.0, 0.0, rate), abs=1e-9)


def test_repeats_and_late_samples_are_counted_and_dropped(pipeline, imu):
    samples = still(imu, 0.0, 1.0)
    noisy = [copy for sample in samples for copy in (sample, sample)]
    noisy.append(imu(0.5))
    assert len(estimates(run(pipeline, noisy))) == len(
        estimates(run(Pipeline(PipelineSettings(), GradientDescent()), samples))
    )
    lane = pipeline.lanes["RAW_IMU"]
    assert (lane.repeats, lane.late, lane.samples) == (50, 1, 50)


def test_a_gap_is_bridged_and_said(pipeline, imu):
    run(pipeline, still(imu, 0.0, 1.0))
    events = run(pipeline, [imu(1.5)])
    assert kinds(events) == [LaneEventKind.GAP]
    assert len(estimates(events)) == 1
    assert pipeline.lanes["RAW_IMU"].gaps == 1


def test_motion_inside_a_gap_is_carried_by_the_exact_turn(pipeline, imu):
    rate = radians(90.0)
    run(pipeline, still(imu, 0.0, 1.0))
    run(pipeline, [imu(1.0 + k * DT, yaw=rate * (k + 1) * DT, rate=rate) for k in range(10)])
    yaw = rate * 0.2 + rate * 0.5
    last = estimates(run(pipeline, [imu(1.18 + 0.5, yaw=yaw, rate=rate)]))[-1]
    assert abs(heading_between(last.q_nb, q_from_euler(0.0, 0.0, yaw))) < radians(0.1)


def test_a_long_gap_starts_again(pipeline, imu):
    run(pipeline, still(imu, 0.0, 1.0))
    events = run(pipeline, still(imu, 4.0, 5.0, yaw=2.0))
    assert kinds(events) == [LaneEventKind.RESTARTED, LaneEventKind.ALIGNED]
    assert abs(heading_between(estimates(events)[0].q_nb, q_from_euler(0.0, 0.0, 2.0))) < 1e-6


def test_without_a_magnetometer_a_restart_keeps_the_heading(pipeline, imu):
    run(pipeline, still(imu, 0.0, 1.0, yaw=1.0))
    events = run(pipeline, still(imu, 4.0, 8.0, field=False))
    last = estimates(events)[-1]
    assert last.north == North.RELATIVE
    assert q_to_euler(last.q_nb)[2] == pytest.approx(1.0, abs=1e-6)


def test_a_reboot_of_the_autopilot_aligns_again(pipeline, imu):
    run(pipeline, still(imu, 100.0, 101.0))
    events = run(pipeline, still(imu, 2.0, 4.0))
    assert kinds(events) == [LaneEventKind.REBOOTED, LaneEventKind.ALIGNED]
    assert estimates(events)[0].t_ns < 4_000_000_000


def test_no_sample_no_estimate(pipeline, imu):
    run(pipeline, still(imu, 0.0, 1.0))
    deadline = pipeline.next_deadline_ns
    assert deadline == pytest.approx(0.98e9 + 0.5e9, abs=2)
    assert pipeline.poll(deadline - 1) == []
    events = pipeline.poll(deadline)
    assert kinds(events) == [LaneEventKind.STOPPED]
    assert pipeline.estimate is None
    assert pipeline.verdict.reason == "no-estimate"
    assert pipeline.next_deadline_ns is None


@pytest.mark.parametrize("broken", [(nan, 0.0, 0.0), (0.0, float("inf"), 0.0)])
def test_a_gyro_that_is_not_a_number_gives_no_estimate(pipeline, imu, broken):
    run(pipeline, still(imu, 0.0, 1.0))
    events = run(pipeline, still(imu, 1.0, 1.4, gyro=broken))
    assert events == []
    assert pipeline.lanes["RAW_IMU"].rejected == 20
    back = estimates(run(pipeline, still(imu, 1.4, 2.0)))
    assert len(back) == 30
    assert all(abs(q_norm(e.q_nb) - 1.0) < 1e-9 for e in back)


@pytest.mark.parametrize("accel", [(nan, nan, nan), (0.0, 0.0, 0.0), (0.0, 0.0, -40.0)])
def test_a_bad_accelerometer_leaves_the_gyro_in_charge(pipeline, imu, accel):
    run(pipeline, still(imu, 0.0, 1.0))
    rate = radians(10.0)
    turning = [imu(1.0 + k * DT, rate=rate, accel=accel) for k in range(50)]
    last = estimates(run(pipeline, turning))[-1]
    assert tilt_between(last.q_nb, (1.0, 0.0, 0.0, 0.0)) < 1e-9
    assert abs(heading_between(last.q_nb, q_from_euler(0.0, 0.0, rate))) < 1e-6


def test_a_frozen_sensor_is_found_and_released(pipeline, imu):
    run(pipeline, still(imu, 0.0, 1.0))
    stuck = run(pipeline, still(imu, 1.0, 4.0, rate=0.3))
    assert kinds(stuck) == [LaneEventKind.FROZEN]
    assert len(estimates(stuck)) == pytest.approx(1.0 / DT, abs=2)
    free = run(pipeline, still(imu, 4.0, 5.0))
    assert kinds(free) == [LaneEventKind.ALIGNED]


def test_after_a_frozen_sensor_a_filter_that_aligns_itself_begins_anew(imu):
    """What it had before is as old as the freeze was long, however certain it was."""
    pipeline = Pipeline(PipelineSettings(), VelocityAided())
    run(pipeline, still(imu, 0.0, 3.0))
    run(pipeline, still(imu, 3.0, 8.0, rate=0.3))
    free = run(pipeline, still(imu, 8.0, 10.0, yaw=radians(80.0)))
    assert kinds(free) == [LaneEventKind.RESTARTED, LaneEventKind.ALIGNED]
    for estimate in estimates(free):
        assert abs(heading_between(estimate.q_nb, q_from_euler(0.0, 0.0, radians(80.0)))) < radians(2.0)


def test_a_magnetometer_that_vanishes_is_said_after_ten_seconds(pipeline, imu):
    run(pipeline, still(imu, 0.0, 1.0))
    events = run(pipeline, still(imu, 1.0, 12.0, field=False))
    lost = next(e for e in events if isinstance(e, LaneEvent))
    assert lost.kind == LaneEventKind.HEADING_LOST
    assert lost.t_ns * 1e-9 == pytest.approx(11.0, abs=0.1)
    assert estimates(events)[-1].north == North.RELATIVE
    assert kinds(run(pipeline, still(imu, 12.0, 12.1))) == [LaneEventKind.HEADING_FOUND]


def test_a_magnetometer_that_hangs_while_the_vehicle_turns_is_not_believed(pipeline, imu):
    run(pipeline, still(imu, 0.0, 1.0))
    rate = radians(30.0)
    hung = [imu(1.0 + k * DT, yaw=0.0, rate=rate * (1.0 + 1e-3 * (k % 2))) for k in range(500)]
    last = estimates(run(pipeline, hung))[-1]
    turned = rate * 10.0 * 1.0005
    # Believed, the field would hold the heading back by up to 2 beta a second: 38 deg over these ten seconds.
    assert abs(heading_between(last.q_nb, q_from_euler(0.0, 0.0, turned))) < radians(6.0)


def test_only_the_primary_lane_is_published(imu):
    pipeline = Pipeline(PipelineSettings(), GradientDescent(), ["RAW_IMU", "SCALED_IMU2"])
    both = [
        s
        for k in range(100)
        for s in (imu(k * DT, source="SCALED_IMU2"), imu(k * DT), imu(k * DT, source="SCALED_IMU3"))
    ]
    events = run(pipeline, both)
    assert {e.lane for e in estimates(events)} == {"RAW_IMU", "SCALED_IMU2"}
    assert pipeline.estimate.lane == "RAW_IMU"
    assert set(pipeline.lanes) == {"RAW_IMU", "SCALED_IMU2"}


def interleave(imu, attitude, start_s, stop_s, q_of_time):
    count = round((stop_s - start_s) / DT)
    samples = []
    for k in range(count):
        t = start_s + k * DT
        samples += [imu(t), attitude(t + 0.003, q_of_time(t + 0.003))]
    return samples


def verdicts(events):
    return [event for event in events if isinstance(event, Verdict)]


def test_an_honest_autopilot_agrees(pipeline, imu, attitude):
    events = run(pipeline, interleave(imu, attitude, 0.0, 5.0, lambda t: q_from_euler(0.001 * t, 0.0, 0.0)))
    said = verdicts(events)
    assert {v.agreement for v in said[:20]} == {Agreement.UNDECIDED}
    assert said[-1].agreement == Agreement.AGREE
    assert said[-1].tilt == pytest.approx(0.005, abs=1e-3)
    assert isnan(said[-1].heading)


def test_a_tilted_autopilot_is_found_after_the_hold_time_and_forgiven_with_hysteresis(pipeline, imu, attitude):
    def tilt(t):
        return q_from_euler(radians(15.0 if 2.0 <= t < 5.0 else 9.5 if t >= 5.0 else 0.0), 0.0, 0.0)

    said = verdicts(run(pipeline, interleave(imu, attitude, 0.0, 9.0, tilt)))
    found = next(v for v in said if v.agreement == Agreement.DISAGREE)
    assert found.reason == "tilt"
    assert found.t_ns * 1e-9 == pytest.approx(2.6, abs=0.05)
    assert said[-1].agreement == Agreement.DISAGREE, "9.5 deg is above 90 % of the threshold"
    said = verdicts(run(pipeline, interleave(imu, attitude, 9.0, 12.0, lambda _: q_from_euler(0.05, 0.0, 0.0))))
    assert said[-1].agreement == Agreement.AGREE


def test_heading_is_judged_only_from_the_same_north(imu, attitude):
    def turned(_):
        return q_from_euler(0.0, 0.0, radians(30.0))

    unknown = Pipeline(PipelineSettings(), GradientDescent())
    assert verdicts(run(unknown, interleave(imu, attitude, 0.0, 4.0, turned)))[-1].agreement == Agreement.AGREE
    known = Pipeline(PipelineSettings(), GradientDescent())
    known.set_field(EarthField(0.0))
    last = verdicts(run(known, interleave(imu, attitude, 0.0, 4.0, turned)))[-1]
    assert (last.agreement, last.reason) == (Agreement.DISAGREE, "heading")
    assert last.heading == pytest.approx(radians(30.0), abs=1e-3)


def test_a_frozen_autopilot_is_found_when_the_vehicle_turns(pipeline, imu, attitude):
    run(pipeline, still(imu, 0.0, 1.0))
    events = []
    for k in range(50):
        events += run(pipeline, [imu(1.0 + k * DT, rate=0.1), attitude(1.0 + k * DT, (1.0, 0.0, 0.0, 0.0))])
    said = [(v.agreement, v.reason) for v in verdicts(events)]
    assert said[:3] == [(Agreement.AGREE, "agrees")] * 2 + [(Agreement.UNDECIDED, "settling")]
    assert said[-1] == (Agreement.DISAGREE, "frozen")


def test_copies_of_an_attitude_are_no_frozen_autopilot(pipeline, imu, attitude):
    """A router loop, or two radios and a cable, deliver every frame three times."""
    run(pipeline, still(imu, 0.0, 1.0))
    events = []
    for k in range(100):
        t_s, yaw = 1.0 + k * DT, 0.1 * (k + 1) * DT
        one = attitude(t_s, q_from_euler(0.0, 0.0, yaw))
        events += run(pipeline, [imu(t_s, yaw=yaw, rate=0.1), one, one, one])
    assert {v.agreement for v in verdicts(events)} == {Agreement.AGREE}


def test_a_frame_now_and_then_that_agrees_hides_nothing(pipeline, imu, attitude):
    """The autopilot is wrong by 28 degrees; somebody repeats our own attitude every 0.9 s."""
    wrong, ours = q_from_euler(radians(28.0), 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
    run(pipeline, still(imu, 0.0, 2.0))
    events = []
    for k in range(200):
        t_s = 2.0 + k * DT
        events += run(pipeline, [imu(t_s), attitude(t_s, wrong)])
        if k % 45 == 0:
            events += run(pipeline, [attitude(t_s + 0.001, ours)])
    assert verdicts(events)[-1].agreement == Agreement.DISAGREE


def test_a_few_quaternions_that_agree_hide_nothing(pipeline, imu, attitude):
    wrong, ours = q_from_euler(radians(28.0), 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
    run(pipeline, still(imu, 0.0, 2.0))
    events = []
    for k in range(200):
        t_s = 2.0 + k * DT
        events += run(pipeline, [imu(t_s), attitude(t_s, wrong)])
        if k % 45 == 0:
            events += run(pipeline, [attitude(t_s, ours, "ATTITUDE_QUATERNION")])
    assert verdicts(events)[-1].agreement == Agreement.DISAGREE
    assert verdicts(events)[-1].source == "ATTITUDE"


def test_attitude_quaternion_is_preferred_while_it_arrives(pipeline, imu, attitude):
    run(pipeline, still(imu, 0.0, 1.0))
    level = (1.0, 0.0, 0.0, 0.0)
    said = []
    for k in range(20):
        t_s = 1.0 + k * DT
        both = [imu(t_s), attitude(t_s, level), attitude(t_s, level, "ATTITUDE_QUATERNION")]
        said += verdicts(run(pipeline, both))
    assert {v.source for v in said[-10:]} == {"ATTITUDE_QUATERNION"}
    run(pipeline, still(imu, 1.4, 3.0))
    assert [v.source for v in verdicts(run(pipeline, [attitude(3.0, level)]))] == ["ATTITUDE"]


def test_a_reference_that_stops_leaves_no_verdict(pipeline, imu, attitude):
    run(pipeline, interleave(imu, attitude, 0.0, 2.0, lambda _: (1.0, 0.0, 0.0, 0.0)))
    run(pipeline, still(imu, 2.0, 3.0))
    said = verdicts(pipeline.poll(3_000_000_000))
    assert [(v.agreement, v.reason) for v in said] == [(Agreement.UNDECIDED, "no-reference")]


def test_attitudes_of_an_unknown_frame_have_a_reason_of_their_own(pipeline, imu, attitude):
    """ATTITUDE_QUATERNION of firmware 4.0 is that of its secondary estimator."""
    level = (1.0, 0.0, 0.0, 0.0)
    pipeline.handle(HeartbeatSample("HEARTBEAT", 1, 1, 0, 2, 3, False, 3, VehicleKind.ROTARY))
    pipeline.handle(FirmwareSample("AUTOPILOT_VERSION", 1, 1, 0, (4, 0, 3)))

    def both(from_s, to_s, source):
        return interleave(imu, lambda t_s, q: attitude(t_s, q, source), from_s, to_s, lambda _: level)

    said = verdicts(run(pipeline, both(0.0, 2.0, "ATTITUDE_QUATERNION")))
    assert [(v.agreement, v.reason, v.source) for v in said] == [(Agreement.UNDECIDED, "unknown-frame", "")]
    assert verdicts(run(pipeline, both(2.0, 3.0, "ATTITUDE")))[-1].reason == "agrees"
    assert [v.reason for v in verdicts(run(pipeline, both(3.0, 6.0, "ATTITUDE_QUATERNION")))] == ["unknown-frame"]
    run(pipeline, still(imu, 6.0, 7.2))
    assert [v.reason for v in verdicts(pipeline.poll(7_200_000_000))] == ["no-reference"]


def test_a_split_run_equals_a_whole_one(imu):
    samples = [imu(k * DT, yaw=0.01 * k, rate=0.5, accel=(0.3, 0.1 * (k % 3), -G_MPS2)) for k in range(200)]
    whole = estimates(run(Pipeline(PipelineSettings(), GradientDescent()), samples))
    parts = Pipeline(PipelineSettings(), GradientDescent())
    split = estimates(run(parts, samples[:77])) + estimates(run(parts, samples[77:]))
    assert [e.q_nb for e in whole] == [e.q_nb for e in split]


def test_a_backlog_leads_to_estimates_that_do_not_hold(pipeline, imu):
    run(pipeline, still(imu, 0.0, 2.0))
    held = []
    for sample in still(imu, 2.0, 12.0):
        late = ImuSample("RAW_IMU", 1, 1, sample.t_ns, 12_000_000_000, sample.gyro, sample.accel, sample.mag)
        (estimate,) = estimates(pipeline.handle(late))
        if pipeline.estimate is estimate:
            held.append(12.0 - estimate.t_ns * 1e-9)
    assert held
    assert max(held) < 0.6, "no estimate older than stale_s (0.5 s) holds, but for what jitter allows"


def armed(t_s, is_armed):
    return HeartbeatSample("HEARTBEAT", 1, 1, round(t_s * 1e9), 2, 3, is_armed, 4)


@pytest.mark.parametrize(("is_armed", "expected"), [(True, 0.0), (False, 0.05), (None, 0.0)])
def test_a_steady_rate_is_a_bias_only_of_a_vehicle_that_stands(pipeline, imu, is_armed, expected):
    if is_armed is not None:
        pipeline.handle(armed(0.0, is_armed))
    last = estimates(run(pipeline, still(imu, 0.0, 1.0, rate=0.05)))[-1]
    assert 0.05 - last.rates[2] == pytest.approx(expected, abs=1e-9)


def test_aligning_again_in_a_slow_turn_keeps_the_bias_learned_on_the_ground(pipeline, imu):
    bias = 0.006
    pipeline.handle(armed(0.0, is_armed=False))
    run(pipeline, still(imu, 0.0, 2.0, rate=bias))
    pipeline.handle(armed(2.0, is_armed=True))
    turning = [imu(5.0 + k * DT, yaw=0.02 * k * DT, rate=bias + 0.02) for k in range(200)]
    last = estimates(run(pipeline, turning))[-1]
    assert last.rates[2] == pytest.approx(0.02, abs=1e-9)


def trim(t_s, degrees_):
    return ParameterSample("PARAM_VALUE", 1, 1, round(t_s * 1e9), "AHRS_TRIM_X", Setting.TRIM_X, radians(degrees_))


@pytest.mark.parametrize(("size", "expected"), [(5.0, Agreement.UNDECIDED), (0.3, Agreement.AGREE)])
def test_a_trim_that_is_changed_in_flight_is_followed_but_not_vouched_for(pipeline, imu, attitude, size, expected):
    """The attitudes agree but for the trim, and nothing tells which trim is right, until the vehicle has landed."""
    level = (1.0, 0.0, 0.0, 0.0)
    pipeline.handle(armed(0.0, is_armed=True))
    run(pipeline, interleave(imu, attitude, 0.0, 5.0, lambda _: level))
    assert pipeline.verdict.agreement == Agreement.AGREE
    pipeline.handle(trim(5.0, size))
    leaning = q_from_euler(radians(-size), 0.0, 0.0)
    said = verdicts(run(pipeline, interleave(imu, attitude, 5.0, 10.0, lambda _: leaning)))
    assert (said[-1].agreement, said[-1].tilt) == (expected, pytest.approx(0.0, abs=1e-6))
    pipeline.handle(armed(10.0, is_armed=False))
    said = verdicts(run(pipeline, interleave(imu, attitude, 10.0, 12.0, lambda _: leaning)))
    assert said[-1].agreement == Agreement.AGREE


def test_a_trim_that_is_changed_back_is_vouched_for_again(pipeline, imu, attitude):
    level = (1.0, 0.0, 0.0, 0.0)
    pipeline.handle(armed(0.0, is_armed=True))
    run(pipeline, interleave(imu, attitude, 0.0, 5.0, lambda _: level))
    pipeline.handle(trim(5.0, 5.0))
    run(pipeline, interleave(imu, attitude, 5.0, 10.0, lambda _: q_from_euler(radians(-5.0), 0.0, 0.0)))
    assert pipeline.verdict.reason == "offset"
    pipeline.handle(trim(10.0, 0.0))
    run(pipeline, interleave(imu, attitude, 10.0, 12.0, lambda _: level))
    assert pipeline.verdict.agreement == Agreement.AGREE
