"""Every message of real logs against pyulog: the same messages, and the same numbers."""

from math import isnan

import pytest
from pyulog import ULog

from attest_mav.logs.ulog.reader import TopicReader
from attest_mav.logs.ulog.roles import stream_of
from attest_mav.logs.ulog.topics import Topics
from attest_mav.logs.ulog.walker import UlogWalker
from attest_mav.logs.windows import read_windows

LOGS = [
    "public/px4_small.ulg",
    "public/field/px4_cubeorange_vtol_gap.ulg",
    "public/field/px4_fmu3_rot7.ulg",
    "public/field/px4_fmu4pro_appended.ulg",
    "public/field/px4_sitl_events.ulg",
    "public/field/px4_sitl_groundtruth_2017.ulg",
]
COMPARED = ("sensor_combined", "vehicle_imu", "vehicle_magnetometer", "vehicle_attitude", "estimator_attitude")
COMPARED += ("vehicle_gps_position", "sensor_gps", "airspeed", "vehicle_status", "vehicle_attitude_groundtruth")


class Kept(TopicReader):
    """Keeps what it is given."""

    def __init__(self, names):
        super().__init__(names)
        self.rows = []

    def read(self, t_ns, numbers):
        assert t_ns == 1000 * int(numbers[0])
        self.rows.append(numbers)
        return []


@pytest.fixture(scope="module", params=LOGS)
def both(request, data_folder):
    """pyulog's topics by stream, our readers of all of their fields, and our walker with its topics."""
    path = data_folder / request.param
    log = ULog(str(path))
    theirs = {stream_of(topic.name, topic.multi_id): topic for topic in log.data_list}
    readers = {
        name: Kept(["timestamp", *[field.field_name for field in topic.field_data if field.field_name != "timestamp"]])
        for name, topic in theirs.items()
        if topic.name in COMPARED
    }
    topics = Topics(readers)
    walker = UlogWalker(topics)
    for _ in read_windows(path.read_bytes(), walker):
        pass
    return log, theirs, readers, walker, topics


def test_the_messages_are_the_same_in_number(both):
    log, theirs, _, walker, topics = both
    assert topics.counts() == {name: len(topic.data["timestamp"]) for name, topic in theirs.items()}
    assert walker.dropouts == len(log.dropouts)
    assert walker.dropout_ms == sum(dropout.duration for dropout in log.dropouts)


def test_the_numbers_are_the_same(both):
    _, theirs, readers, _, _ = both
    assert "sensor_combined" in readers
    for name, reader in readers.items():
        for index, field in enumerate(reader.names):
            expected, ours = theirs[name].data[field].tolist(), [row[index] for row in reader.rows]
            assert len(ours) == len(expected)
            same = [isnan(a) if isnan(b) else a == b for a, b in zip(ours, expected, strict=True)]
            assert all(same), (name, field)
