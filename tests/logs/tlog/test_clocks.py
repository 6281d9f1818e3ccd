"""Clocks of real firmware and recorders: each is made time since boot, or named for what it is."""

import pytest

from attest_mav.logs.formats import open_source
from attest_mav.logs.tlog.clocks import date_of
from attest_mav.logs.tlog.reader import tlog_record
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window

UNIX_US = 1_780_000_000_000_000
WRAP_US = 1 << 32
YEAR_NS = 31_556_952 * 10**9


def flight(log, imu_us, seconds=40.0, boot_ms=600_000, imu_hz=20, system_time=None, attitude_after_ms=0.0):
    """A vehicle that stands and rolls once by the attitude's account; imu_us: time since boot (us) to the time sent."""
    log.heartbeat()
    log.place()
    for k in range(int(seconds * imu_hz)):
        t_ms = boot_ms + 1000 * k / imu_hz
        rx_ms = t_ms - boot_ms
        log.add("RAW_IMU", rx_ms, {"time_usec": imu_us(round(1000 * t_ms)), "zacc": -1000, "xmag": 200, "zmag": 440})
        if k % 2 == 0:
            log.add("ATTITUDE", rx_ms + attitude_after_ms, {"time_boot_ms": round(t_ms + attitude_after_ms)})
        if system_time is not None and k % imu_hz == 0:
            log.add("SYSTEM_TIME", rx_ms, system_time(round(t_ms)))


def report(data, **options):
    request = Request(window=Window(skip_s=2.0), **options)
    return as_json("log", replay(open_source(data, "log"), request, Outputs()))


def all_compared(result, seconds=40.0, imu_hz=20):
    (one,) = result["filters"]
    return one["samples"] > (seconds - 15.0) * imu_hz and one["tilt_deg"]["max"] < 0.1


def notes(result, part):
    return [note for note in result["notes"] if part in note]


