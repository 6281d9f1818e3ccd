"""The flight filter as a whole: what it reaches, what it survives, and what it says of itself."""

import copy
from math import degrees, inf, nan, pi, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attest_mav.algebra import q_norm
from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.velocity_aided.control import AidingMode
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.types import North

from .conftest import RECEIVER, changed, gusty, rms, wing, with_inputs, with_reading

# --- what it reaches ------------------------------------------------------------------------------------------------


def test_s_turns_and_gusts_to_a_twentieth_of_a_degree(plane_log, copter_log):
    for flight in (plane_log, copter_log):
        states = flight.run()
        tilt, heading = flight.errors(states)
        assert rms(tilt[1500:]) < 0.05
        assert rms(heading[1500:]) < 0.1
        assert VelocityAided().valid(states[-1])
        assert states[-1].navigation.mode == AidingMode.VELOCITY


def test_it_finds_the_delays(s_turns, telemetry):
    """GPS 0.16 s and compass 0.11 s late, against the 0.10 and 0.055 believed; both lag by less behind the low-pass."""
    flight = telemetry(s_turns, fix_delay_s=0.16, mag_lag_s=0.11)
    states = flight.run(VelocityAided(FlightParameters(low_pass_delay_sigma=0.0)))
    estimate = states[-1].navigation.estimate
    assert estimate.fix_lag_s == pytest.approx(0.16 - 0.01125, abs=0.01)
    assert estimate.mag_lag_s == pytest.approx(0.11 - 0.01125, abs=0.01)
    assert rms(flight.errors(states)[0][1500:]) < 0.1


def test_it_finds_what_calibration_left(s_turns, telemetry):
    bias, iron = (radians(0.4), radians(-0.3), radians(0.2)), (0.008, -0.006, 0.0)
    flight = telemetry(
        s_turns, integer=False, gyro_bias=bias, hard_iron=iron, gyro_noise=1e-3, accel_noise=0.1, mag_noise=2e-3
    )
    estimate = flight.run()[-1].navigation.estimate
    assert np.degrees(estimate.gyro_bias) == pytest.approx(np.degrees(bias), abs=0.05)
    assert estimate.hard_iron[:2] == pytest.approx(iron[:2], abs=0.003)


def test_a_wrong_declination_is_corrected_by_the_velocity(plane_log):
    wrong = changed(plane_log, lambda _k, s, a: (s, with_inputs(a, declination=a.declination + radians(1.5))))
    states = wrong.run()
    _, heading = wrong.errors(states)
    assert rms(heading[100:400]) == pytest.approx(1.5, abs=0.2)
    assert rms(heading[-1500:]) < 0.3
    assert degrees(states[-1].navigation.estimate.declination_error) == pytest.approx(-1.5, abs=0.3)


def test_a_declination_that_comes_late_turns_the_heading(plane_log):
    late = changed(plane_log, lambda k, s, a: (s, with_inputs(a, declination=nan if k < 300 else a.declination)))
    states = late.run(last=400)
    _, heading = late.errors(states)
    assert states[250].referred_to == North.MAGNETIC
    assert heading[250] == pytest.approx(-3.0, abs=0.2)
    assert states[-1].referred_to == North.TRUE
    assert heading[-1] == pytest.approx(0.0, abs=0.2)


@pytest.mark.parametrize("rate_hz", [100.0, 10.0, 4.0])
def test_at_any_rate_sigma_tells_the_truth(s_turns, telemetry, rate_hz):
    # A mean of 10 Hz is 45 ms late when it is new, and half an interval later when a message first shows it.
    flight = telemetry(s_turns, rate_hz=rate_hz, mag_lag_s=0.045 + 0.5 * min(1.0 / rate_hz, 0.1))
    states = flight.run()
    tilt, heading = flight.errors(states)
    flown = slice(round(30 * rate_hz), None)
    sigma = np.degrees([[s.tilt_sigma, s.heading_sigma] for s in states])
    assert np.mean(tilt[flown] < 3.0 * sigma[flown, 0]) > 0.99
    assert np.mean(np.abs(heading[flown]) < 3.0 * sigma[flown, 1]) > 0.99
    assert rms(tilt[flown]) < {100.0: 0.05, 10.0: 0.3, 4.0: 1.5}[rate_hz]


