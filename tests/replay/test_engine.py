"""Replays of logs made message by message, with errors that are known."""

from math import degrees

import pytest

from attest_mav.errors import UnreadableDataError
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window

OURS = GradientDescent()
ALL = Window(skip_s=0.0)


class Rows:
    def __init__(self):
        self.rows = []

    def write(self, row):
        self.rows.append(row)

    def of(self, name):
        return [row for row in self.rows if row.name == name]


def fly(log, window=ALL, imu=None, reference=None, declination_deg=None, filters=(OURS,), outputs=None):
    request = Request(filters, imu, reference, declination_deg, window)
    return replay(TlogSource(log.data, log.dialect), request, outputs or Outputs())


def report(log, **options):
    return as_json("log", fly(log, **options))


def test_the_object_has_the_keys_of_the_contract(log):
    log.heartbeat()
    log.still_flight(3.0)
    result = report(log)
    assert result["log"] == "log"
    assert result["format"] == "tlog"
    assert result["frames"] == 1 + 3 * 151
    assert result["bad_bytes"] == 0
    assert result["duration_s"] == pytest.approx(4.0)
    assert result["imu"] == {"message": "RAW_IMU", "samples": 151, "rate_hz": pytest.approx(50.0), "gaps": 0}
    assert result["reference"] == {"message": "SIM_STATE", "samples": 151, "sigma": None}
    assert result["smoothed"] is None
    assert [one["name"] for one in result["filters"]] == ["gradient-descent"]
    assert {"rms", "p95", "max"} <= set(result["filters"][0]["tilt_deg"])
    assert result["autopilot"]["message"] == "ATTITUDE"


def test_a_wrong_autopilot_is_seen_beside_a_right_filter(log):
    log.heartbeat()
    log.place()
    log.still_flight(3.0, yaw_deg=0.66, own_roll_deg=3.0)
    result = report(log)
    assert result["north"]["reference"] == "true"
    assert result["north"]["declination_deg"] == pytest.approx(0.66, abs=0.01)
    assert "ArduPilot's simulator" in result["north"]["source"]
    assert result["filters"][0]["tilt_deg"]["max"] == pytest.approx(0.0, abs=1e-3)
    assert result["filters"][0]["heading_deg"]["max"] == pytest.approx(0.0, abs=0.1)
    assert result["autopilot"]["tilt_deg"]["rms"] == pytest.approx(3.0, abs=1e-4)
    assert result["autopilot"]["heading_deg"]["max"] == pytest.approx(0.0, abs=1e-4)


def test_a_log_of_a_real_flight_has_the_field_of_its_day(log):
    log.heartbeat()
    log.place()
    for k in range(151):
        log.attitude(1000 + 20 * k, yaw_deg=1.3)
        log.imu(1000 + 20 * k)
    result = report(log)
    assert result["reference"]["message"] == "ATTITUDE"
    assert result["north"]["declination_deg"] == pytest.approx(1.3, abs=0.1)
    assert result["north"]["source"].startswith("WMM")
    assert result["filters"][0]["heading_deg"]["max"] == pytest.approx(0.0, abs=0.1)


def test_a_given_declination_is_taken(log):
    log.heartbeat()
    log.place()
    log.still_flight(3.0, yaw_deg=10.0)
    result = report(log, declination_deg=7.0)
    assert result["north"] == {"reference": "true", "declination_deg": 7.0, "source": "given"}
    assert result["filters"][0]["heading_deg"]["rms"] == pytest.approx(3.0, abs=1e-3)


def test_without_a_declination_headings_are_magnetic_and_not_compared(log):
    log.heartbeat()
    log.still_flight(3.0, yaw_deg=10.0)
    result = report(log)
    assert result["north"] == {"reference": "magnetic", "declination_deg": None, "source": None}
    assert result["filters"][0]["heading_deg"] is None
    assert result["filters"][0]["tilt_deg"]["rms"] < 0.01
    assert any("headings are not compared" in note and "--declination" in note for note in result["notes"])


def test_a_position_without_fix_is_not_believed(log):
    log.heartbeat()
    log.add("GPS_RAW_INT", 0, {"fix_type": 1, "lat": 10, "lon": 10})
    log.still_flight(1.0)
    assert report(log)["north"]["reference"] == "magnetic"


def test_skip_leaves_out_the_first_seconds_after_alignment(log):
    log.heartbeat()
    log.still_flight(4.0)
    rows = Rows()
    flown = fly(log, Window(skip_s=2.0), outputs=Outputs(rows))
    ours, own = rows.of("gradient-descent"), rows.of("autopilot")
    aligned_s = ours[0].attitude.elapsed_s
    assert 0.0 < aligned_s < 1.0
    for row in (*ours, *own):
        assert row.attitude.counted == (row.attitude.elapsed_s >= aligned_s + 2.0)
    assert flown.flight.runs[0].comparison.errors.samples == sum(row.attitude.counted for row in ours) > 50
    assert flown.flight.autopilot.errors.samples == sum(row.attitude.counted for row in own) > 50


