"""What a ground station and the log are told of the verdict and of the lanes."""

import itertools

import pytest

from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings

CRITICAL, WARNING, NOTICE = 2, 4, 5
TWO_LANES = "[streams]\nfurther_imu_messages = ['SCALED_IMU2']\n"


def sim(scenario, faults=()):
    return SimSettings(scenario=scenario, fast_rate_hz=50.0, faults=parse_faults(faults))


def announced(f, begin_s=0.0):
    """Times, severities and whole texts; chunks are joined."""
    texts = []
    for t_s, one in f.heard:
        if one.get_type() == "STATUSTEXT" and t_s >= begin_s:
            if one.chunk_seq:
                texts[-1] = (*texts[-1][:2], texts[-1][2] + one.text)
            else:
                texts.append((t_s, one.severity, one.text))
    return texts


def test_a_wrong_attitude_and_its_end_are_announced(flight):
    f = flight("", sim("square", ["attitude-offset-north=12@20+10"]))
    f.run_until(35.0)
    first, wrong, right = announced(f)
    assert first[1] == NOTICE
    assert first[2].startswith("attest: agrees tilt 0.")
    assert wrong[1] == CRITICAL
    assert 20.3 < wrong[0] < 21.5
    assert wrong[2].startswith("attest: DISAGREES tilt 12.")
    assert right[1] == NOTICE
    assert 30.0 < right[0] < 31.0
    length_s = right[0] - wrong[0]
    assert right[2] == f"attest: agrees; was off {length_s:.1f} s, tilt up to 12.1"
    assert all(len(text) <= 50 for _, _, text in (first, wrong, right)), "one chunk each"


def test_every_interval_of_the_verdict_is_logged_with_its_numbers(flight):
    f = flight("", sim("square", ["attitude-offset-north=12@20+10"]))
    f.run_until(35.0)
    f.stop()
    lines = [text.removeprefix("verdict interval: ") for text in f.texts if text.startswith("verdict interval")]
    assert [line.split(" ")[0] for line in lines] == ["UNDECIDED", "AGREE", "DISAGREE", "AGREE"]
    assert lines[2].startswith("DISAGREE (tilt) for 9.")
    assert "tilt up to 12.1 heading " in lines[2]
    assert lines[2].endswith("; RAW_IMU used; SCALED_IMU2 used")


def test_a_faulty_sensor_is_announced_with_axis_and_size(flight):
    f = flight(TWO_LANES, sim("square", ["gyro1-bias-x=5@20+8"]))
    f.run_until(50.0)
    texts = [(severity, text) for _, severity, text in announced(f, 15.0) if "RAW_IMU" in text]
    assert texts[0][0] == WARNING
    assert texts[0][1].startswith("attest: RAW_IMU: gyro x +5.0 degrees per second off")
    assert texts[1] == (NOTICE, "attest: RAW_IMU: reads like the other sensor again: it is used")
    (line,) = [text for text in f.texts if text.startswith("verdict interval: DISAGREE")]
    assert "RAW_IMU set aside: gyro x +5.0 degrees per second off" in line
    assert line.endswith("SCALED_IMU2 used")


def test_texts_are_at_least_a_second_apart_and_few(flight):
    faults = [f"attitude-offset-north={begin // 3}@{begin}+3" for begin in range(15, 70, 6)]
    f = flight("", sim("square", faults))
    f.run_until(75.0)
    texts = announced(f)
    times = [t_s for t_s, _, _ in texts]
    assert all(later - earlier >= 0.999 for earlier, later in itertools.pairwise(times))
    assert sum(1 for _, severity, _ in texts if severity == CRITICAL) == 10, "every accusation is told"
    assert sum(1 for t_s, severity, _ in texts if severity != CRITICAL and t_s < times[0] + 60.0) <= 6


@pytest.mark.parametrize(("scenario", "severity"), [("square", WARNING), ("still", NOTICE)])
def test_a_doubt_after_agreement_is_a_warning_in_flight_only(flight, scenario, severity):
    f = flight("", sim(scenario))
    f.run_until(30.0)
    f.deaf_to.add(30)  # ATTITUDE
    f.run_until(33.0)
    assert announced(f)[-1][2].startswith("attest: agrees"), "a short doubt is not told"
    f.run_until(60.0)
    f.deaf_to.clear()
    f.run_until(75.0)
    told = [(severity, text) for _, severity, text in announced(f, 33.0) if text.startswith(("attest: a", "attest: u"))]
    assert told[0] == (severity, "attest: undecided (no-reference)")
    assert told[1][1].startswith("attest: agrees")


def test_a_link_without_texts_carries_none(flight):
    f = flight("publish = ['attitude_quaternion']\n", sim("square", ["attitude-offset-north=12@20"]))
    f.run_until(25.0)
    assert f.of_type("STATUSTEXT") == []
    assert any(text.startswith("verdict: ATTITUDE DISAGREES") for text in f.texts)


def test_what_the_autopilot_says_of_itself_stands_beside_the_verdict(flight):
    f = flight("", sim("square", ["gyro1-bias-x=5@20+8"]))
    f.run_until(25.0)
    requested = {one.param1 for one in f.of_type("COMMAND_LONG") if one.command == 511 and one.param2 == 1_000_000}
    assert requested == {193.0, 1.0, 178.0}, "EKF_STATUS_REPORT, SYS_STATUS and AHRS2, once a second"
    (line,) = [text for text in f.texts if text.startswith("verdict: ATTITUDE agrees") and "itself" in text]
    assert '; the autopilot itself said "EKF3 lane switch 1" 0 s ago' in line
    assert ' | the autopilot itself said "EKF3 lane switch 1" 2 s ago' in f.status()


def test_px4_is_asked_for_its_own_report(flight):
    f = flight("", SimSettings(scenario="hover", personality="px4", faults=parse_faults(["gyro1-stop@8"])))
    f.run_until(12.0)
    requested = {one.param1 for one in f.of_type("COMMAND_LONG") if one.command == 511 and one.param2 == 1_000_000}
    assert requested == {230.0, 1.0}, "ESTIMATOR_STATUS and SYS_STATUS"
    assert " | the autopilot itself reports unhealthy gyro | " in f.status()


def test_without_requests_nothing_is_asked_of_the_autopilot_itself(flight):
    f = flight("[streams]\nrequest = false\n", sim("hover"))
    f.run_until(5.0)
    assert f.of_type("COMMAND_LONG") == []


def test_gaps_without_end_are_a_few_lines_a_minute(flight):
    """A line for each would be three a second."""
    f = flight("", sim("still"))
    f.run_until(10.0)
    whole, count = f.vehicle.frames_until, itertools.count()
    f.vehicle.frames_until = lambda now_ns: whole(now_ns) if next(count) % 40 > 15 else (whole(now_ns), [])[1]
    f.run_until(60.0)
    gaps = [text for text in f.texts if "RAW_IMU: no samples for 0." in text]
    assert len(gaps) == 3
    assert f.snapshot().lanes[0].gaps > 20
    f.run_until(75.0)
    assert any("more such lines were left out" in text for text in f.texts)