# --- what it survives -----------------------------------------------------------------------------------------------


def without_fixes(flight, first, last):
    """The flight as it is when the receiver falls silent: the newest fix stays the newest, then is too old."""
    return changed(
        flight,
        lambda k, s, a: (
            (s, with_inputs(a, velocity=None if k >= first + 100 else flight.inputs[first].velocity))
            if first <= k < last
            else (s, a)
        ),
    )


def test_lost_fixes_are_coasted_over_with_growing_sigma(copter_log):
    outage = without_fixes(copter_log, 2500, 4000)
    states = outage.run(last=4000)
    tilt, _ = outage.errors(states)
    assert tilt[3999] < 1.0
    assert states[3999].navigation.mode == AidingMode.COASTING
    assert degrees(states[3999].tilt_sigma) > 1.5 * degrees(states[2490].tilt_sigma)
    assert tilt[3999] < 3.0 * degrees(states[3999].tilt_sigma)


def test_a_wing_goes_on_with_its_airspeed(s_turns, telemetry):
    outage = without_fixes(telemetry(s_turns, airspeed=True), 2500, 6000)
    states = outage.run()
    tilt, heading = outage.errors(states)
    assert states[-1].navigation.mode == AidingMode.AIRSPEED
    assert np.nanmax(tilt[2500:]) < 1.0
    assert np.nanmax(np.abs(heading[2500:])) < 1.5


def test_a_copter_falls_back_on_gravity_after_a_while(copter_log):
    outage = without_fixes(copter_log, 2000, 5000)
    tilt, _ = outage.errors(outage.run())
    states = outage.run()
    assert states[-1].navigation.mode == AidingMode.GRAVITY
    assert states[-1].accel_used
    assert np.nanmax(tilt[2000:]) < 3.0


def test_no_velocity_at_all(copter_log):
    blind = changed(copter_log, lambda k, s, a: (s, with_inputs(a, velocity=None, zero_mean_velocity=k < 500)))
    states = blind.run()
    tilt, heading = blind.errors(states)
    assert states[300].navigation.mode == AidingMode.STATIONARY
    assert rms(tilt[1500:]) < 2.5
    assert np.mean(tilt[1500:] < 3.0 * np.degrees([s.tilt_sigma for s in states[1500:]])) > 0.99
    assert rms(heading[1500:]) < 3.0


def test_a_disturbed_field_turns_the_heading_little(plane_log):
    """0.1 gauss on the body's x for 20 s would turn a compass by 27 degrees."""
    disturbed = changed(
        plane_log,
        lambda k, s, a: (with_reading(s, mag=(s.mag[0] + 0.1, *s.mag[1:])) if 3000 <= k < 4000 else s, a),
    )
    states = disturbed.run()
    tilt, heading = disturbed.errors(states)
    assert np.nanmax(np.abs(heading[3000:])) < 2.0
    assert np.nanmax(tilt[3000:]) < 1.0
    assert states[3500].navigation.magnetometer.disturbance > 0.03


def test_without_a_field_the_velocity_holds_the_heading(plane_log):
    lost = changed(plane_log, lambda k, s, a: (with_reading(s, mag=None) if k >= 2000 else s, a))
    states = lost.run()
    _, heading = lost.errors(states)
    assert np.nanmax(np.abs(heading[2000:])) < 2.0
    assert states[-1].heading_sigma > states[1990].heading_sigma
    assert not states[-1].mag_used


@pytest.mark.parametrize("heading", [-2.4, 2.4])
def test_without_a_field_ever_motion_shows_the_heading_and_the_tilt_stays_honest(telemetry, heading):
    flight = telemetry(
        gusty(60.0, still_s=5.0, heading=heading), gyro_bias=(0.004, -0.003, 0.005), accel_bias=(0.05, -0.06, 0.04),
        fix_noise=0.05, gyro_noise=1e-3, accel_noise=0.05,
    )  # fmt: skip
    blind = changed(flight, lambda _k, s, a: (with_reading(s, mag=None), a))
    states = blind.run()
    tilt, found = blind.errors(states)
    assert states[200].referred_to == North.RELATIVE
    assert states[-1].referred_to == North.TRUE
    assert np.mean(tilt[500:] < 3.0 * np.degrees([s.tilt_sigma for s in states[500:]])) > 0.99
    assert rms(found[-1000:]) < 2.0


