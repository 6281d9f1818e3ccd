"""Layouts against pymavlink's own packing, message by message."""

import random

import pytest
from pymavlink.dialects.v20 import all as pymav

from attest_mav.mavlink.dialect import load_dialect


def test_every_message_of_pymavlinks_dialect_is_there(dialect):
    assert set(dialect.by_id) == set(pymav.mavlink_map)
    for message_id, message in pymav.mavlink_map.items():
        layout = dialect.by_id[message_id]
        assert layout is dialect.layout(message.msgname)
        assert (layout.name, layout.crc_extra, layout.size) == (
            message.msgname,
            message.crc_extra,
            message.unpacker.size,
        )
        assert dialect.id_of(layout.name) == message_id
        assert dialect.name_of(message_id) == layout.name


def same(ours, theirs):
    """Equal, NaN included; pymavlink turns text into str and cuts it at its zeros."""
    if isinstance(theirs, list):
        return len(ours) == len(theirs) and all(map(same, ours, theirs))
    if isinstance(theirs, str):
        return ours == theirs.encode()
    return ours == theirs or (ours != ours and theirs != theirs)  # noqa: PLR0124 - NaN


def test_fields_of_every_message_are_pymavlinks(dialect):
    """Random payloads, cut short as MAVLink 2 does. Text without zeros or bytes above 127, which pymavlink decodes."""
    rng = random.Random(1)
    mav = pymav.MAVLink(None)
    for message_id, message in pymav.mavlink_map.items():
        payload = bytes(rng.randint(1, 127) for _ in range(rng.randint(1, message.unpacker.size)))
        header = bytes((0xFD, len(payload), 0, 0, 0, 1, 1, message_id & 255, message_id >> 8 & 255, message_id >> 16))
        crc = pymav.x25crc(header[1:] + payload + bytes([message.crc_extra])).crc
        parsed = mav.decode(bytearray(header + payload + crc.to_bytes(2, "little")))
        values = dialect.by_id[message_id].as_dict(payload)
        assert set(values) == set(parsed.get_fieldnames())
        for field in parsed.get_fieldnames():
            assert same(values[field], getattr(parsed, field)), (message.msgname, field)


def test_from_dict_is_the_inverse_of_as_dict(dialect):
    rng = random.Random(2)
    for layout in dialect.by_id.values():
        payload = bytes(rng.randint(1, 60) for _ in range(layout.size))
        assert layout.from_dict(layout.as_dict(payload)) == payload


def test_from_dict_leaves_the_rest_zero(dialect):
    layout = dialect.layout("RAW_IMU")
    values = layout.as_dict(layout.from_dict({"zacc": -1000}))
    assert values == {field: -1000 if field == "zacc" else 0 for field in layout.fields}


def test_picked_fields_come_in_wire_order(dialect):
    layout = dialect.layout("ATTITUDE_QUATERNION")
    payload = layout.from_dict({"time_boot_ms": 5, "q2": 0.5, "yawspeed": 2.0, "repr_offset_q": [1.0, 2.0, 3.0, 4.0]})
    assert layout.pick("time_boot_ms", "q2", "yawspeed", "repr_offset_q").unpack(payload) == (5, 0.5, 2, 1, 2, 3, 4)
    assert layout.pick("q2").unpack(payload) == (0.5,)
    assert layout.pick("q2").unpack(b"\1") == (0.0,)
    assert layout.pick("q1", "q3").pack(1.0, 2.0) == layout.from_dict({"q1": 1.0, "q3": 2.0})


@pytest.mark.parametrize("names", [("nonsense",), ("zacc", "xacc"), ("xacc", "xacc")])
def test_a_name_that_is_not_there_or_out_of_order_is_refused(dialect, names):
    with pytest.raises(KeyError, match=f"RAW_IMU has no field {names[-1]}"):
        dialect.layout("RAW_IMU").pick(*names)


def test_from_dict_refuses_a_field_that_is_not_there(dialect):
    with pytest.raises(KeyError, match="ATTITUDE has no field rol"):
        dialect.layout("ATTITUDE").from_dict({"rol": 1.0})


def test_a_name_for_an_id_that_is_not_there(dialect):
    assert dialect.name_of(59999) == "UNKNOWN_59999"


def test_another_dialect_can_be_loaded():
    common = load_dialect("pymavlink.dialects.v20.common")
    assert "RAW_IMU" in common.by_name
    assert "AHRS2" not in common.by_name
