"""One log as a unit of work that another process can do, and many logs of which some fail."""

import gzip
import multiprocessing
import pickle
import zlib
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import pytest

from attest_mav.errors import UnreadableDataError, UnwritableError, UsageError
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.registry import default_filter, filter_names
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.replay.batch import replay_file, replay_files
from attest_mav.replay.request import Request, Window
from attest_mav.runtime.files import open_log

BRIEF = Request((GradientDescent(),), window=Window(skip_s=2.0))


def test_a_request_survives_pickling_with_the_parameters_of_its_filters():
    filters = (
        *map(default_filter, filter_names()),
        GradientDescent(beta=0.5),
        VelocityAided(FlightParameters(gyro_noise=1e-3), low_pass_from_vehicle=False),
    )
    request = Request(filters, "RAW_IMU", "ATTITUDE", -4.5, Window(1.0, 20.0, 3.0))
    assert pickle.loads(pickle.dumps(request)) == request  # noqa: S301


def test_another_process_gives_the_same_report(cuts):
    work = partial(replay_file, request=BRIEF, open_log=open_log)
    paths = [str(cuts / f"{name}.tlog") for name in ("copter_square_laps", "copter_square_start")]
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        reports = list(pool.map(work, paths))
    assert [report["log"] for report in reports] == paths
    assert reports == [replay_file(path, BRIEF, open_log) for path in paths]
    assert reports[0]["filters"][0]["samples"] > 800


def test_every_error_names_the_log(tmp_path):
    path = tmp_path / "noise.tlog"
    path.write_bytes(b"not a log at all\n" * 50)
    with pytest.raises(UnreadableDataError, match=rf"^{path}: this is no log that is known here"):
        replay_file(str(path), BRIEF, open_log)


def test_a_log_in_a_damaged_archive_is_replayed_to_the_damage(cuts, tmp_path):
    log = (cuts / "copter_square_laps.tlog").read_bytes()
    packed = gzip.compress(log)
    part, path = tmp_path / "part.tlog", tmp_path / "cut.tlog.gz"
    path.write_bytes(packed[: len(packed) * 2 // 3])
    part.write_bytes(zlib.decompressobj(31).decompress(packed[: len(packed) * 2 // 3]))
    report, expected = (replay_file(str(one), BRIEF, open_log) for one in (path, part))
    assert report["notes"] == ["the gzip archive is damaged: it is cut short", *expected["notes"]]
    assert {**report, "notes": [], "log": ""} == {**expected, "notes": [], "log": ""}
    assert report["frames"] > 0


def test_an_error_on_a_log_tells_the_damage_of_its_archive(tmp_path):
    path = tmp_path / "noise.gz"
    path.write_bytes(gzip.compress(b"not a log at all\n" * 50)[:-2])
    with pytest.raises(UnreadableDataError, match=r"no MAVLink message; .*; the gzip archive is damaged: it is cut"):
        replay_file(str(path), BRIEF, open_log)


def test_one_failing_log_does_not_stop_the_others():
    def replay_one(path):
        if path == "bad":
            raise UnreadableDataError("bad: why")
        if path == "odd":
            raise UsageError("odd: why")
        return {"log": path}

    outcomes = list(replay_files(["a", "bad", "odd", "b"], replay_one))
    assert [(one.path, one.report) for one in outcomes] == [
        ("a", {"log": "a"}),
        ("bad", None),
        ("odd", None),
        ("b", {"log": "b"}),
    ]
    assert [None if one.error is None else one.error.exit_code for one in outcomes] == [None, 65, 2, None]


def test_an_output_that_cannot_be_written_stops_all():
    seen = []

    def replay_one(path):
        seen.append(path)
        raise UnwritableError("disk full")

    with pytest.raises(UnwritableError):
        list(replay_files(["a", "b"], replay_one))
    assert seen == ["a"]