def test_a_gap_keeps_the_bias_and_aligns_again(s_turns, telemetry):
    flight = telemetry(s_turns, gyro_bias=(radians(0.5), 0.0, radians(-0.4)))
    kept = [k for k in range(len(flight.samples)) if not 3000 <= k < 3200]
    gap = copy.copy(flight)
    gap.samples, gap.inputs, gap.truth = (
        [values[k] for k in kept] for values in (flight.samples, flight.inputs, flight.truth)
    )
    states = gap.run()
    tilt, _ = gap.errors(states)
    assert not states[3000].aligned
    assert states[3000].navigation is not None
    assert states[3150].aligned
    assert np.nanmax(tilt[3001:]) < 2.0
    assert np.degrees(states[3150].gyro_bias) == pytest.approx([0.5, 0.0, -0.4], abs=0.15)


def test_a_wrong_attitude_is_given_up(plane_log):
    """Fixes of another motion contradict the attitude: alignment begins again, and ends when they are right."""
    north = VelocitySample("GPS_RAW_INT", 1, 1, 0, 0, (0.0, 0.0, 0.0), False, RECEIVER)

    def other(k, sample, inputs):
        if not 3000 <= k < 3300:
            return sample, inputs
        v = inputs.velocity
        turned = (-v.v_ned[1], v.v_ned[0], 0.0)
        return sample, with_inputs(inputs, velocity=VelocitySample(v.source, 1, 1, v.t_ns, 0, turned, False, RECEIVER))

    assert north.v_ned[0] == 0.0
    states = changed(plane_log, other).run()
    tilt, _ = plane_log.errors(states)
    assert any(not s.aligned for s in states[3000:3400])
    assert states[-1].aligned
    assert rms(tilt[-1000:]) < 0.3


