"""A recording of the service, and its replay: the same verdicts at the same times; no signatures, no secrets."""

from math import degrees, nan

import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.config.calibration import kept_calibration
from attest_mav.config.parsing import parse_config
from attest_mav.filters.calibration import SensorCalibration, UncertainVector
from attest_mav.logs.tlog.reader import TlogReader
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.mavlink.component.notes import ERROR, WARNING, Note
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window
from attest_mav.service.assembly import service_settings
from attest_mav.service.kept_state import KeptState
from attest_mav.service.service import Service
from attest_mav.service.tape import MAX_WAITING, Tape
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings
from attest_mav.types import EarthField

SECOND = 1_000_000_000
DECLINATION = 0.2209
EPOCH_NS = 1_750_000_000 * SECOND


class Recorded:
    """A flight of the whole service on virtual time, recorded as the daemon does."""

    def __init__(self, faults=(), seconds=30, signing="", calibrations=None):
        self.dialect = load_dialect()
        settings = SimSettings(scenario="square", fast_rate_hz=50.0, faults=parse_faults(faults))
        self.vehicle = FakeAutopilot(settings, 1, self.dialect)
        config = parse_config(f"[[link]]\nurl = 'udpin::0'\n{signing}", "test")
        self.tape = Tape(self.dialect, EPOCH_NS, config.output.component_id)
        keys = {"key": bytes(range(32))}
        field = EarthField(DECLINATION, nan)
        service_of = service_settings(config, keys) if signing else service_settings(config)
        self.service = Service(service_of, ["udpin::0"], self.dialect, lambda *_: (field, "a test"), 0, self.tape)
        self.service.persistence.restore(KeptState(calibrations=calibrations or {}), EPOCH_NS, 0)
        self.data = b""
        self.sent = []
        for self.now_ns in range(0, seconds * SECOND, 20_000_000):
            self.service.receive(0, b"".join(self.vehicle.frames_until(self.now_ns)), self.now_ns)
            self.service.poll(self.now_ns)
            self.pass_on()
        self.spans = self.service.snapshot(self.now_ns).spans

    def pass_on(self):
        for frame in self.service.take_frames(0):
            self.vehicle.handle(frame, self.now_ns)
            self.tape.say(frame, self.now_ns)
            self.sent.append(frame)
        for note in self.service.take_notes():
            self.tape.note(note, self.now_ns)
        self.data += self.tape.take()[0]


@pytest.fixture(scope="module")
def flight():
    return Recorded(["gyro1-bias-x=5@18+6"])


def verdicts(data, dialect, calibrations=None):
    field = degrees(DECLINATION)
    request = Request((), None, None, field, Window(), as_it_came=True, calibrations=calibrations or {})
    report = as_json("log", replay(TlogSource(data, dialect), request, Outputs()))
    return report["verdict"]["intervals"]


def first_sample_s(data, dialect):
    """The time of the autopilot at which the time of a log begins."""
    message = next(iter(TlogReader(data, dialect, frozenset([dialect.id_of("RAW_IMU")]))))
    return dialect.layout("RAW_IMU").pick("time_usec").unpack(message.payload)[0] * 1e-6


def test_a_replay_of_the_recording_gives_the_verdicts_of_the_flight(flight):
    assert_same_verdicts(flight, verdicts(flight.data, flight.dialect))


def test_so_does_one_with_the_calibration_that_the_flight_began_with():
    """The bias is wrong by 0.5 m/s^2: attitude and autopilot differ from the start, as they did in the flight."""
    small = ((1e-4, 0.0, 0.0), (0.0, 1e-4, 0.0), (0.0, 0.0, 1e-4))
    known = SensorCalibration(UncertainVector((0.5, 0.0, 0.0), small), UncertainVector((0.0, 0.0, 0.0), small))
    kept = {f"1/{name}": kept_calibration(known, EPOCH_NS) for name in ("RAW_IMU", "SCALED_IMU2")}
    flight = Recorded(seconds=20, calibrations=kept)
    assert_same_verdicts(flight, verdicts(flight.data, flight.dialect, kept), "undecided")
    assert verdicts(flight.data, flight.dialect) != verdicts(flight.data, flight.dialect, kept)


def assert_same_verdicts(flight, replayed, among="disagree"):
    live = flight.spans
    assert [one["state"] for one in replayed] == [one.agreement.name.lower() for one in live]
    assert among in [one["state"] for one in replayed]
    assert [one["reason"] for one in replayed] == [one.reason for one in live]
    for name, values in (
        ("peak_tilt_deg", [s.peak_tilt for s in live]),
        ("peak_heading_deg", [s.peak_heading for s in live]),
    ):
        shown = [None if value is None else round(degrees(value), 6) for value in values]
        assert [one[name] for one in replayed] == shown
    # Log time counts from the first inertial sample by the autopilot's clock; a verdict's end is its last sample.
    zero_s = first_sample_s(flight.data, flight.dialect)
    begins = [round(one["start_s"] + zero_s, 6) for one in replayed]
    assert begins == [round(one.begin_ns * 1e-9, 6) for one in live]