def test_start_and_end_restrict_what_is_read(log):
    log.heartbeat()
    log.still_flight(6.0)
    result = report(log, window=Window(1.0, 3.0, 0.0))
    assert result["imu"]["samples"] == 101
    assert result["reference"]["samples"] == pytest.approx(101, abs=1)
    assert result["window"] == {"start_s": 1.0, "end_s": 3.0, "skip_s": 0.0}
    with pytest.raises(UnreadableDataError, match="the part to be read has none"):
        report(log, window=Window(100.0, 200.0, 0.0))


def test_a_replay_equals_itself_bit_for_bit_and_filters_do_not_touch_each_other(data_cut, dialect):
    def columns(*filters):
        request = Request(filters, window=Window(skip_s=1.0))
        flown = replay(TlogSource(data_cut, dialect), request, Outputs())
        errors = [run.comparison.errors for run in flown.flight.runs]
        return [(list(one._tilt.values), list(one._heading.values)) for one in errors]

    slow, quick = GradientDescent(beta=0.033), GradientDescent(beta=0.5)
    together = columns(slow, quick)
    assert together == [*columns(slow), *columns(quick)]
    assert together == columns(slow, quick)
    assert together[0] != together[1]


def test_with_attitude_as_reference_there_is_no_autopilot_row(log):
    log.heartbeat()
    log.still_flight(3.0, own_roll_deg=2.0)
    result = report(log, reference="ATTITUDE")
    assert result["autopilot"] is None
    assert result["filters"][0]["tilt_deg"]["rms"] == pytest.approx(2.0, abs=1e-3)


def test_without_any_reference_the_figures_are_null(log):
    log.heartbeat()
    for t_ms in range(1000, 3000, 20):
        log.imu(t_ms)
    result = report(log)
    assert result["reference"] is None
    assert result["autopilot"] is None
    assert result["filters"][0]["samples"] == 0
    assert result["filters"][0]["tilt_deg"] is None
    assert result["filters"][0]["heading_deg"] is None