def test_a_wild_fix_now_and_then_does_not_cost_the_attitude(plane_log):
    def wild(k, sample, inputs):
        v = inputs.velocity
        if not (1200 <= k < 1400 and k // 10 % 5 == 0):  # one fix in five
            return sample, inputs
        return sample, with_inputs(
            inputs, velocity=VelocitySample(v.source, 1, 1, v.t_ns, 0, (650.0, 0.0, 0.0), False, RECEIVER)
        )

    states = changed(plane_log, wild).run(last=1500)
    assert all(s.aligned for s in states[1200:])
    tilt, heading = plane_log.errors(states)
    assert np.nanmax(tilt[1200:]) < 1.5
    assert np.nanmax(np.abs(heading[1200:])) < 1.5


def test_fixes_that_freeze_lead_astray_but_sigma_says_so(plane_log):
    """A receiver that repeats one velocity makes an attitude of its own: it is shown with doubt, until that fades."""

    def frozen(k, sample, inputs):
        v = inputs.velocity
        if not 3000 <= k < 3800:
            return sample, inputs
        still = VelocitySample(v.source, 1, 1, v.t_ns, 0, (20.0, 0.0, 0.0), False, RECEIVER)
        return sample, with_inputs(inputs, velocity=still)

    states = changed(plane_log, frozen).run(last=5500)
    tilt, heading = plane_log.errors(states)
    after = [k for k in range(3000, 5500) if states[k].aligned and states[k].reset_sigma > 0.0]
    assert max(tilt[after]) > 20.0
    assert np.nanmean([tilt[k] < 3.0 * degrees(states[k].tilt_sigma) for k in after]) > 0.99
    assert np.nanmean([abs(heading[k]) < 3.0 * degrees(states[k].heading_sigma) for k in after]) > 0.99
    assert not any(VelocityAided().valid(states[k]) for k in after if tilt[k] > 3.0)
    assert rms(tilt[-500:]) < 0.3
    assert degrees(states[-1].tilt_sigma) < 5.0


@pytest.mark.parametrize("airspeed", [True, False])
def test_a_start_in_motion_without_a_velocity_is_a_guess_and_says_so(circles, telemetry, airspeed):
    """A wing that circles feels its own axis for gravity: the attitude is 40 degrees wrong, and sigma has to say it."""
    flight = telemetry(circles, airspeed=airspeed)
    states = changed(flight, lambda _, s, a: (s, with_inputs(a, velocity=None))).run(first=500)
    tilt, _ = flight.errors(states, first=500)
    shown = [k for k, s in enumerate(states) if s.aligned]
    assert not any(VelocityAided().valid(states[k]) for k in shown if tilt[k] > 3.0)
    if airspeed:
        assert np.mean([tilt[k] < 3.0 * degrees(states[k].tilt_sigma) for k in shown]) > 0.99


def test_a_start_in_motion_names_the_velocity_once_it_has_a_row(plane_log):
    texts = list(dict.fromkeys(s.rests_on for s in plane_log.run(first=1500, last=1700)))
    assert texts == ["", "just aligned", "velocity from GPS_RAW_INT"]


FLIGHTS = {
    AidingMode.VELOCITY: {},
    AidingMode.STATIONARY: {"zero_mean_velocity": True},
    AidingMode.COASTING: {},
    AidingMode.AIRSPEED: wing(20.0),
    AidingMode.GRAVITY: {},
    AidingMode.ZERO_MEAN_VELOCITY: {"zero_mean_velocity": True},
}
"""What each mode needs besides fixes, or their loss."""


def in_mode(flight, mode):
    """700 samples of the flight in one mode, from take-off on; at rest from the first sample on."""
    never = mode in {AidingMode.STATIONARY, AidingMode.GRAVITY, AidingMode.ZERO_MEAN_VELOCITY}
    lost_from = 0 if never else 10**6 if mode == AidingMode.VELOCITY else 800

    def change(k, sample, inputs):
        return sample, with_inputs(inputs, velocity=None if k >= lost_from else inputs.velocity, **FLIGHTS[mode])

    return changed(flight, change), 0 if mode == AidingMode.STATIONARY else 450


@pytest.mark.parametrize("mode", list(AidingMode))
def test_a_split_run_is_a_whole_one_bit_for_bit(plane_log, copter_log, mode):
    flight, first = in_mode(plane_log if mode == AidingMode.AIRSPEED else copter_log, mode)
    last, cut = first + 700, first + 480
    whole = flight.run(first=first, last=last)
    assert mode in {state.navigation.mode for state in whole[400:480] if state.aligned}
    rest = flight.run(state=whole[cut - first - 1], first=cut, last=last)
    again = flight.run(first=first, last=last)
    for other in (rest[-1], again[-1]):
        assert other.q_nb == whole[-1].q_nb
        assert (other.tilt_sigma, other.heading_sigma) == (whole[-1].tilt_sigma, whole[-1].heading_sigma)
        assert other.navigation.estimate.velocity == whole[-1].navigation.estimate.velocity
        assert other.gyro_bias == whole[-1].gyro_bias


BAD = st.sampled_from([nan, inf, -inf, 0.0, 1e30, -1e30, 1e-300])
NUMBER = BAD | st.floats(-50.0, 50.0)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER)


@pytest.fixture(scope="module")
def navigating(plane_log):
    """The state after twenty seconds."""
    return plane_log.run(last=1000)[-1]


