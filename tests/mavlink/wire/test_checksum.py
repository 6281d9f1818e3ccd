"""The mirrored checksum against pymavlink's byte-by-byte one."""

from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20.all import x25crc

from attest_mav.mavlink.wire.checksum import explaining_extra, mirrored, mirrored_crc, with_checksum


def bits_reversed(value, width):
    return int(format(value, f"0{width}b")[::-1], 2)


@settings(derandomize=True, max_examples=200)
@given(data=st.binary(max_size=300), extra=st.integers(0, 255))
def test_it_is_pymavlinks_with_its_bits_reversed(data, extra):
    ours = mirrored_crc(mirrored(data), 0, len(data), bits_reversed(extra, 8))
    assert ours == bits_reversed(x25crc(data + bytes([extra])).crc, 16)


@settings(derandomize=True, max_examples=50)
@given(data=st.binary(min_size=2, max_size=300), extra=st.integers(0, 255))
def test_a_checksum_goes_on_low_byte_first(data, extra):
    crc = x25crc(data[1:] + bytes([extra])).crc
    assert with_checksum(data, extra) == data + bytes([crc & 0xFF, crc >> 8])


@settings(derandomize=True, max_examples=100)
@given(data=st.binary(max_size=60), checksum=st.integers(0, 0xFFFF))
def test_the_extra_that_explains_a_checksum_is_the_one_that_gives_it(data, checksum):
    extras = [extra for extra in range(256) if x25crc(data + bytes([extra])).crc == checksum]
    found = explaining_extra(mirrored(data + checksum.to_bytes(2, "little")), 0, len(data))
    assert [bits_reversed(found, 8)] == extras if extras else found == -1


def test_every_extra_is_found():
    for extra in range(256):
        data = b"some frame"
        checksum = x25crc(data + bytes([extra])).crc
        found = explaining_extra(mirrored(data + checksum.to_bytes(2, "little")), 0, len(data))
        assert bits_reversed(found, 8) == extra
