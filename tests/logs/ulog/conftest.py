"""A writer of ULogs, made from PX4's description of the format and not from the reader."""

import struct

import pytest

G = 9.80665
LETTERS = {"uint64_t": "Q", "uint32_t": "I", "int32_t": "i", "uint16_t": "H", "uint8_t": "B", "float": "f", "bool": "?"}
LETTERS |= {"double": "d"}
FORMATS = {
    "sensor_combined": "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;int32_t dt;"
    "float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt;uint8_t accelerometer_clipping;"
    "uint8_t[3] _padding0",
    "vehicle_imu": "uint64_t timestamp;uint64_t timestamp_sample;float[3] delta_angle;float[3] delta_velocity;"
    "uint16_t delta_angle_dt;uint16_t delta_velocity_dt;uint8_t delta_velocity_clipping;uint8_t[3] _padding0",
    "vehicle_magnetometer": "uint64_t timestamp;float[3] magnetometer_ga;uint8_t[4] _padding0",
    "vehicle_attitude": "uint64_t timestamp;uint64_t timestamp_sample;float[4] q",
    "vehicle_attitude_groundtruth": "uint64_t timestamp;float[4] q",
    "vehicle_gps_position": "uint64_t timestamp;uint64_t time_utc_usec;int32_t lat;int32_t lon;int32_t alt;"
    "float s_variance_m_s;float hdop;float vel_n_m_s;float vel_e_m_s;float vel_d_m_s;uint8_t fix_type;"
    "bool vel_ned_valid;uint8_t satellites_used;uint8_t[1] _padding0",
    "sensor_gps": "uint64_t timestamp;double latitude_deg;double longitude_deg;double altitude_msl_m;"
    "float vel_n_m_s;float vel_e_m_s;float vel_d_m_s;uint8_t fix_type;bool vel_ned_valid;uint8_t[2] _padding0",
    "airspeed": "uint64_t timestamp;float indicated_airspeed_m_s;float true_airspeed_m_s",
    "vehicle_status": "uint64_t timestamp;uint8_t nav_state;uint8_t arming_state;uint8_t system_type;"
    "uint8_t[5] _padding0",
    "vehicle_land_detected": "uint64_t timestamp;bool landed;uint8_t[7] _padding0",
    "estimator_status": "uint64_t timestamp;float vel_test_ratio;float mag_test_ratio;uint16_t solution_status_flags",
    "esc_report": "uint64_t timestamp;float rpm",
    "esc_status": "uint64_t timestamp;esc_report[2] esc;uint8_t count",
}


class UlogWriter:
    """Writes one message after the other. Padding at the end of a topic is left out, as PX4 does."""

    def __init__(self):
        self.data = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0)
        self.ids = {}
        self.starts = []
        self.described = set()

    def message(self, kind, body):
        self.starts.append(len(self.data))
        self.data += struct.pack("<HB", len(body), ord(kind)) + body

    def flags(self, *appended):
        offsets = [*appended, 0, 0, 0][:3]
        self.message("B", bytes(8) + bytes([bool(appended)]) + bytes(7) + struct.pack("<3Q", *offsets))

    def keyed(self, kind, key, value):
        self.message(kind, bytes([len(key)]) + key.encode() + value)

    def parameter(self, name, value):
        letter, kind = ("f", "float") if isinstance(value, float) else ("i", "int32_t")
        self.keyed("P", f"{kind} {name}", struct.pack(f"<{letter}", value))

    def text(self, t_us, text):
        self.message("L", b"\x36" + struct.pack("<Q", t_us) + text.encode())

    def members(self, topic):
        for member in FORMATS[topic].split(";"):
            kind, name = member.split(" ")
            base, _, count = kind.partition("[")
            yield base, name, int(count.rstrip("]")) if count else 0

    def subscribe(self, topic, instance=0):
        if (topic, instance) in self.ids:
            return
        if topic not in self.described:
            self.described.add(topic)
            self.message("F", f"{topic}:{FORMATS[topic]};".encode())
        number = self.ids[topic, instance] = 300 + len(self.ids)
        self.message("A", struct.pack("<BH", instance, number) + topic.encode())

    def add(self, topic, instance=0, **values):
        """One message; fields that are not given are zero."""
        self.subscribe(topic, instance)
        body = b""
        for base, name, count in self.members(topic):
            if name.startswith("_padding"):
                continue
            value = values.pop(name, [0] * count if count else 0)
            body += struct.pack(f"<{max(count, 1)}{LETTERS[base]}", *(value if count else [value]))
        assert not values, f"{topic} has no {values}"
        self.message("D", struct.pack("<H", self.ids[topic, instance]) + body)

    def instant(self, t_us, q=(1.0, 0.0, 0.0, 0.0), truth=True):
        """A level vehicle at rest, nose to magnetic north."""
        self.add("vehicle_magnetometer", timestamp=t_us, magnetometer_ga=[0.2, 0.0, 0.44])
        self.add("sensor_combined", timestamp=t_us, accelerometer_m_s2=[0.0, 0.0, -G], gyro_integral_dt=4000)
        self.add("vehicle_attitude", timestamp=t_us + 300, timestamp_sample=t_us, q=list(q))
        if truth:
            self.add("vehicle_attitude_groundtruth", timestamp=t_us, q=[1.0, 0.0, 0.0, 0.0])


@pytest.fixture
def writer():
    return UlogWriter()