@settings(derandomize=True, max_examples=40, deadline=None)
@given(
    readings=st.lists(st.tuples(VECTOR, VECTOR, st.none() | VECTOR, st.floats(1e-3, 0.9), st.booleans()), max_size=12)
)
def test_no_reading_breaks_it(plane_log, navigating, readings):
    """Whatever comes, the quaternion is a unit one, and good readings afterwards bring the attitude back."""
    chosen = VelocityAided()
    state = navigating
    t_ns = plane_log.samples[999].t_ns
    for gyro, accel, mag, dt_s, saturated in readings:
        t_ns += round(dt_s * 1e9)
        state = chosen.step(
            state, dt_s, ImuSample("RAW_IMU", 1, 1, t_ns, t_ns, gyro, accel, mag, saturated), FilterInputs()
        )
        assert q_norm(state.q_nb) == pytest.approx(1.0, abs=1e-9)
        assert state.tilt_sigma >= 0.0
    shift = t_ns - plane_log.samples[999].t_ns
    for k in range(1000, 1400):
        sample, fix = plane_log.samples[k], plane_log.inputs[k].velocity
        moved = ImuSample(
            "RAW_IMU", 1, 1, sample.t_ns + shift, 0, sample.gyro, sample.accel, sample.mag, quantum=sample.quantum
        )
        moved_fix = VelocitySample(fix.source, 1, 1, fix.t_ns + shift, 0, fix.v_ned, False, RECEIVER)
        state = chosen.step(state, 0.02, moved, with_inputs(plane_log.inputs[k], velocity=moved_fix))
    assert state.aligned


def test_an_accelerometer_without_a_value_is_bridged(plane_log):
    holes = changed(plane_log, lambda k, s, a: (with_reading(s, accel=(nan, nan, nan)) if k % 10 == 0 else s, a))
    tilt, _ = holes.errors(holes.run())
    assert rms(tilt[1500:]) < 1.0


@pytest.mark.parametrize("has_fixes", [True, False])
def test_a_dead_accelerometer_gives_no_attitude_and_does_no_harm(plane_log, has_fixes):
    """An accelerometer of zeros in flight, from the start or later: nothing is claimed until it comes back."""

    def dead(k, sample, inputs):
        inputs = inputs if has_fixes else with_inputs(inputs, velocity=None)
        return (with_reading(sample, accel=(0.0, 0.0, 0.0)) if k < 2000 else sample), inputs

    states = changed(plane_log, dead).run(first=1500, last=3000)
    assert not any(s.aligned for s in states[:500])
    assert states[-1].aligned
    if has_fixes:
        tilt, _ = plane_log.errors(states, first=1500)
        assert np.nanmax(tilt[-250:]) < 3.0


@pytest.mark.parametrize("speed", [nan, inf, 1e30])
def test_a_speed_that_is_none_is_not_read(plane_log, speed):
    """As a velocity, and as an airspeed when there is none."""
    lost = VelocitySample("GPS_RAW_INT", 1, 1, 0, 0, (speed, 0.0, 0.0), False, RECEIVER)

    def change(k, sample, inputs):
        if k < 1500:
            return sample, inputs
        late = VelocitySample(lost.source, 1, 1, sample.t_ns, 0, lost.v_ned, False, RECEIVER)
        return sample, with_inputs(inputs, velocity=late, **wing(speed))

    flight = changed(plane_log, change)
    states = flight.run(first=1000, last=1800)
    tilt, _ = flight.errors(states, 1000)
    assert all(state.aligned for state in states[500:])
    assert states[-1].navigation.mode == AidingMode.COASTING
    assert np.max(tilt[500:]) < 0.5


@pytest.mark.parametrize("falls", [False, True])
def test_a_start_without_a_force_waits(plane_log, falls):
    """An accelerometer that shows nothing has no direction, whether it is dead or falls freely."""
    state = None
    for k, sample in enumerate(plane_log.samples[1000:1500]):
        v = (0.0, 0.0, 9.80665 * sample.t_ns * 1e-9 if falls else 0.0)
        fix = VelocitySample("GPS_RAW_INT", 1, 1, sample.t_ns, 0, v, True, RECEIVER)
        nothing = ImuSample(
            "RAW_IMU", 1, 1, sample.t_ns, 0, sample.gyro, (0.0, 0.0, 0.0), sample.mag, quantum=sample.quantum
        )
        if k == 0:
            state = VelocityAided().initial(
                Start((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), North.RELATIVE, nothing.accel, None, at_rest=False)
            )
        state = VelocityAided().step(state, 0.02, nothing, with_inputs(plane_log.inputs[1000 + k], velocity=fix))
        assert not state.aligned
        assert q_norm(state.q_nb) == pytest.approx(1.0)


