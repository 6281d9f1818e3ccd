"""A writer of DataFlash logs, made from the format's description and not from the reader."""

import struct

import pytest

CODES = {
    "B": "B",
    "b": "b",
    "M": "B",
    "h": "h",
    "H": "H",
    "c": "h",
    "C": "H",
    "I": "I",
    "e": "i",
    "E": "I",
    "L": "i",
    "Q": "Q",
}
CODES |= {"f": "f", "d": "d", "n": "4s", "N": "16s", "Z": "64s"}
SCALES = {"c": 100, "C": 100, "e": 100, "E": 100, "L": 10_000_000}
G = 9.80665

TIME_US = {
    "IMU": ("QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
    "MAG": ("QBhhhB", "TimeUS,I,MagX,MagY,MagZ,Health"),
    "ATT": ("QccccCCCCB", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw,ErrRP,ErrYaw,AEKF"),
    "SIM": ("QccCfLLffff", "TimeUS,Roll,Pitch,Yaw,Alt,Lat,Lng,Q1,Q2,Q3,Q4"),
    "XKQ": ("QBffff", "TimeUS,C,Q1,Q2,Q3,Q4"),
    "GPS": ("QBBIHBcLLeffffB", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U"),
    "GPA": ("QBCCCCfB", "TimeUS,I,VDop,HAcc,VAcc,SAcc,YAcc,VV"),
    "PARM": ("QNf", "TimeUS,Name,Value"),
    "MSG": ("QZ", "TimeUS,Message"),
    "MODE": ("QMBB", "TimeUS,Mode,ModeNum,Rsn"),
    "EV": ("QB", "TimeUS,Id"),
    "ERR": ("QBB", "TimeUS,Subsys,ECode"),
    "ARSP": ("QBffB", "TimeUS,I,Airspeed,DiffPress,H"),
    "ORGN": ("QBLLe", "TimeUS,Type,Lat,Lng,Alt"),
    "XKF4": ("QBcccccHB", "TimeUS,C,SV,SP,SH,SM,SVT,SS,PI"),
    "AHR2": ("QccC", "TimeUS,Roll,Pitch,Yaw"),
    "UNIT": ("QbZ", "TimeUS,Id,Label"),
    "MULT": ("Qbd", "TimeUS,Id,Mult"),
    "FMTU": ("QBNN", "TimeUS,FmtType,UnitIds,MultIds"),
    "RATE": ("Qf", "TimeUS,RDes"),
}
"""Letters and columns of today's records."""


class DataflashWriter:
    """Writes one record after the other. The types are numbered from 10 on in the order in which they are used."""

    def __init__(self, formats=TIME_US):
        self.formats = dict(formats)
        self.data = b""
        self.types = {}
        self.starts = []

    def raw_format(self, number, name, codes, columns, length=None):
        size = 3 + struct.calcsize("<" + "".join(CODES[code] for code in codes)) if length is None else length
        body = struct.pack("<BB4s16s64s", number, size, name.encode(), codes.encode(), columns.encode())
        self.starts.append(len(self.data))
        self.data += b"\xa3\x95\x80" + body

    def describe(self, name):
        if name not in self.types:
            self.types[name] = 10 + len(self.types)
            self.raw_format(self.types[name], name, *self.formats[name])

    def add(self, name, **values):
        """One record; columns that are not given are zero. Scaled columns are given in their unit."""
        self.describe(name)
        codes, columns = self.formats[name]
        packed = []
        for code, column in zip(codes, columns.split(","), strict=True):
            value = values.pop(column, b"" if code in "nNZ" else 0)
            if isinstance(value, str):
                value = value.encode()
            packed.append(round(value * SCALES[code]) if code in SCALES else value)
        assert not values, f"{name} has no {values}"
        self.starts.append(len(self.data))
        self.data += struct.pack(
            "<2sB" + "".join(CODES[code] for code in codes), b"\xa3\x95", self.types[name], *packed
        )

    def begin(self, text="ArduCopter V4.6.0 (0a1b2c3d)"):
        self.raw_format(128, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
        self.add("MSG", TimeUS=1000, Message=text)

    def instant(self, t_us, own_roll_deg=0.0, truth=True):
        """A level vehicle at rest, nose to magnetic north."""
        self.add("IMU", TimeUS=t_us, AccZ=-G)
        self.add("MAG", TimeUS=t_us, MagX=200, MagZ=440, Health=1)
        self.add("ATT", TimeUS=t_us, Roll=own_roll_deg, AEKF=3)
        if truth:
            self.add("SIM", TimeUS=t_us, Q1=1.0)

    def fix(self, t_us, **values):
        place = {"Lat": 51.8731, "Lng": 0.171, "Alt": 50.0, "Status": 3, "NSats": 12, "HDop": 0.8}
        self.add("GPS", TimeUS=t_us, GWk=2400, GMS=1000, **{**place, **values})

    def still_flight(self, seconds, own_roll_deg=0.0, hz=50):
        self.begin()
        for k in range(int(seconds * hz)):
            self.instant(1_000_000 + round(k * 1e6 / hz), own_roll_deg)


@pytest.fixture
def writer():
    return DataflashWriter()


@pytest.fixture
def writer_of():
    """Makes a writer of other formats."""
    return DataflashWriter
