"""Several inertial messages of one vehicle, requested and passed on side by side."""

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.mavlink.component.companion_settings import CompanionSettings
from attest_mav.mavlink.component.vehicle_data import DataSettings
from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.wire.framer import Framer
from attest_mav.samples import ImuSample

SECOND = 1_000_000_000
RAW_IMU, SCALED_IMU, SCALED_IMU2, SCALED_IMU3, HIGHRES_IMU = 27, 26, 116, 129, 105
ACCEPTED, DENIED = 0, 2


def inertial(message_id, t_us, gyro):
    """A level sensor that reads ``gyro`` mrad/s about its first axis."""
    rest = (0, 0, -1000, gyro, 0, 0, 200, 0, 400)
    if message_id == RAW_IMU:
        return mavlink.MAVLink_raw_imu_message(t_us, *rest)
    kind = {SCALED_IMU: mavlink.MAVLink_scaled_imu_message, SCALED_IMU2: mavlink.MAVLink_scaled_imu2_message}
    return kind[message_id](t_us // 1000, *rest)


class Witness:
    """A vehicle that sends inertial messages and answers requests, the companion, and a decoder behind it."""

    def __init__(self, bench, dialect):
        self.bench = bench
        self.framer = Framer(dialect, bench.companion.wanted)
        self.decoder = Decoder(dialect)
        self.samples = []
        self.answered = 0
        self.refused = set()
        self.hear(mavlink.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3))

    def hear(self, message):
        """A message of the vehicle, decoded when the companion wants it, its samples kept when they are in use."""
        b = self.bench
        sender = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        (frame,) = self.framer.feed(message.pack(sender), b.now_ns)
        if b.companion.handle(0, frame, b.now_ns):
            for sample in self.decoder.decode(frame):
                if isinstance(sample, ImuSample):
                    self._keep(sample)

    def _keep(self, sample):
        if self.bench.companion.imu_taken(sample.source, sample.t_ns, self.bench.now_ns):
            self.samples.append(sample)

    def fly(self, until_s, gyros):
        """Time goes on; the vehicle sends these messages at 10 Hz, with these readings, and answers requests."""

        def tick():
            self.hear(mavlink.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3))
            for message_id, gyro in gyros.items():
                self.hear(inertial(message_id, self.bench.now_ns // 1000, gyro))
            requests = self.bench.interval_requests()
            if len(requests) > self.answered:
                self.answered = len(requests)
                result = DENIED if requests[-1][0] in self.refused else ACCEPTED
                self.bench.hear(mavlink.MAVLink_command_ack_message(511, result, 0, 0, 1, 193))

        self.bench.run_until(until_s, tick)

    def readings(self, since_s=0.0):
        """Gyro readings by source, mrad/s."""
        found = {}
        for sample in self.samples:
            if sample.rx_ns >= since_s * SECOND:
                found.setdefault(sample.source, set()).add(round(1000.0 * sample.gyro[0]))
        return found


@pytest.fixture
def witness(bench, dialect):
    """Makes a witness; the settings of the data can be given."""
    return lambda **settings: Witness(bench(CompanionSettings(data=DataSettings(**settings))), dialect)


def test_two_inertial_messages_arrive_as_samples_of_their_own_sources(witness):
    w = witness(further_imu_messages=("SCALED_IMU2",))
    w.fly(3.0, {RAW_IMU: 10, SCALED_IMU2: 20, SCALED_IMU: 30})
    assert w.readings() == {"RAW_IMU": {10}, "SCALED_IMU2": {20}}
    assert w.bench.companion.data.primary_imu == "RAW_IMU"


def test_each_inertial_message_is_requested_at_the_rate_of_inertial_messages(witness):
    w = witness(further_imu_messages=("SCALED_IMU2",), imu_hz=25.0)
    w.fly(1.0, {})
    rates = {message: interval_us for message, interval_us, _ in w.bench.interval_requests()}
    assert rates[RAW_IMU] == rates[SCALED_IMU2] == 40_000


def test_by_default_a_message_of_every_other_sensor_is_requested_and_used(witness):
    w = witness()
    w.fly(3.0, {RAW_IMU: 10, SCALED_IMU2: 20, SCALED_IMU: 30})
    assert w.readings() == {"RAW_IMU": {10}, "SCALED_IMU2": {20}}
    assert {SCALED_IMU2, SCALED_IMU3} <= {message for message, _, _ in w.bench.interval_requests()}


def test_a_message_that_comes_late_is_used_beside_the_one_that_replaced_it(witness):
    w = witness()
    w.fly(12.0, {SCALED_IMU2: 20})
    assert w.bench.companion.data.primary_imu == "SCALED_IMU2"
    w.fly(20.0, {SCALED_IMU2: 20, RAW_IMU: 10})
    assert w.readings(since_s=13.0) == {"RAW_IMU": {10}, "SCALED_IMU2": {20}}
    assert w.bench.companion.data.single_imu == ""


def test_where_none_is_configured_one_inertial_message_is_requested_and_used(witness):
    w = witness(further_imu_messages=())
    w.fly(3.0, {RAW_IMU: 10, SCALED_IMU2: 20})
    assert w.readings() == {"RAW_IMU": {10}}
    assert SCALED_IMU2 not in {message for message, _, _ in w.bench.interval_requests()}
    assert w.bench.companion.data.single_imu == "no further_imu_messages are configured"


@pytest.mark.parametrize(
    ("bytes_per_s", "allowed"), [(3849.0, set()), (3851.0, {SCALED_IMU2}), (5651.0, {SCALED_IMU2, SCALED_IMU3})]
)
def test_further_messages_are_requested_within_the_limit(witness, bytes_per_s, allowed):
    """At 50 Hz RAW_IMU takes 41 bytes a frame, SCALED_IMU2 and SCALED_IMU3 36: with their extensions."""
    w = witness(imu_bytes_per_s=bytes_per_s)
    w.fly(3.0, {RAW_IMU: 10})
    assert {message for message, _, _ in w.bench.interval_requests()} & {SCALED_IMU2, SCALED_IMU3} == allowed


def test_a_sensor_that_does_not_exist_is_named_once_and_not_requested_again(witness):
    w = witness()
    w.fly(60.0, {RAW_IMU: 10})
    assert w.bench.companion.data.single_imu == "no SCALED_IMU2 or SCALED_IMU3 comes with readings"
    requests = [message for message, _, _ in w.bench.interval_requests()]
    assert (requests.count(SCALED_IMU2), requests.count(SCALED_IMU3)) == (1, 1)
    told = [note for note in w.bench.notes if "SCALED" in note and "does not come" in note]
    assert len(told) == 2
    assert not [note for note in w.bench.notes if "SCALED" in note and "asking again" in note]


def test_a_further_message_that_becomes_primary_and_ceases_to_be_is_used_throughout(witness):
    w = witness(imu_messages=("RAW_IMU", "SCALED_IMU2"), further_imu_messages=("SCALED_IMU2",))
    w.fly(3.0, {RAW_IMU: 10, SCALED_IMU2: 20})
    w.fly(9.0, {SCALED_IMU2: 20})
    w.fly(14.0, {SCALED_IMU2: 20})
    assert w.bench.companion.data.primary_imu == "SCALED_IMU2"
    w.fly(30.0, {RAW_IMU: 10})
    assert w.bench.companion.data.primary_imu == "RAW_IMU"
    w.fly(33.0, {RAW_IMU: 10, SCALED_IMU2: 20})
    assert w.readings(since_s=31.0) == {"RAW_IMU": {10}, "SCALED_IMU2": {20}}
    assert [stream.message_id for stream in w.bench.companion.data.stream_manager.streams].count(SCALED_IMU2) == 1


def test_a_refused_further_message_does_not_move_the_primary_one(witness):
    w = witness(further_imu_messages=("SCALED_IMU2",))
    w.refused = {SCALED_IMU2}
    w.fly(10.0, {RAW_IMU: 10})
    assert w.bench.companion.data.primary_imu == "RAW_IMU"
    assert w.readings() == {"RAW_IMU": {10}}
    assert "SCALED_IMU2 at 50 Hz: denied" in w.bench.notes