def test_a_clock_that_wraps_costs_no_fixes(plane_log):
    """time_boot_ms has 32 bits; the sensor goes on, only its numbers begin anew."""
    wrap = 4_294_967_296_000_000

    def change(_k, sample, inputs):
        shift = wrap - 40 * 10**9
        fix, t_ns = inputs.velocity, (sample.t_ns + shift) % wrap
        late = VelocitySample(fix.source, 1, 1, (fix.t_ns + shift) % wrap, 0, fix.v_ned, False, RECEIVER)
        moved = ImuSample("RAW_IMU", 1, 1, t_ns, 0, sample.gyro, sample.accel, sample.mag, quantum=sample.quantum)
        return moved, with_inputs(inputs, velocity=late)

    flight = changed(plane_log, change)
    chosen, state, states = VelocityAided(), None, []
    for sample, inputs in zip(flight.samples[1200:2600], flight.inputs[1200:2600], strict=True):
        if state is None:
            state = chosen.initial(
                Start((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), North.RELATIVE, sample.accel, sample.mag, at_rest=False)
            )
        state = chosen.step(state, 0.02, sample, inputs)
        states.append(state)
    tilt, _ = flight.errors(states, 1200)
    assert states[-1].navigation.mode == AidingMode.VELOCITY
    assert all(state.navigation.gnss.since_fused_s < 1.5 for state in states[400:])
    assert np.max(tilt[600:]) < 0.5


def test_before_anything_it_says_nothing(plane_log):
    sample = plane_log.samples[0]
    state = VelocityAided().initial(
        Start((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), North.RELATIVE, sample.accel, sample.mag, at_rest=False)
    )
    assert not state.aligned
    assert state.tilt_sigma == pi
    assert not VelocityAided().valid(state)
    assert state.referred_to == North.RELATIVE


def test_the_low_pass_of_the_vehicle_is_a_parameter(s_turns, telemetry):
    """Without the right group delay the attitude lags by the turn rate times what is missing."""
    flight = telemetry(s_turns)
    none, told = (VelocityAided(FlightParameters(low_pass_hz=hz, low_pass_delay_sigma=0.0)) for hz in (0.0, 20.0))
    tilt, _ = flight.errors(flight.run(none, last=3000))
    right, _ = flight.errors(flight.run(told, last=3000))
    assert rms(tilt[1500:]) > 3.0 * rms(right[1500:])


def test_an_hour_on_the_ground_teaches_nothing_of_the_sensors(telemetry, copter):
    """With fixes: noise must not be taken for motion that shows scales, delays, and the accelerometer's bias."""
    rng = np.random.default_rng(2)
    flight = telemetry(copter)
    still, inputs = flight.samples[10], flight.inputs[10]
    chosen = VelocityAided()
    state = chosen.initial(Start((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), North.RELATIVE, still.accel, still.mag, False))
    for k in range(1, 4 * 3600):
        t_ns = k * 250_000_000
        gyro, accel, mag, v = (
            tuple(float(x) for x in rng.normal(mean, sigma))
            for mean, sigma in (
                ((0.004, -0.003, 0.005), 5e-4),
                (still.accel, 0.05),
                (still.mag, 1e-3),
                ((0.0, 0.0, 0.0), 0.07),
            )
        )
        fix = VelocitySample("GPS_RAW_INT", 1, 1, t_ns, 0, (v[0], v[1], 0.0), False, RECEIVER)
        state = chosen.step(
            state, 0.25, ImuSample("HIGHRES_IMU", 1, 1, t_ns, t_ns, gyro, accel, mag), with_inputs(inputs, velocity=fix)
        )
    estimate = state.navigation.estimate
    assert estimate.gyro_scale == pytest.approx((0.0, 0.0, 0.0), abs=5e-4)
    assert (estimate.mag_lag_s, estimate.fix_lag_s) == pytest.approx((0.04375, 0.08875), abs=0.005)
    assert estimate.accel_bias == pytest.approx((0.0, 0.0, 0.0), abs=0.03)
    assert np.linalg.norm(estimate.hard_iron) < 0.01
    assert degrees(state.heading_sigma) > 2.0
