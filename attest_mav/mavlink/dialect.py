"""What a MAVLink dialect says about each message: layout, checksum extra, names. Taken from pymavlink, never typed in.

Payloads on the wire hold their fields in ``wire order`` (sorted by size, extensions last); MAVLink 2 cuts trailing
zeros off, so a payload is extended with zeros before it is unpacked.
"""

from collections.abc import Mapping
from struct import Struct, calcsize
from typing import Any, Final

from attest_mav.mavlink.message_table import message_rows

FieldValue = int | float | bytes | list[int] | list[float]


class Picked:
    """Some fields of one message, in wire order, as one packed structure; the others are skipped, and zero when packed.

    An array counts as one name and takes as many values as it has elements; text is one value, bytes.
    """

    def __init__(self, layout: "Layout", structure: Struct) -> None:
        self.layout: Final = layout
        self._structure: Final = structure
        self._unpack: Final = structure.unpack_from
        self._size: Final = structure.size
        self._zeros: Final = bytes(structure.size)

    def unpack(self, payload: bytes) -> tuple[Any, ...]:
        """The values; trailing zeros that MAVLink 2 left out are restored."""
        missing = self._size - len(payload)
        return self._unpack(payload + self._zeros[:missing] if missing > 0 else payload)

    def pack(self, *values: float | bytes) -> bytes:
        """The payload, trailing zeros not yet cut."""
        return self._structure.pack(*values)


class Layout:
    """One message of the dialect. ``fields`` are in wire order; ``codes`` are struct's (``h``, ``4f``, ``50s``)."""

    def __init__(self, message_id: int, name: str, crc_extra: int, fields: list[str], codes: list[str]) -> None:
        self.message_id: Final = message_id
        self.name: Final = name
        self.crc_extra: Final = crc_extra
        self.fields: Final = fields
        self.codes: Final = codes
        self.size: Final = calcsize("<" + "".join(codes))

    def pick(self, *names: str) -> Picked:
        """The named fields as one structure. Raises KeyError for a name that is not there or out of wire order."""
        parts = ["<"]
        wanted = list(names)
        for field, code in zip(self.fields, self.codes, strict=True):
            if wanted and field == wanted[0]:
                parts.append(code)
                wanted.pop(0)
            else:
                parts.append(f"{calcsize('<' + code)}x")
        if wanted:
            raise KeyError(f"{self.name} has no field {wanted[0]}, or it is named out of wire order")
        return Picked(self, Struct("".join(parts)))

    def offset(self, name: str) -> int:
        """Where the field begins in a payload. Raises ValueError for a name that is not there."""
        return calcsize("<" + "".join(self.codes[: self.fields.index(name)]))

    def as_dict(self, payload: bytes) -> dict[str, FieldValue]:
        """All fields by name: arrays as lists, text as bytes up to its first zero."""
        values: dict[str, FieldValue] = {}
        offset = 0
        whole = payload.ljust(self.size, b"\0")
        for field, code in zip(self.fields, self.codes, strict=True):
            structure = Struct("<" + code)
            got = structure.unpack_from(whole, offset)
            offset += structure.size
            if code.endswith("s"):
                values[field] = bytes(got[0]).split(b"\0", 1)[0]
            else:
                values[field] = got[0] if code.isalpha() else list(got)
        return values

    def from_dict(self, values: Mapping[str, Any]) -> bytes:
        """The payload with these fields and zeros elsewhere. Raises KeyError for a field the message does not have."""
        unknown = set(values) - set(self.fields)
        if unknown:
            raise KeyError(f"{self.name} has no field {', '.join(sorted(unknown))}")
        payload = b""
        for field, code in zip(self.fields, self.codes, strict=True):
            value = values.get(field)
            if value is None:
                payload += bytes(calcsize("<" + code))
            elif code.isalpha() or code.endswith("s"):
                payload += Struct("<" + code).pack(value)
            else:
                payload += Struct("<" + code).pack(*value)
        return payload


class Dialect:
    """All messages by id and by name, and the table the framer looks checksum extras up in."""

    def __init__(self, layouts: list[Layout]) -> None:
        self.by_id: Final = {layout.message_id: layout for layout in layouts}
        self.by_name: Final = {layout.name: layout for layout in layouts}
        size = max(self.by_id) + 1
        self.crc_extras: Final = [-1] * size
        """By message id: the CRC extra, -1 where the dialect has no such message."""
        self.sizes_v1: Final = bytes(self.by_id[one].size if one in self.by_id else 0xFF for one in range(256))
        """By message id: the longest payload of a MAVLink 1 frame, which no later release of a message can lengthen."""
        for layout in layouts:
            self.crc_extras[layout.message_id] = layout.crc_extra

    def flags(self, wanted: frozenset[int] | None) -> bytes:
        """One byte for each message id: 1 where it is wanted. None wants all; ids beyond the dialect are ignored."""
        size = len(self.crc_extras)
        if wanted is None:
            return b"\1" * size
        flags = bytearray(size)
        for message_id in wanted:
            if message_id < size:
                flags[message_id] = 1
        return bytes(flags)

    def layout(self, name: str) -> Layout:
        """The message called ``name``. Raises KeyError."""
        return self.by_name[name]

    def id_of(self, name: str) -> int:
        """The id of the message called ``name``. Raises KeyError."""
        return self.by_name[name].message_id

    def name_of(self, message_id: int) -> str:
        """The name of a message; ``UNKNOWN_n`` when the dialect has none."""
        layout = self.by_id.get(message_id)
        return f"UNKNOWN_{message_id}" if layout is None else layout.name


def load_dialect(module: str = "pymavlink.dialects.v20.all") -> Dialect:
    """The dialect of one of pymavlink's generated modules."""
    return Dialect([Layout(*row) for row in message_rows(module)])
