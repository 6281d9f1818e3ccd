"""Every record of real logs against pymavlink's DFReader: the same records, and the same numbers."""

from collections import Counter
from math import isnan

import pytest
from pymavlink import DFReader

from attest_mav.logs.dataflash.reader import RecordReader
from attest_mav.logs.dataflash.routes import Router
from attest_mav.logs.dataflash.units import Column, UnitTable
from attest_mav.logs.dataflash.walker import RecordWalker
from attest_mav.logs.windows import read_windows

INTACT = [
    "public/field/copter_v313_timems_2014.bin",
    "public/field/copter_v344_crash.bin",
    "public/field/copter_v368_nogps.bin",
    "public/field/copter_v410_trim385.bin",
    "public/field/copter_v411_39s.bin",
    "public/field/plane_v382_orient8_1s.BIN",
    "public/field/sitl_copter_v37dev.BIN",
    "public/field/sub_v410_trimmed_by_tool.BIN",
    "sitl/copter_square.BIN",
]
COMPARED = {
    "IMU": ("GyrX", "GyrY", "GyrZ", "AccX", "AccY", "AccZ"),
    "IMU2": ("GyrX", "GyrY", "GyrZ", "AccX", "AccY", "AccZ"),
    "MAG": ("MagX", "MagY", "MagZ", "Health"),
    "MAG2": ("MagX", "MagY", "MagZ", "Health"),
    "ATT": ("Roll", "Pitch", "Yaw"),
    "AHR2": ("Roll", "Pitch", "Yaw", "Q1", "Q2", "Q3", "Q4"),
    "XKF1": ("Roll", "Pitch", "Yaw", "VN"),
    "NKF1": ("Roll", "Pitch", "Yaw", "VN"),
    "XKQ": ("Q1", "Q2", "Q3", "Q4"),
    "NKQ": ("Q1", "Q2", "Q3", "Q4"),
    "SIM": ("Roll", "Pitch", "Yaw", "Q1", "Q2", "Q3", "Q4"),
    "GPS": ("Status", "Spd", "GCrs", "VZ", "Lat", "Lng", "Alt", "HDop", "NSats"),
    "GPA": ("SAcc", "VV"),
    "EV": ("Id",),
    "ORGN": ("Lat", "Lng", "Alt"),
    "STAT": ("Armed",),
}
TEXTS = {"MSG": "Message", "PARM": "Name"}


class Kept(RecordReader):
    """Keeps what it is given."""

    def __init__(self, columns, texts=()):
        super().__init__([Column(name) for name in columns], texts)
        self.rows = []

    def read(self, t_ns, numbers, texts):
        self.rows.append((numbers, texts))
        return []


def stream(name, message):
    """The stream of a record of pymavlink's, by the instance that it names itself."""
    number = getattr(message, "I", getattr(message, "C", 0)) if name in {"IMU", "MAG", "GPS", "GPA"} else 0
    number = message.C if name in {"XKF1", "NKF1", "XKQ"} and hasattr(message, "C") else number
    if number:
        return {"XKF1": ["", "XKF6"], "NKF1": ["", "NKF6"]}.get(name, ["", f"{name}2", f"{name}3"])[number]
    return {"XKQ1": "XKQ", "NKQ1": "NKQ"}.get(name, name)


@pytest.fixture(scope="module", params=INTACT)
def both(request, data_folder):
    """Records of pymavlink's reader by stream, our readers, and our walker."""
    path = data_folder / request.param
    theirs, log = {}, DFReader.DFReader_binary(str(path))
    while (message := log.recv_msg()) is not None:
        theirs.setdefault(stream(message.get_type(), message), []).append(message)
    log.close()
    readers = {name: Kept(columns) for name, columns in COMPARED.items()}
    readers.update({name: Kept(("Value",), [text]) for name, text in TEXTS.items()})
    router = Router(readers, UnitTable())
    walker = RecordWalker(router)
    for _ in read_windows(path.read_bytes(), walker):
        pass
    return theirs, readers, walker, router


def test_the_records_are_the_same_in_number(both):
    theirs, _, walker, router = both
    assert Counter(router.counts()) == Counter({name: len(messages) for name, messages in theirs.items()})
    assert walker.records == sum(len(messages) for messages in theirs.values())


def test_the_numbers_are_the_same(both):
    theirs, readers, _, _ = both
    compared = 0
    for name, columns in COMPARED.items():
        for message, (numbers, _) in zip(theirs.get(name, ()), readers[name].rows, strict=True):
            for column, ours in zip(columns, numbers[1:], strict=True):
                expected = getattr(message, column, None)
                assert isnan(ours) if expected is None or isnan(expected) else ours == pytest.approx(expected, rel=1e-9)
                compared += 1
    assert compared > 1000


def test_the_texts_and_parameters_are_the_same(both):
    theirs, readers, _, _ = both
    assert [texts[0] for _, texts in readers["MSG"].rows] == [message.Message for message in theirs["MSG"]]
    told = [(texts[0], numbers[1]) for numbers, texts in readers["PARM"].rows]
    assert told == [(message.Name, message.Value) for message in theirs["PARM"]]