def test_without_a_magnetometer_only_the_tilt_is_compared(log):
    log.heartbeat()
    for t_ms in range(1000, 6000, 20):
        log.attitude(t_ms)
        log.add("RAW_IMU", t_ms, {"time_usec": t_ms * 1000, "zacc": -1000, "xgyro": t_ms // 20 % 2})
        log.truth(t_ms)
    one = report(log)["filters"][0]
    assert one["samples"] > 100
    assert one["tilt_deg"] is not None
    assert one["heading_deg"] is None


def test_attitudes_of_other_components_are_no_reference(log):
    log.heartbeat()
    log.heartbeat(autopilot=8, sender=(1, 193))
    for t_ms in range(1000, 4000, 20):
        log.attitude(t_ms)
        log.imu(t_ms)
        log.add("ATTITUDE_QUATERNION", t_ms, {"time_boot_ms": t_ms, "q1": 1.0}, sender=(1, 193))
    result = report(log)
    assert result["reference"] == {"message": "ATTITUDE", "samples": 150, "sigma": None}


def test_of_two_vehicles_the_one_with_more_samples_is_taken_and_the_other_named(log):
    log.heartbeat()
    log.heartbeat(sender=(7, 1))
    for t_ms in range(1000, 4000, 20):
        log.imu(t_ms, sender=(7, 1))
        if t_ms % 100 == 0:
            log.imu(t_ms)
    result = report(log)
    assert result["vehicle"] == {"system": 7, "component": 1}
    assert result["imu"]["samples"] == 150
    assert any("1/1" in note for note in result["notes"])


def test_a_restarted_autopilot_goes_on_being_compared(log):
    log.heartbeat()
    log.still_flight(4.0, start_ms=900_000)
    log.still_flight(4.0, start_ms=2_000)
    rows = Rows()
    result = fly(log, Window(skip_s=1.0), outputs=Outputs(rows))
    errors = result.flight.runs[0].comparison.errors
    assert errors.samples > 250
    assert degrees(max(errors._tilt.values)) < 0.01
    times = [row.attitude.elapsed_s for row in rows.of("gradient-descent")]
    assert times == sorted(times)
    assert times[-1] == pytest.approx(8.0, abs=0.1)


def with_gap_in_truth(log, roll_after_deg):
    """Still inertial messages, and a truth with a pause from 2.00 s to 2.98 s and another roll behind it."""
    log.heartbeat()
    for k in range(250):
        t_ms = 1000 + 20 * k
        log.imu(t_ms)
        if not 100 <= k < 150:
            log.attitude(t_ms)
            log.truth(t_ms, roll_deg=roll_after_deg if k >= 150 else 0.0)
    rows = Rows()
    fly(log, outputs=Outputs(rows))
    return rows.of("gradient-descent")


def test_truth_is_not_stretched_over_a_gap_in_which_it_turned_unseen(log):
    missing = [row.attitude.elapsed_s for row in with_gap_in_truth(log, 40.0) if row.tilt is None]
    # Right beside the last and the first truth the rates there still tell the attitude.
    inside = [0.02 * k for k in range(100, 150)]
    assert set(map(round, (50 * t for t in missing))) >= set(range(108, 141))
    assert min(missing) > inside[0]
    assert max(missing) < inside[-1]


def test_truth_that_stands_is_known_in_its_gaps_too(log):
    assert [row for row in with_gap_in_truth(log, 0.0) if row.tilt is None] == []


def test_a_log_cut_in_the_middle_of_a_frame_is_read_up_to_there(log):
    log.heartbeat()
    log.still_flight(3.0)
    whole = report(log)
    log.data = log.data[:-7]
    cut = report(log)
    assert cut["frames"] == whole["frames"] - 1
    assert 0 < cut["bad_bytes"] < 100
    assert cut["imu"]["samples"] == whole["imu"]["samples"]


def test_garbage_is_skipped_and_counted(log):
    log.heartbeat()
    log.still_flight(2.0)
    log.data += bytes(range(200))
    log.still_flight(2.0, start_ms=3020)
    result = report(log)
    assert result["bad_bytes"] == 200
    assert result["imu"]["samples"] == 202


def test_truth_without_attitude_takes_its_times_from_the_inertial_messages(log):
    log.heartbeat()
    for t_ms in range(1000, 4000, 20):
        log.imu(t_ms)
        log.truth(t_ms, roll_deg=2.0)
    result = report(log)
    assert result["filters"][0]["samples"] > 100
    assert result["filters"][0]["tilt_deg"]["rms"] == pytest.approx(2.0, abs=1e-3)


def test_when_nothing_could_be_compared_a_note_says_so(log):
    log.heartbeat()
    log.still_flight(3.0)
    assert not any("nothing was compared" in note for note in report(log)["notes"])
    assert any("nothing was compared" in note for note in report(log, window=Window(skip_s=60.0))["notes"])


def test_a_filter_that_found_no_attitude_is_not_put_down_to_the_reference(log):
    log.heartbeat()
    log.still_flight(3.0)
    notes = report(log, window=Window(end_s=0.1, skip_s=0.0))["notes"]
    assert "nothing was compared: gradient-descent found no attitude" in notes


def test_progress_grows_to_nearly_one(log):
    log.heartbeat()
    log.still_flight(100.0)
    shares = []
    fly(log, outputs=Outputs(progress=shares.append))
    assert shares == sorted(shares)
    assert 0.0 < shares[0] < shares[-1] <= 1.0


def test_a_log_without_heartbeats_is_said_to_lack_them(log):
    for k in range(100):
        log.imu(20.0 * k)
    with pytest.raises(
        UnreadableDataError, match=r"no usable RAW_IMU: the log has no HEARTBEAT of system 1's autopilot"
    ):
        report(log)


def test_units_nobody_knows_are_refused_with_a_reason(log):
    log.heartbeat(autopilot=12)
    for t_ms in range(1000, 3000, 20):
        log.imu(t_ms)
    with pytest.raises(UnreadableDataError, match=r"RAW_IMU.*raw values"):
        report(log)


def test_imu_messages_before_the_first_heartbeat_are_understood(log):
    for t_ms in range(1000, 2000, 20):
        log.imu(t_ms)
    log.heartbeat(2000)
    assert report(log)["imu"]["samples"] == 50


def chosen(data, dialect):
    """Name of the filter that a log gets when nobody names one, and the notes about it."""
    result = as_json("log", replay(TlogSource(data, dialect), Request(window=ALL), Outputs()))
    (one,) = result["filters"]
    return one["name"], [note for note in result["notes"] if "velocity" in note]


def test_a_log_with_a_velocity_needs_no_remark(data_cut, dialect):
    assert chosen(data_cut, dialect) == ("velocity-aided", [])


def test_a_log_without_gets_the_same_filter_and_a_remark(data_cut, dialect, without):
    name, (note,) = chosen(without(data_cut, dialect.id_of("GPS_RAW_INT")), dialect)
    assert name == "velocity-aided"
    assert note == "no velocity in the log: it has no GPS_RAW_INT; velocity-aided goes by gravity instead"


def test_a_receiver_without_a_fix_is_no_velocity(log):
    log.heartbeat()
    for k in range(3):
        log.add("GPS_RAW_INT", k, {"fix_type": 1, "vel": 100, "cog": 0})
    log.still_flight(2.0)
    _, (note,) = chosen(log.data, log.dialect)
    assert "none of 3 GPS_RAW_INT has a 3-D fix with one" in note


def test_a_velocity_of_another_vehicle_is_none_of_this_one(log):
    log.heartbeat()
    log.add("GPS_RAW_INT", 0, {"fix_type": 3, "vel": 100, "cog": 0}, sender=(7, 1))
    log.still_flight(2.0)
    _, (note,) = chosen(log.data, log.dialect)
    assert "it has no GPS_RAW_INT" in note


def test_a_filter_that_is_named_is_taken_whatever_the_log_has(log):
    log.heartbeat()
    log.place()
    log.still_flight(2.0)
    result = report(log)
    assert [one["name"] for one in result["filters"]] == ["gradient-descent"]
    assert not any("velocity" in note for note in result["notes"])
