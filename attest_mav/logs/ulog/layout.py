"""The layout of a topic's data: which field stands where, from the formats that the log describes.

A format is ``name:type field;type field;...``, without padding but for fields called ``_padding``; a type may be an
array (``float[3]``) or another format. The padding at the end of a message is not written.
"""

import re
from collections.abc import Mapping, Sequence
from math import nan
from struct import Struct, calcsize
from typing import Final

KINDS: Final = {
    "int8_t": "b",
    "uint8_t": "B",
    "int16_t": "h",
    "uint16_t": "H",
    "int32_t": "i",
    "uint32_t": "I",
    "int64_t": "q",
    "uint64_t": "Q",
    "float": "f",
    "double": "d",
    "bool": "?",
    "char": "s",
}
"""Letters of ``struct`` by type."""
DEEPEST: Final = 8
"""A format nests no deeper."""
LARGEST: Final = 65535
"""Bytes of a message; a layout that is larger is none."""
MOST_FIELDS: Final = 1 << 17
MOST_TEXT: Final = 1 << 20
"""A log describes no more fields and in no more characters; PX4's logs have 10,000 of the ones and 100,000 of the
others. What goes beyond is not believed: a message of twenty bytes can describe 65,535 fields."""
_ARRAY: Final = re.compile(r"([A-Za-z0-9_]+)\[(\d{1,5})\]\Z")
_FORMAT: Final = re.compile(r"[A-Za-z0-9_-]+:[A-Za-z0-9_\[\] ;.-]*\Z")


class Field:
    """One number of a topic."""

    def __init__(self, offset: int, kind: str) -> None:
        self.offset: Final = offset
        self.kind: Final = kind


class Layout:
    """The numbers of a topic by name; elements of an array are ``name[0]``, ``name[1]``, ..."""

    def __init__(self, fields: Mapping[str, Field], size: int) -> None:
        self.fields: Final = dict(fields)
        self.size: Final = size


class Formats:
    """The formats that a log describes."""

    def __init__(self) -> None:
        self._members: Final[dict[str, list[tuple[str, str]]]] = {}
        self._texts: Final[dict[str, str]] = {}
        self._layouts: Final[dict[str, Layout | None]] = {}
        self._fields_left = MOST_FIELDS
        self._text_left = MOST_TEXT

    def learn(self, text: str) -> None:
        """Take a format."""
        if _FORMAT.match(text) is None:
            return
        name, _, members = text.partition(":")
        if self._texts.get(name) == members or len(text) > self._text_left:
            return
        self._text_left -= len(text)
        self._texts[name] = members
        self._layouts.clear()
        pairs = [member.split(" ", 1) for member in members.split(";") if " " in member]
        self._members[name] = [(kind, field) for kind, field in pairs]

    def layout(self, topic: str) -> Layout | None:
        """The layout of a topic; None where its format is missing, or makes no sense."""
        if topic not in self._layouts:
            fields: dict[str, Field] = {}
            size = self._place(topic, "", 0, fields, DEEPEST)
            self._layouts[topic] = None if size is None else Layout(fields, size)
        return self._layouts[topic]

    def _place(self, topic: str, prefix: str, at: int, fields: dict[str, Field], depth: int) -> int | None:
        """Place the fields of a format from ``at`` on; where they end, None for a format that cannot be placed."""
        members = self._members.get(topic)
        if members is None or depth == 0:
            return None
        for kind, name in members:
            array = _ARRAY.match(kind)
            count = 1 if array is None else int(array[2])
            element = kind if array is None else array[1]
            for index in range(count):
                full = prefix + name if array is None else f"{prefix}{name}[{index}]"
                letter = KINDS.get(element)
                if letter is None:
                    end = self._place(element, f"{full}.", at, fields, depth - 1)
                else:
                    fields[full] = Field(at, letter)
                    self._fields_left -= 1
                    end = at + calcsize(f"<{letter}")
                if end is None or end == at or end > LARGEST or self._fields_left < 0:
                    return None
                at = end
        return at


class Selection:
    """The wanted numbers of a topic, in the wanted order. Each name may have others for older firmwares, with ``|``."""

    def __init__(self, layout: Layout, names: Sequence[str]) -> None:
        found = [next((one for one in name.split("|") if one in layout.fields), "") for name in names]
        wanted = sorted({layout.fields[name].offset for name in found if name})
        kinds = {field.offset: field.kind for field in layout.fields.values()}
        text, end = "<", 0
        for offset in wanted:
            text += f"{offset - end}x{kinds[offset]}"
            end = offset + calcsize(f"<{kinds[offset]}")
        self.size: Final = end
        """Bytes that a message needs to have."""
        self._struct: Final = Struct(text)
        self._places: Final = [wanted.index(layout.fields[name].offset) if name else -1 for name in found]

    def numbers(self, data: bytes, at: int) -> list[float]:
        """The numbers of the data that begin at ``at``; NaN for a field that the topic lacks."""
        raw = self._struct.unpack_from(data, at)
        return [float(raw[place]) if place >= 0 else nan for place in self._places]
