"""The second pass looks inside no record before the first damage, and finds the same as one that looks everywhere."""

import random

import pytest

from attest_mav.evaluation.damage.samples import SAMPLES
from attest_mav.logs.dataflash.reader import RecordReader
from attest_mav.logs.dataflash.routes import Router
from attest_mav.logs.dataflash.units import UnitTable
from attest_mav.logs.dataflash.walker import RecordWalker
from attest_mav.logs.ulog.reader import TopicReader
from attest_mav.logs.ulog.topics import Topics
from attest_mav.logs.ulog.walker import UlogWalker
from attest_mav.logs.windows import read_windows


class Records(RecordReader):
    """The times of all records of some names."""

    def __init__(self, times):
        super().__init__()
        self._times = times

    def read(self, t_ns, numbers, texts):
        self._times.append(t_ns)
        return []


class Data(TopicReader):
    """The times of all data of some topics."""

    def __init__(self, times):
        super().__init__()
        self._times = times

    def read(self, t_ns, numbers):
        self._times.append(t_ns)
        return []


def walk_dataflash(data, intact_to):
    times = []
    names = ("IMU", "IMU2", "ATT", "MAG", "GPS", "MSG")
    walker = RecordWalker(Router({name: Records(times) for name in names}, UnitTable()), intact_to)
    list(read_windows(data, walker))
    return walker, times


def walk_ulog(data, intact_to):
    times = []
    names = ("sensor_combined", "vehicle_attitude", "vehicle_gps_position", "vehicle_status")
    walker = UlogWalker(Topics({name: Data(times) for name in names}), intact_to)
    list(read_windows(data, walker))
    return walker, times


WALKS = {"dataflash": walk_dataflash, "ulog": walk_ulog}


def cut(data, seed):
    """The log without one stretch in its second half."""
    rng = random.Random(seed)
    at = rng.randrange(len(data) // 2, len(data) - 500)
    return data[:at] + data[at + rng.randrange(1, 400) :]


@pytest.mark.parametrize("log_format", WALKS)
@pytest.mark.parametrize("seed", range(4))
def test_the_records_are_the_same_whether_they_are_looked_into_again_or_not(log_format, seed):
    log = SAMPLES[log_format](random.Random(seed))
    damaged = cut(log, seed)
    walk = WALKS[log_format]
    first, times = walk(damaged, 0)
    intact_to = first.damage.intact_to(len(damaged))
    assert len(log) // 3 < intact_to <= len(damaged)
    second, same = walk(damaged, intact_to)
    assert len(times) > 10
    assert (same, second.records, second.damage.first) == (times, first.records, first.damage.first)


def test_a_log_without_damage_is_intact_to_its_end():
    log = SAMPLES["dataflash"](random.Random(1))
    walker, _ = walk_dataflash(log, 0)
    assert walker.damage.intact_to(len(log)) == len(log)
