"""Small undamaged logs of all formats, with random values and a time of its own in each record."""

from collections.abc import Callable, Iterator, Mapping
from random import Random
from struct import Struct
from typing import Final

from attest_mav.evaluation.fuzz.values import payload
from attest_mav.logs.detect import LogFormat
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.dialect import load_dialect

RECORDS: Final = 600
STEP_US: Final = 2500
BEGIN_US: Final = 1_700_000_000_000_000
MESSAGES: Final = ("HEARTBEAT", "ATTITUDE", "RAW_IMU", "SCALED_IMU2", "GPS_RAW_INT", "STATUSTEXT", "PARAM_VALUE")
TYPES: Final = (
    ("IMU", "QBffffff", "<QB6f", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
    ("ATT", "QccccCC", "<Q4h2H", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"),
    ("RATE", "Qf", "<Qf", "TimeUS,RDes"),
    ("MODE", "QMBB", "<QBBB", "TimeUS,Mode,ModeNum,Rsn"),
    ("PARM", "QNf", "<Q16sf", "TimeUS,Name,Value"),
    ("MSG", "QZ", "<Q64s", "TimeUS,Message"),
)
"""DataFlash: name, letters, the same for ``struct``, columns."""
TOPICS: Final = (
    ("sensor_combined", "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;", "<Q3fI"),
    ("vehicle_attitude", "uint64_t timestamp;uint64_t timestamp_sample;float[4] q;", "<2Q4f"),
    ("vehicle_land_detected", "uint64_t timestamp;bool landed;uint8_t[7] _padding0;", "<Q?"),
    ("esc_status", "uint64_t timestamp;esc_report[2] esc;uint8_t count;", "<Q4fB"),
)
"""ULog: topic, format, letters for ``struct``."""
_STAMP: Final = Struct(">Q")
_FORMAT: Final = Struct("<3sBB4s16s64s")


def tlog(rng: Random) -> bytes:
    """A telemetry log."""
    return b"".join(_STAMP.pack(BEGIN_US + STEP_US * number) + frame for number, frame in enumerate(_frames(rng)))


def stream(rng: Random) -> bytes:
    """A bare stream of frames."""
    return b"".join(_frames(rng))


def _frames(rng: Random) -> Iterator[bytes]:
    dialect = load_dialect()
    senders = [Encoder(dialect, 1, 1), Encoder(dialect, 255, 190)]
    layouts = [dialect.layout(name) for name in MESSAGES]
    for _ in range(RECORDS):
        layout = rng.choice(layouts)
        yield rng.choice(senders).frame(layout, payload(rng, layout, 0.8))


def dataflash(rng: Random) -> bytes:
    """A binary DataFlash log."""
    log = _described(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    structures = [Struct(one[2]) for one in TYPES]
    for number, (name, letters, _, columns) in enumerate(TYPES):
        log += _described(10 + number, 3 + structures[number].size, name, letters, columns)
    for number in range(RECORDS):
        kind = rng.randrange(len(TYPES))
        values = _values(rng, TYPES[kind][2])
        log += bytes((0xA3, 0x95, 10 + kind)) + structures[kind].pack(STEP_US * number, *values)
    return log


def _described(kind: int, length: int, name: str, letters: str, columns: str) -> bytes:
    return _FORMAT.pack(b"\xa3\x95\x80", kind, length, name.encode(), letters.encode(), columns.encode())


def dataflash_text(rng: Random) -> bytes:
    """A DataFlash log in text."""
    lines = ["FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns"]
    for number, (name, letters, code, columns) in enumerate(TYPES):
        lines.append(f"FMT, {10 + number}, {3 + Struct(code).size}, {name}, {letters}, {columns}")
    for number in range(RECORDS):
        name, _, code, _ = rng.choice(TYPES)
        values = [one.decode("latin-1") if isinstance(one, bytes) else str(one) for one in _values(rng, code)]
        lines.append(", ".join([name, str(STEP_US * number), *values]))
    return "\n".join([*lines, ""]).encode("latin-1")


def _values(rng: Random, code: str) -> Iterator[float | bytes]:
    """Random values for the letters behind the time."""
    count = ""
    for letter in code[2:]:
        if letter.isdecimal():
            count += letter
            continue
        for _ in range(1 if letter == "s" else int(count or 1)):
            yield _value(rng, letter)
        count = ""


def _value(rng: Random, letter: str) -> float | bytes:
    if letter == "f":
        return round(rng.gauss(0.0, 10.0), 3)
    if letter == "s":
        return b"".join([rng.choice((b"EKF", b"GYR", b"X", b"_")) for _ in range(4)])
    sizes = {"h": (-32768, 32767), "H": (0, 65535), "I": (0, 1 << 31), "Q": (0, 1 << 40), "?": (0, 1), "B": (0, 2)}
    return rng.randint(*sizes[letter])


def ulog(rng: Random) -> bytes:
    """A ULog, with a format inside a format, texts and parameters."""
    log = b"ULog\x01\x12\x35\x01" + bytes(8) + _message("B", bytes(40))
    for topic, members, _ in (*TOPICS, ("esc_report", "float rpm;float current;", "")):
        log += _message("F", f"{topic}:{members}".encode())
    for number, (topic, _, _) in enumerate(TOPICS):
        log += _message("A", bytes((0, 30 + number, 1)) + topic.encode())
    structures = [Struct(one[2]) for one in TOPICS]
    for number in range(RECORDS):
        kind = rng.randrange(len(TOPICS))
        body = structures[kind].pack(1000 + STEP_US * number, *_values(rng, TOPICS[kind][2]))
        log += _message("D", bytes((30 + kind, 1)) + body)
        if rng.random() < 0.1:
            log += rng.choice((_text_message(rng), PARAMETER, _message("S", rng.randbytes(8))))
    return log


def _text_message(rng: Random) -> bytes:
    t_us = rng.randrange(1 << 40)
    return _message("L", b"6" + t_us.to_bytes(8, "little") + b"[commander] Takeoff detected")


def _message(kind: str, body: bytes) -> bytes:
    return len(body).to_bytes(2, "little") + kind.encode() + body


PARAMETER: Final = _message("P", b"\x0ffloat MPC_XY_P1\x00\x00\x80\x3f")
SAMPLES: Final[Mapping[LogFormat, Callable[[Random], bytes]]] = {
    "tlog": tlog,
    "mavlink": stream,
    "dataflash": dataflash,
    "dataflash-text": dataflash_text,
    "ulog": ulog,
}
"""A maker of a log for each format."""
