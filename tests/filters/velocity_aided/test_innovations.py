"""Each aid of the flight filter leaves a record in each step that it has something to say, used or not."""

from math import isnan, nan

import numpy as np
import pytest

from attest_mav.filters.base import FilterInputs
from attest_mav.filters.velocity_aided.covariance_blocks import ErrorBlock
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.innovation import Aid, Fusion, Innovation

from .conftest import DECLINATION, DIP, FIELD, changed, wing


def records(states, aid):
    """The records of one aid, in order."""
    return [one for state in states for one in state.innovations if one.aid == aid]


def with_fix(change, first=1000, last=1300):
    """An edit of the fixes between two samples; the same fix stays the same one."""
    changed = {}

    def edit(k, sample, inputs):
        if not first <= k < last:
            return sample, inputs
        fix = inputs.velocity
        changed.setdefault(id(fix), change(fix))
        return sample, inputs.with_velocity(changed[id(fix)])

    return edit


def with_field(change, first=1000, last=1300):
    """An edit of the magnetometer between two samples."""

    def edit(k, sample, inputs):
        if not first <= k < last:
            return sample, inputs
        return sample.with_readings(sample.gyro, sample.accel, change(sample.mag)), inputs

    return edit


def test_the_nis_is_the_mean_over_the_scalar_measurements():
    one = Innovation(Aid.VELOCITY, Fusion.USED, 0, (1.0, 2.0), (0.3, -0.4), (0.09, 0.04))
    assert one.nis == pytest.approx((1.0 + 4.0) / 2.0)
    assert isnan(Innovation(Aid.VELOCITY, Fusion.TOO_OLD, 0).nis)
    used = {fusion for fusion in Fusion if Innovation(Aid.GRAVITY, fusion, 0).is_used}
    assert used == {Fusion.USED, Fusion.INFLATED}


def test_each_new_fix_has_one_record(plane_log):
    states = plane_log.run(first=1000, last=1400)
    for k, state in enumerate(states[200:], 1200):
        fix, found = plane_log.inputs[k].velocity, records([state], Aid.VELOCITY)
        assert len(found) == (fix is not plane_log.inputs[k - 1].velocity)
        for one in found:
            assert (one.fusion, one.t_ns, one.observation) == (Fusion.USED, fix.t_ns, fix.v_ned[:2])
            assert np.abs(one.residual).max() < 0.2
            assert min(one.variance) > 0.05**2


def test_a_wild_fix_is_fused_with_an_inflated_variance(plane_log):
    states = changed(plane_log, with_fix(lambda fix: fix.with_velocity((650.0, 0.0, 0.0)))).run(first=800, last=1012)
    last = records(states, Aid.VELOCITY)[-1]
    assert last.fusion == Fusion.INFLATED
    assert last.residual[0] > 600.0
    assert last.nis > 36.0


@pytest.mark.parametrize(
    ("change", "fusion"),
    [
        (lambda fix: fix.with_time(fix.t_ns - 1_000_000_000), Fusion.TOO_OLD),
        (lambda fix: fix.with_time(fix.t_ns + 1_000_000_000), Fusion.TOO_OLD),
        (lambda fix: fix.with_velocity((nan, 0.0, 0.0)), Fusion.IMPLAUSIBLE),
        (lambda fix: fix.with_velocity((1e30, 0.0, 0.0)), Fusion.IMPLAUSIBLE),
    ],
)
def test_a_fix_that_cannot_be_used_says_why(plane_log, change, fusion):
    states = changed(plane_log, with_fix(change)).run(first=800, last=1200)
    assert {one.fusion for one in records(states[205:], Aid.VELOCITY)} == {fusion}
    assert not any(one.residual for one in records(states[205:], Aid.VELOCITY))


def test_magnetometer_readings(plane_log):
    usual = records(plane_log.run(first=800, last=1000)[100:], Aid.MAGNETOMETER)
    assert {one.fusion for one in usual} == {Fusion.USED}
    assert len(usual) == pytest.approx(20, abs=1)
    turned = changed(plane_log, with_field(lambda mag: (mag[0] + 0.3, mag[1] - 0.3, mag[2]))).run(first=800, last=1010)
    first = next(one for one in records(turned[200:], Aid.MAGNETOMETER) if one.fusion != Fusion.USED)
    assert first.fusion == Fusion.INFLATED
    assert first.nis > 16.0
    for absurd in ((0.0, 0.0, 0.0), (1e30, 0.0, 0.0)):
        states = changed(plane_log, with_field(lambda _, absurd=absurd: absurd)).run(first=800, last=1010)
        assert [one.fusion for one in records(states[200:], Aid.MAGNETOMETER)] == [Fusion.IMPLAUSIBLE]
        assert not states[-1].mag_used


def without_velocity(**others):
    """An edit that takes all fixes away."""
    return lambda _, sample, inputs: (
        sample,
        FilterInputs(declination=inputs.declination, inclination=inputs.inclination, **others),
    )


def test_zero_motion_is_used_without_fixes_and_left_out_with_them(copter_log):
    still = changed(copter_log, without_velocity(zero_mean_velocity=True)).run(last=490)
    rates, velocities = records(still, Aid.ZERO_RATE), records(still, Aid.ZERO_VELOCITY)
    assert len(rates) == len(velocities) > 50
    assert {one.fusion for one in velocities} == {Fusion.USED}
    assert rates[0].fusion == Fusion.USED
    assert Fusion.UNINFORMATIVE in {one.fusion for one in rates[-20:]}
    assert rates[0].residual == pytest.approx((0.0, 0.0, 0.0), abs=0.01)
    with_fixes = copter_log.run(last=490)
    assert {one.fusion for one in records(with_fixes, Aid.ZERO_VELOCITY)} == {Fusion.REDUNDANT}


