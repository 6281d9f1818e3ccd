"""A snapshot holds all that a reader needs, and readers do not disturb each other."""

import copy
import pickle
from math import isfinite

import pytest

from attest_mav.estimation.events import Agreement
from attest_mav.service.link_records import Traffic
from attest_mav.service.snapshot import rates_between
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings
from attest_mav.vehicle_settings import Setting

SECOND = 1_000_000_000
RAW_IMU = 27


def sim(scenario="still", faults=(), **settings):
    return SimSettings(scenario=scenario, fast_rate_hz=50.0, faults=parse_faults(faults), **settings)


def counters(snapshot):
    """A second reader, as an exporter of metrics would be: names and numbers, out of nothing but a snapshot."""
    values = {
        "samples_total": snapshot.samples,
        "warnings_total": snapshot.notes.warnings,
        "up": snapshot.vehicle is not None,
    }
    for link in snapshot.links:
        values[f'frames_total{{link="{link.name}"}}'] = link.frames
        values[f'bad_bytes_total{{link="{link.name}"}}'] = link.bad_bytes
        values[f'received_bytes_total{{link="{link.name}"}}'] = link.traffic.received_bytes
        values[f'attitudes_total{{link="{link.name}"}}'] = link.attitudes_sent
    for stream in snapshot.streams:
        values[f'stream_hz{{message="{stream.name}"}}'] = stream.achieved_hz
    for lane in snapshot.lanes:
        values[f'lane_samples_total{{lane="{lane.source}"}}'] = lane.samples
        if lane.estimate is not None:
            values[f'tilt_sigma{{lane="{lane.source}"}}'] = lane.estimate.tilt_sigma
    return values


def test_a_second_reader_takes_its_counters_from_a_snapshot_alone(flight):
    f = flight()
    before = counters(f.snapshot())
    assert before["samples_total"] == before["up"] == 0
    f.run_until(6.0)
    received = sum(map(len, f.raw))
    after = counters(f.service.snapshot(f.now_ns, [Traffic(is_up=True, received_bytes=received)]))
    assert after["samples_total"] == pytest.approx(300, abs=10)
    assert after['lane_samples_total{lane="RAW_IMU"}'] == pytest.approx(300, abs=10)
    assert after['attitudes_total{link="udpin::0"}'] == len(f.of_type("ATTITUDE_QUATERNION"))
    assert after['received_bytes_total{link="udpin::0"}'] == received
    assert after['stream_hz{message="RAW_IMU"}'] == pytest.approx(50.0, abs=1.0)
    assert 0.0 < after['tilt_sigma{lane="RAW_IMU"}'] < 0.1
    assert after["up"]
    assert all(after[name] >= before[name] for name in before)


def test_no_rate_is_told_while_the_vehicle_is_away(flight):
    f = flight()
    f.run_until(6.0)
    assert all(stream.achieved_hz > 0.0 for stream in f.snapshot().streams if stream.name in {"RAW_IMU", "ATTITUDE"})
    f.deaf_to = set(range(512))
    f.run_until(14.0)
    away = f.snapshot()
    assert not away.vehicle.is_present
    assert [stream.achieved_hz for stream in away.streams] == [0.0] * len(away.streams)
    f.deaf_to = set()
    f.run_until(20.0)
    assert {stream.name: stream.achieved_hz for stream in f.snapshot().streams}["RAW_IMU"] == pytest.approx(50, abs=2)


def test_readers_have_rates_of_their_own(flight):
    """One looks every second, the other every four: neither shortens the time that the other counts over."""
    f = flight()
    f.run_until(4.0)
    seldom = often = f.snapshot()
    for second in range(5, 9):
        f.run_until(float(second))
        now = f.snapshot()
        assert rates_between(often, now).samples == pytest.approx(50.0, abs=1.0)
        often = now
    rates = rates_between(seldom, often)
    assert rates.samples == pytest.approx(50.0, abs=0.5)
    assert rates.published == pytest.approx(20.0, abs=0.5)


