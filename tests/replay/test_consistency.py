from itertools import pairwise
from math import inf, nan, radians, sqrt

import pytest
from pymavlink.dialects.v20 import all as dialect_of_pymavlink

from attest_mav.algebra import q_from_euler, q_heading
from attest_mav.filters.registry import default_filter, filter_names
from attest_mav.innovation import Aid, Fusion, Innovation
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.replay.comparison import Attitude, Comparison
from attest_mav.replay.consistency import NisMean, SigmaCount
from attest_mav.replay.engine import replay
from attest_mav.replay.reference_track import ReferenceTrack
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window
from attest_mav.types import North

MS = 1_000_000
SKIP_S = 2.0


def test_errors_of_a_half_one_and_a_half_two_and_a_half_and_four_sigma():
    count = SigmaCount()
    for error in (0.5, -1.5, 2.5, -4.0):
        count.add(0.1 * error, 0.1)
    assert count.samples == 4
    assert count.within == (0.25, 0.5, 0.75)
    # (0.25 + 2.25 + 6.25 + 16) / 4 = 6.1875
    assert count.rms == pytest.approx(sqrt(6.1875))


@pytest.mark.parametrize("sigma", [nan, inf, 0.0])
def test_a_sigma_that_says_nothing_is_not_counted(sigma):
    count = SigmaCount()
    count.add(0.1, sigma)
    assert count.samples == 0


def test_the_mean_nis_is_over_the_steps_that_had_one():
    nis = NisMean()
    for value in (nan, 1.0, nan, 4.0, 0.25):
        nis.add(value)
    assert (nis.count, nis.mean) == (3, 1.75)


def compared(*attitudes):
    """Comparison of these (tilt deg, heading deg, tilt sigma deg, heading sigma deg, counted) with a level truth."""
    track = ReferenceTrack()
    comparison = Comparison("ours", track)
    for k, (tilt, heading, tilt_sigma, heading_sigma, counted) in enumerate(attitudes):
        track.add(k * MS, q_heading(0.0), None)
        q_nb = q_from_euler(radians(tilt), 0.0, radians(heading))
        sigmas = (radians(tilt_sigma), radians(heading_sigma))
        velocity = Innovation(Aid.VELOCITY, Fusion.USED, 0, (), (sqrt(0.5 * k),), (1.0,))
        comparison.add(Attitude(k * MS, 1e-3 * k, q_nb, North.TRUE, *sigmas, counted, (velocity,)))
    return comparison


def test_each_error_is_held_against_the_sigma_of_its_own_sample():
    comparison = compared(
        (0.5, 5.0, 0.4, 4.0, True),  # 1.25 and 1.25 sigma
        (0.5, 5.0, 2.0, 1.0, True),  # 0.25 and 5 sigma; not sure
        (0.9, 0.0, 0.3, 1.0, False),  # would be 3 sigma, and is not counted
        (0.25, 1.0, 0.1, nan, True),  # 2.5 sigma, and no say on the heading
    )
    consistency = comparison.consistency
    assert consistency.tilt.samples == 3
    assert consistency.tilt.within == pytest.approx((1 / 3, 2 / 3, 1.0))
    assert consistency.heading.samples == 2
    assert consistency.heading.within == (0.0, 0.5, 0.5)
    assert consistency.heading.rms == pytest.approx(sqrt((1.25**2 + 25.0) / 2.0))
    # Steps 0, 1 and 3 count: 0, 0.5 and 1.5.
    assert consistency.velocity.mean == pytest.approx(2.0 / 3.0)
    assert consistency.magnetometer.count == 0
    assert comparison.errors.sure_samples == 2
    assert comparison.errors.sure_tilt().rms == pytest.approx(sqrt((0.25 + 0.0625) / 2.0))


@pytest.fixture(scope="module")
def figures(data_cut, dialect):
    """The JSON object of each filter, by name."""
    request = Request(tuple(map(default_filter, filter_names())), window=Window(skip_s=SKIP_S))
    report = as_json("log", replay(TlogSource(data_cut, dialect), request, Outputs()))
    return {one["name"]: one for one in report["filters"]}


def test_a_filter_without_covariance_has_none(figures):
    assert figures["gradient-descent"]["consistency"] is None
    assert figures["gradient-descent"]["valid"] is None


def test_in_turns_a_gravity_filter_is_sure_and_wrong_and_the_flight_filter_is_not(figures):
    # 8 degrees wrong in laps that the copter leans into, with a sigma that knows nothing of it.
    gravity, flight = figures["robust-adaptive"], figures["velocity-aided"]
    assert gravity["consistency"]["tilt"]["within_3"] < 0.1
    assert gravity["valid"]["share"] > 0.9
    assert gravity["valid"]["tilt_deg"]["rms"] > 5.0
    assert flight["consistency"]["tilt"]["within_3"] > 0.99
    assert flight["consistency"]["heading"]["within_3"] > 0.99
    assert flight["valid"]["tilt_deg"]["max"] <= flight["tilt_deg"]["max"]


def messages_of(data, name):
    """All messages of that name, in order, by pymavlink; (log time in s, message)."""
    parser = dialect_of_pymavlink.MAVLink(None)
    parser.robust_parsing = True
    found, offset = [], 0
    while offset < len(data):
        # Records of MAVLink 2 without signature: 8 bytes of time, 10 of header, payload, 2 of checksum.
        length = 8 + 12 + data[offset + 9]
        message = parser.decode(bytearray(data[offset + 8 : offset + length]))
        if message.get_type() == name:
            found.append((int.from_bytes(data[offset : offset + 8], "big") * 1e-6, message))
        offset += length
    return found


def test_every_fix_and_every_new_reading_of_the_compass_has_a_nis(figures, data_cut):
    imu, fixes = messages_of(data_cut, "RAW_IMU"), messages_of(data_cut, "GPS_RAW_INT")
    begin_s = imu[-figures["velocity-aided"]["samples"]][0]
    nis = figures["velocity-aided"]["consistency"]["nis"]
    assert nis["velocity"]["n"] == pytest.approx(sum(t_s >= begin_s for t_s, _ in fixes), abs=1)
    fields = [(one.xmag, one.ymag, one.zmag) for t_s, one in imu if t_s >= begin_s]
    new = sum(one != before for before, one in pairwise(fields))
    assert nis["magnetometer"]["n"] == pytest.approx(new, abs=2)
    for one in nis.values():
        assert 0.0 < one["mean"] < 4.0
    for name in ("robust-adaptive", "leveling"):
        assert figures[name]["consistency"]["nis"] == {"velocity": None, "magnetometer": None}


def test_without_a_reference_only_the_innovations_are_left(data_cut, dialect, without):
    kept = without(data_cut, *map(dialect.id_of, ("SIM_STATE", "ATTITUDE", "AHRS2")))
    request = Request((default_filter("velocity-aided"),), window=Window(skip_s=SKIP_S))
    one = as_json("log", replay(TlogSource(kept, dialect), request, Outputs()))["filters"][0]
    assert one["samples"] == 0
    assert one["valid"] is None
    assert (one["consistency"]["tilt"], one["consistency"]["heading"]) == (None, None)
    assert one["consistency"]["nis"]["velocity"]["n"] > 5