def test_a_recording_holds_what_was_used_what_was_sent_and_what_was_said(flight, tmp_path):
    path = tmp_path / "flight.tlog"
    path.write_bytes(flight.data)
    log = mavutil.mavlink_connection(str(path), dialect="ardupilotmega")
    messages, times = [], []
    while (message := log.recv_match()) is not None:
        messages.append(message)
        times.append(message._timestamp)
    log.close()
    assert times == sorted(times)
    assert times[0] == pytest.approx(EPOCH_NS / SECOND, abs=2.0)
    ours = [one for one in messages if one.get_srcComponent() == 193]
    sent = [int.from_bytes(frame[7:10], "little") for frame in flight.sent]
    for name in ("ATTITUDE_QUATERNION", "HEARTBEAT"):
        assert len([m for m in ours if m.get_type() == name]) == sent.count(flight.dialect.id_of(name)) > 20
    texts = "".join(m.text for m in ours if m.get_type() == "STATUSTEXT")
    assert "verdict: ATTITUDE DISAGREES (tilt)" in texts
    assert "verdict interval: AGREE (agrees) for " in texts
    theirs = {m.get_type() for m in messages if m.get_srcComponent() == 1}
    assert theirs >= {"RAW_IMU", "SCALED_IMU2", "ATTITUDE", "GPS_RAW_INT", "PARAM_VALUE", "HEARTBEAT"}
    assert "BAD_DATA" not in theirs


def test_a_later_file_begins_with_what_comes_only_once(flight):
    opening = flight.tape.opening(70 * SECOND)
    reader = TlogReader(opening, flight.dialect)
    frames = list(reader)
    names = [flight.dialect.name_of(one.message_id) for one in frames]
    assert {one.rx_ns for one in frames} == {EPOCH_NS + 70 * SECOND}
    assert names.count("HEARTBEAT") == 1
    asked = {frame[10:] for frame in flight.sent if frame[7:10] == bytes((20, 0, 0))}
    assert 3 <= names.count("PARAM_VALUE") <= len(asked)
    half = flight.data.index((EPOCH_NS // 1000 + 6_000_000).to_bytes(8, "big"))
    states = [one["state"] for one in verdicts(opening_of(flight, half) + flight.data[half:], flight.dialect)]
    assert states == ["undecided", "agree", "disagree", "agree"]


def opening_of(flight, half):
    """The opening with the time of the first record behind it."""
    stamp = flight.data[half : half + 8]
    frames = TlogReader(flight.tape.opening(0), flight.dialect)
    return b"".join(stamp + frames.raw_record(one)[8:] for one in frames)


def test_signatures_and_keys_are_not_recorded():
    signed = Recorded(seconds=4, signing="signing = 'sign'\nkey_file = 'key'\n")
    assert any(frame[2] & 1 for frame in signed.sent)
    reader = TlogReader(signed.data, signed.dialect)
    frames = list(reader)
    assert len(frames) > 300
    assert reader.bad_bytes == reader.bad_crc == 0
    assert not any(one.signed for one in frames)
    assert not any(one.message_id == signed.dialect.id_of("SETUP_SIGNING") for one in frames)


def test_frames_keep_their_version_and_content():
    dialect = load_dialect()
    tape = Tape(dialect, 0, 193)
    for protocol in (mavlink.MAVLink(None, 3, 1), mavlink.MAVLink(None, 3, 1)):
        raw = mavlink.MAVLink_attitude_message(7, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0).pack(protocol, force_mavlink1=True)
        tape.hear(Frame(30, 3, 1, raw[2], 1, False, raw[6:-2], 5000))
        assert tape.take() == ((5).to_bytes(8, "big") + raw, 1)


def test_lines_of_the_log_have_their_severity_and_are_whole():
    dialect = load_dialect()
    tape = Tape(dialect, 0, 193)
    tape.note(Note(WARNING, "w" * 120), 0)
    tape.note(Note(ERROR, "e"), 0)
    parser = mavlink.MAVLink(None)
    data, count = tape.take()
    frames = list(TlogReader(data, dialect))
    assert count == len(frames) == 4
    texts = [m for one in frames for m in parser.parse_buffer(data[one.offset : one.offset + one.size])]
    assert [m.severity for m in texts] == [4, 4, 4, 3]
    assert "".join(m.text for m in texts[:3]) == "w" * 120
    assert len({m.id for m in texts[:3]}) == 1


def test_records_that_nobody_fetches_are_bounded_and_counted():
    tape = Tape(load_dialect(), 0, 193)
    for _ in range(20000):
        tape.note(Note(WARNING, "x" * 40), 0)
    data, count = tape.take()
    assert MAX_WAITING <= len(data) < MAX_WAITING + 100
    assert count + tape.lost == 20000