def test_airspeed(plane_log):
    def change(speed):
        def edit(k, sample, inputs):
            fix = inputs.velocity if k < 1000 else None
            aid = wing(20.0 if k < 1300 else speed)
            return sample, FilterInputs(
                velocity=fix, declination=DECLINATION, inclination=DIP, zero_mean_velocity=False, **aid
            )

        return edit

    used = changed(plane_log, change(20.0)).run(first=600, last=1340)
    assert {one.fusion for one in records(used, Aid.AIRSPEED)} == {Fusion.USED}
    assert records(used, Aid.AIRSPEED)[-1].observation == (20.0, 0.0, 0.0)
    wild = changed(plane_log, change(200.0)).run(first=600, last=1340)
    assert records(wild, Aid.AIRSPEED)[-1].fusion == Fusion.INFLATED


def test_gravity_and_zero_mean_velocity(copter_log):
    for aid, assumed in ((Aid.GRAVITY, False), (Aid.ZERO_MEAN_VELOCITY, True)):
        calm = changed(copter_log, without_velocity(zero_mean_velocity=assumed))

        def shoved(k, sample, inputs):
            push = (60.0, 0.0, 0.0) if k >= 1400 else (0.0, 0.0, 0.0)
            accel = tuple(a + p for a, p in zip(sample.accel, push, strict=True))
            return sample.with_readings(sample.gyro, accel, sample.mag), inputs

        used = records(calm.run(first=600, last=1400)[400:], aid)
        assert len(used) > 50
        assert np.mean([one.fusion == Fusion.USED for one in used]) > (0.1 if assumed else 0.99)
        hard = records(changed(calm, shoved).run(first=600, last=1500)[800:], aid)
        assert np.mean([one.fusion == Fusion.INFLATED for one in hard]) > 0.9


def test_an_alignment_has_no_records(plane_log):
    states = plane_log.run(first=1000, last=1100)
    assert not any(state.innovations for state in states if not state.aligned)


# --- what a monitor of several lanes needs of the state -------------------------------------------------------------


def test_a_step_can_be_taken_again_without_its_fix(plane_log):
    """With the last fix that was fused in place of the new one, everything else being equal."""
    states = plane_log.run(first=800, last=1100)
    k = next(k for k in range(1090, 1000, -1) if records([states[k - 800]], Aid.VELOCITY))
    before, earlier = states[k - 801], plane_log.inputs[k - 1].velocity
    again = VelocityAided().step(before, 0.02, plane_log.samples[k], plane_log.inputs[k].with_velocity(earlier))
    assert not records([again], Aid.VELOCITY)
    assert again.navigation.estimate.velocity != states[k - 800].navigation.estimate.velocity
    assert again.navigation.gnss.last is earlier


def test_a_hypothesis_about_one_error_is_run_again_from_a_changed_covariance(plane_log):
    """A gyro that stepped by 3 degrees a second: with room for a step in its bias the filter finds it at once."""
    chosen, step = VelocityAided(), np.radians(3.0)

    def stepped(k, sample, inputs):
        gyro = (sample.gyro[0] + (step if k >= 1200 else 0.0), *sample.gyro[1:])
        return sample.with_readings(gyro, sample.accel, sample.mag), inputs

    flight = changed(plane_log, stepped)
    at_step = flight.run(first=800, last=1200)[-1]
    roomy = at_step.navigation.estimate.with_added_variance(ErrorBlock.GYRO_BIAS, (step**2,) * 3)
    assert chosen.with_estimate(at_step, at_step.navigation.estimate).q_nb == at_step.q_nb
    informed = flight.run(state=chosen.with_estimate(at_step, roomy), first=1200, last=1400)[-1]
    uninformed = flight.run(state=at_step, first=1200, last=1400)[-1]
    bias = at_step.gyro_bias[0] + step
    assert abs(informed.gyro_bias[0] - bias) < 0.2 * step
    assert abs(uninformed.gyro_bias[0] - bias) > 2.0 * abs(informed.gyro_bias[0] - bias)


def test_a_velocity_without_ties_takes_the_receivers_offset_and_leaves_the_attitude(plane_log):
    chosen = VelocityAided()
    flight = changed(
        plane_log, with_fix(lambda fix: fix.with_velocity((fix.v_ned[0] + 5.0, *fix.v_ned[1:])), 1200, 1400)
    )
    before = flight.run(first=800, last=1200)[-1]
    free = before.navigation.estimate.decoupled(ErrorBlock.VELOCITY, 100.0)
    after = flight.run(state=chosen.with_estimate(before, free), first=1200, last=1400)
    tilt, _ = flight.errors(after, first=1200)
    assert max(tilt) < 0.3
    truth = plane_log.inputs[1399].velocity.v_ned[0] + 5.0
    assert after[-1].navigation.estimate.velocity[0] == pytest.approx(truth, abs=4.0)


def test_the_fields_residual_is_small_in_a_good_state(plane_log):
    chosen, reference = VelocityAided(), np.array(FIELD) / np.linalg.norm(FIELD)
    states = plane_log.run(first=800, last=1200)
    found = chosen.field_residual(states[-1], plane_log.samples[1199], tuple(float(x) for x in reference))
    assert np.linalg.norm(found.residual) < 0.03
    assert np.linalg.eigvalsh(np.array(found.covariance)).min() > -1e-12
    assert chosen.field_residual(states[0], plane_log.samples[0], (1.0, 0.0, 0.0)) is None