def test_a_snapshot_does_not_change_any_more(flight):
    f = flight()
    f.run_until(5.0)
    snapshot = f.snapshot()
    before = pickle.dumps(snapshot)
    assert f.snapshot() == snapshot
    f.run_until(9.0)
    assert pickle.dumps(snapshot) == before
    assert f.snapshot() != snapshot
    with pytest.raises(AttributeError):
        copy.copy(snapshot).samples = 0


def test_the_verdict_has_stood_since_it_changed(flight):
    f = flight("", sim(faults=["attitude-offset-north=29@6"]))
    f.run_until(5.9)
    agreed = f.snapshot().verdict
    assert agreed.verdict.agreement is Agreement.AGREE
    f.run_until(12.0)
    standing = f.snapshot().verdict
    assert standing.verdict.agreement is Agreement.DISAGREE
    assert agreed.since_ns < 6 * SECOND < standing.since_ns < standing.verdict.rx_ns
    said = next(t_s for t_s, one in f.heard if one.get_type() == "HEARTBEAT" and one.system_status == 5)
    assert standing.since_ns <= said * SECOND


def test_the_vehicle_and_what_is_known_of_it_are_seen(flight):
    f = flight()
    assert f.snapshot().vehicle is None
    f.run_until(6.0)
    vehicle = f.snapshot().vehicle
    assert (vehicle.system, vehicle.component, vehicle.autopilot, vehicle.link) == (1, 1, 3, 0)
    assert vehicle.is_present
    assert vehicle.settings.low_pass_hz == 20.0
    assert vehicle.field.inclination < 0.0
    f.service.poll(11 * SECOND)  # nothing has come since
    assert not f.snapshot().vehicle.is_present


def test_requests_and_refusals_are_seen(flight):
    f = flight("[streams]\nimu_messages = ['HIGHRES_IMU', 'RAW_IMU']", sim(first_fix_s=3.0))
    f.run_until(2.9)
    (refusal,) = (one for one in f.snapshot().refusals if one.source == "GPS_RAW_INT")
    assert (refusal.source, refusal.reason) == ("GPS_RAW_INT", "GPS_RAW_INT of system 1: no 3-D fix (fix type 1)")
    assert refusal.messages > 0
    f.run_until(6.0)
    snapshot = f.snapshot()
    asked = {"RAW_IMU", "SCALED_IMU2", "SCALED_IMU3", "ATTITUDE", "GPS_RAW_INT", "VFR_HUD"}
    asked |= {"EKF_STATUS_REPORT", "SYS_STATUS", "AHRS2"}
    assert {stream.name for stream in snapshot.streams} == asked
    assert (snapshot.inertial, snapshot.inertial_stream.answer) == ("RAW_IMU", "accepted")
    (after,) = (one for one in snapshot.refusals if one.source == "GPS_RAW_INT")
    assert after.reason == "", "it gives samples now"
    assert after.messages >= refusal.messages


def test_warnings_and_errors_are_counted(flight):
    f = flight("", sim(faults=["imu-silent@3+2"]))
    f.run_until(2.9)
    assert (f.snapshot().notes.warnings, f.snapshot().notes.errors) == (0, 0)
    f.run_until(6.0)
    assert f.snapshot().notes.warnings == len([note for note in f.notes if note.level == 30]) > 0


def test_what_is_known_of_the_vehicle_outlives_its_inertial_message(flight):
    """The next message starts with the settings, the kind and the field of the first."""
    f = flight("[streams]\nimu_messages = ['RAW_IMU', 'SCALED_IMU2']\nfurther_imu_messages = []")
    f.run_until(6.0)
    before = f.snapshot()
    f.deaf_to.add(RAW_IMU)
    f.run_until(16.0)
    after = f.snapshot()
    assert ([lane.source for lane in before.lanes], [lane.source for lane in after.lanes]) == (
        ["RAW_IMU"],
        ["SCALED_IMU2"],
    )
    known = [one for one in Setting if isfinite(before.vehicle.settings.get(one))]
    assert {Setting.LOW_PASS_HZ, Setting.TRIM_X, Setting.ACCEL_1_DEVICE} <= set(known)
    assert [after.vehicle.settings.get(one) for one in known] == [before.vehicle.settings.get(one) for one in known]
    assert after.vehicle.field is before.vehicle.field
    assert f.of_type("ATTITUDE_QUATERNION", 15.0)
