"""The checksum against pymavlink's byte-by-byte one."""

from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20.all import x25crc

from attest_mav.mavlink.wire.checksum import checksum, explaining_extra, with_checksum


@settings(derandomize=True, max_examples=200)
@given(data=st.binary(max_size=300), extra=st.integers(0, 255))
def test_it_is_pymavlinks(data, extra):
    assert checksum(b"before" + data + b"behind", 6, 6 + len(data), extra) == x25crc(data + bytes([extra])).crc


@settings(derandomize=True, max_examples=50)
@given(data=st.binary(min_size=2, max_size=300), extra=st.integers(0, 255))
def test_a_checksum_goes_on_low_byte_first(data, extra):
    crc = x25crc(data[1:] + bytes([extra])).crc
    assert with_checksum(data, extra) == data + bytes([crc & 0xFF, crc >> 8])


@settings(derandomize=True, max_examples=100)
@given(data=st.binary(max_size=60), received=st.integers(0, 0xFFFF))
def test_the_extra_that_explains_a_checksum_is_the_one_that_gives_it(data, received):
    extras = [extra for extra in range(256) if x25crc(data + bytes([extra])).crc == received]
    found = explaining_extra(data + received.to_bytes(2, "little"), 0, len(data))
    assert [found] == extras if extras else found == -1


def test_every_extra_is_found():
    for extra in range(256):
        data = b"some frame"
        received = x25crc(data + bytes([extra])).crc
        assert explaining_extra(data + received.to_bytes(2, "little"), 0, len(data)) == extra