SENT = {
    "boot": (lambda us: us, ""),
    "milliseconds": (lambda us: us // 1000, "is in milliseconds in the place of microseconds"),
    "nanoseconds": (lambda us: us * 1000, "is in nanoseconds in the place of microseconds"),
    "unix": (lambda us: us + UNIX_US, "is UNIX time; no SYSTEM_TIME tells when the vehicle booted"),
    "another epoch": (lambda us: us + 77_000_000, "does not count from boot"),
    "still": (lambda _: 0, "stands still at 0 us: the times of arrival are taken instead"),
    "still elsewhere": (lambda _: 12_345_678, "stands still at 12345678 us"),
    "wraps": (lambda us: (us + WRAP_US - 620_000_000) % WRAP_US, "begins again at 2^32 (1 time in this log)"),
}


@pytest.mark.parametrize(("imu_us", "note"), SENT.values(), ids=SENT)
def test_times_of_the_inertial_message_become_time_since_boot(log, imu_us, note):
    # Of the clock that wraps the attitudes show that it has another zero, too.
    flight(log, imu_us)
    result = report(log.data)
    assert all_compared(result)
    assert result["imu"]["rate_hz"] == pytest.approx(20.0, abs=0.01)
    assert result["duration_s"] == pytest.approx(40.0, abs=0.2)
    assert len(notes(result, "the time of RAW_IMU")) == (1 if note else 0)
    assert notes(result, note) or not note


def test_a_wrap_continues_the_time_since_boot(log):
    flight(log, lambda us: us % WRAP_US, boot_ms=WRAP_US // 1000 - 20_000)
    result = report(log.data)
    assert all_compared(result)
    assert notes(result, "2^32 (1 time in this log)")


def test_a_log_that_begins_behind_a_wrap_is_brought_to_the_attitudes_times(log):
    flight(log, lambda us: us % WRAP_US, boot_ms=3 * WRAP_US // 1000 + 50_000)
    result = report(log.data)
    assert all_compared(result)
    assert notes(result, "3 turns of a counter of 32 bits")


def test_a_simulator_whose_boot_is_1970_is_read_by_the_last_32_bits(log):
    log.heartbeat()
    log.place()
    for k in range(800):
        t_ms = UNIX_US // 1000 + 50 * k
        folded = {"time_boot_ms": t_ms % (1 << 32)}
        log.add("RAW_IMU", 50 * k, {"time_usec": 1000 * t_ms, "zacc": -1000, "xmag": 200, "zmag": 440})
        log.add("ATTITUDE", 50 * k, folded)
        if k % 20 == 0:
            log.add("SYSTEM_TIME", 50 * k, folded)
    assert all_compared(report(log.data))


def test_unix_time_with_a_system_time_needs_no_remark(log):
    flight(
        log,
        lambda us: us + UNIX_US,
        system_time=lambda boot_ms: {"time_unix_usec": UNIX_US + 1000 * boot_ms, "time_boot_ms": boot_ms},
    )
    result = report(log.data)
    assert result["filters"][0]["samples"] > 400
    assert notes(result, "the time of RAW_IMU") == []


@pytest.mark.parametrize("after_ms", [-5.0, 5.0, 40.0])
def test_a_shifted_clock_is_set_by_arrival_and_not_by_the_nearest_attitude(log, after_ms):
    # 40 ms behind the inertial message an attitude is nearer to the next one: only the arrivals tell which is right.
    flight(log, lambda us: us + UNIX_US, attitude_after_ms=after_ms)
    source = open_source(log.data, "log")
    source.summary()
    rule = source._clocks.sensor((1, 1), "RAW_IMU").rule
    assert rule.shift == pytest.approx(-UNIX_US, abs=1000)


def test_two_vehicles_with_one_id_are_named(log):
    log.heartbeat()
    for k in range(400):
        for clock_us in (600_000_000, 1_540_000_000):
            log.add("RAW_IMU", 50 * k, {"time_usec": clock_us + 50_000 * k, "zacc": -1000})
            log.add("ATTITUDE", 50 * k, {"time_boot_ms": (clock_us + 50_000 * k) // 1000})
    result = report(log.data)
    assert notes(result, "two vehicles with the id 1/1")
    assert notes(result, "940.0 s apart") or notes(result, "939.9 s apart")
    assert result["duration_s"] == pytest.approx(20.0, abs=0.1)


def test_a_reboot_is_no_second_vehicle(log):
    flight(log, lambda us: us)
    first = log.data
    flight(log, lambda us: us, boot_ms=5_000)
    assert notes(report(log.data), "two vehicles") == []
    assert len(log.data) > len(first)


def test_a_handful_of_readings_is_too_few_and_says_so(log):
    flight(log, lambda us: us, seconds=0.2)
    with pytest.raises(Exception, match="4 RAW_IMU, fewer than the 5 that are needed to know its units") as caught:
        report(log.data)
    assert caught.value.exit_code == 65


def stamped_anew(data, new_ns):
    """The log with its times of arrival replaced; new_ns: arrival (ns) to the new one."""
    out, at = b"", 0
    while at < len(data):
        end = at + 20 + data[at + 9]
        rx_ns = 1000 * int.from_bytes(data[at : at + 8], "big")
        out += tlog_record(new_ns(rx_ns), data[at + 8 : end])
        at = end
    return out


def middle_ns(data):
    return 1000 * int.from_bytes(data[:8], "big") + 20 * 10**9


@pytest.mark.parametrize(
    ("step_ns", "said"), [(-3600 * 10**9, "-3600 s"), (10 * YEAR_NS, "+315569520 s"), (120 * 10**9, "+120 s")]
)
def test_a_recorder_whose_clock_is_set_does_not_change_the_duration(log, step_ns, said):
    flight(log, lambda us: us)
    middle = middle_ns(log.data)
    result = report(stamped_anew(log.data, lambda rx: rx + step_ns if rx > middle else rx))
    assert result["duration_s"] == pytest.approx(40.0, abs=0.2)
    (note,) = notes(result, "times of arrival step")
    assert said in note


def test_squeezed_times_of_arrival_are_no_duration(log):
    flight(log, lambda us: us)
    begin = middle_ns(log.data) - 20 * 10**9
    result = report(stamped_anew(log.data, lambda rx: begin + (rx - begin) // 4))
    assert result["duration_s"] == pytest.approx(40.0, abs=0.2)
    assert notes(result, "times of arrival do not run with the vehicle's clock")


def test_times_of_arrival_that_stand_still_are_no_duration(log):
    flight(log, lambda us: us)
    result = report(stamped_anew(log.data, lambda _: 10**18))
    assert result["duration_s"] == pytest.approx(40.0, abs=0.2)
    assert notes(result, "stand still or are no times")
    assert all_compared(result)


def test_a_sensor_and_a_recorder_whose_clocks_stand_still_are_named(log):
    flight(log, lambda _: 0)
    result = report(stamped_anew(log.data, lambda _: 10**18))
    assert notes(result, "stands still at 0 us, and the log has no times of arrival to take instead")
    assert result["filters"][0]["tilt_deg"] is None


def test_a_pause_of_the_radio_is_no_step(log):
    flight(log, lambda us: us)
    middle = middle_ns(log.data)
    result = report(stamped_anew(log.data, lambda rx: max(rx, middle + 3 * 10**9) if rx > middle else rx))
    assert notes(result, "times of arrival") == []


def test_a_bare_stream_is_read_by_the_vehicles_clock_wherever_it_begins(log):
    flight(log, lambda us: us)
    log.heartbeat(40_000)
    stream, at = b"", 0
    while at < len(log.data):
        end = at + 20 + log.data[at + 9]
        stream += log.data[at + 8 : end]
        at = end
    stamped = report(log.data)
    for begin in (0, 7):
        result = report(stream[begin:])
        assert result["format"] == "mavlink"
        assert result["duration_s"] == pytest.approx(40.0, abs=0.2)
        assert result["filters"][0]["samples"] == stamped["filters"][0]["samples"]
        assert notes(result, "a bare MAVLink stream")


Y2014, Y2026, Y2036, Y2060 = (int((year - 1970) * YEAR_NS) for year in (2014, 2026, 2036, 2060))
DATES = {
    "the recorder's": ([Y2026], None, 2026, ""),
    "the recorder's, near the receiver's": ([Y2026], Y2026 // 1000 + 10**9, 2026, ""),
    "the receiver's": ([Y2014], Y2026 // 1000, 2026, "SYSTEM_TIME's (2026.0) is taken"),
    "one before or behind a step": ([Y2036, Y2026, Y2036], None, 2026, "2026.0 is taken"),
    "none": ([Y2060], None, 2060, "(2060.0) is not that of the flight; for the declination no other is known"),
    "a stream's": ([], Y2026 // 1000, 2026, ""),
    "a stream's without a receiver": ([], None, 1970, "the log tells no date"),
}


@pytest.mark.parametrize(("arrivals", "told_us", "year", "note"), DATES.values(), ids=DATES)
def test_the_date_is_the_most_plausible_one(arrivals, told_us, year, note):
    date = date_of(arrivals, told_us)
    assert 1970 + date.unix_s * 1e9 / YEAR_NS == pytest.approx(year, abs=0.01)
    assert note in date.note
    assert bool(note) == bool(date.note)
