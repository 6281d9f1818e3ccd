"""Between TOML and records: errors that name the key, suggestions for misspelt ones, and records as TOML again.

Nothing here knows what is configured; ``attest_mav.config.records`` does.
"""

from collections.abc import Callable
from difflib import get_close_matches
from math import isinf, isnan
from typing import Any, Final, Literal, get_args, get_origin

import msgspec

SMALLEST: Final = 1e-15
LARGEST: Final = 1e15
"""Sizes of numbers that can be meant: the smallest default of a variance is 1e-5, of a noise 1e-7."""


def printable(text: str) -> str:
    """The text with control characters escaped, so that it cannot move a terminal's cursor or forge a line."""
    return "".join(letter if letter.isprintable() else letter.encode("unicode_escape").decode() for letter in text)


def check_keys(data: dict[str, Any], record: type[msgspec.Struct], where: str) -> None:
    """ValueError for a key that the record does not have, with the nearest one. ``where``: the path so far."""
    fields = _fields(record)
    for key, value in data.items():
        if key not in fields:
            near = get_close_matches(key, fields, n=1)
            hint = f"did you mean {near[0]}?" if near else f"expected one of {', '.join(fields)}"
            raise ValueError(f"unknown key {printable(where)}{printable(key):.60}; {hint}")
        inner = _record_in(fields[key])
        if inner is not None and isinstance(value, dict):
            check_keys(value, inner, f"{where}{key}.")
        elif inner is not None and isinstance(value, list):
            for index, table in enumerate(value):
                if isinstance(table, dict):
                    check_keys(table, inner, f"{where}{key}[{index}].")


def check_numbers(value: object, where: str, is_meant: Callable[[float], bool], expected: str) -> None:
    """ValueError for a number that cannot be meant, with what was expected in its place."""
    if isinstance(value, dict):
        for key, inner in value.items():
            check_numbers(inner, _joined(where, key), is_meant, expected)
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            check_numbers(inner, f"{where}[{index}]", is_meant, expected)
    elif isinstance(value, float) and not is_meant(value):
        raise ValueError(f"{where}: expected {expected}, got {value!r}")


def is_number(value: float) -> bool:
    """Whether it is no nan, which TOML can write: no key means it, and a range does not exclude it."""
    return not isnan(value)


def has_usual_size(value: float) -> bool:
    """Whether it is 0, infinite, or of a size that somebody can mean."""
    return value == 0.0 or isinf(value) or SMALLEST <= abs(value) <= LARGEST


def readable(message: str, data: dict[str, Any], record: type[msgspec.Struct]) -> str:
    """msgspec's "Expected `X` - at `$.a.b`" as "a.b: expected X, got Y", with the choices where there are some."""
    text, _, path = message.partition(" - at `$")
    parts = path.rstrip("`").removeprefix(".").replace("[", ".[").split(".")
    key = ".".join(parts).replace(".[", "[")
    choices = _choices(parts, record)
    found = _value_at(parts, data)
    if choices:
        return f"{key}: expected {choices}, got {found!r:.60}"
    text = (text[:1].lower() + text[1:]).replace("`", "")
    if "missing required field" in text:
        return f"{key}: the key {text.rpartition(' ')[2]} is missing"
    if ", got" in text:  # another type: the word for it is not TOML's, so a value shows how that is written
        return f"{key}: {text}{_example(parts, record)}"
    return f"{key}: {text}, got {found!r:.60}"


def _example(parts: list[str], record: type[msgspec.Struct]) -> str:
    """A value for the key under ``parts``, as a line of TOML: the example of its type, else its default; or none."""
    owner: Any = record
    for part in parts[:-1]:
        owner = _record_in(_item_of(owner) if part.startswith("[") else _fields(owner).get(part)) if owner else None
    for field in () if owner is None else msgspec.structs.fields(owner):
        if field.encode_name == parts[-1]:
            limits = [limit for limit in getattr(field.type, "__metadata__", ()) if limit.examples]
            value = limits[0].examples[0] if limits else field.default
            if isinstance(value, str | int | float | list) and value != "":
                return f"; for example {parts[-1]} = {value_text(value)}"
    return ""


def _fields(record: type[msgspec.Struct]) -> dict[str, Any]:
    """Types of the record's fields by the names they have in a file."""
    return {field.encode_name: field.type for field in msgspec.structs.fields(record)}


def _record_in(kind: Any) -> type[msgspec.Struct] | None:
    """The record that a field holds, alone or in a tuple."""
    inner = get_args(kind)[0] if get_origin(kind) is tuple else kind
    return inner if isinstance(inner, type) and issubclass(inner, msgspec.Struct) else None


def _choices(parts: list[str], record: type[msgspec.Struct]) -> str:
    """The words that the key under ``parts`` can be, as text; empty where any value of a type will do."""
    kind: Any = record
    for part in parts:
        inner = _record_in(kind)
        if part.startswith("["):
            kind = _item_of(kind)
        elif inner is not None:
            kind = _fields(inner).get(part)
    if get_origin(kind) is Literal:
        return " or ".join(get_args(kind))
    words = [word for one in get_args(kind) if get_origin(one) is Literal for word in get_args(one)]
    listed = [word for one in get_args(kind) if get_origin(one) is tuple for word in get_args(_item_of(one))]
    if words and listed:
        return f"{' or '.join(words)}, or a list of {' or '.join(listed)}"
    limits = [limit for one in get_args(kind) for limit in getattr(one, "__metadata__", ())]
    return f"{' or '.join(words)} or a number {_range_text(limits[0])}" if words and limits else ""


def _item_of(kind: Any) -> Any:
    """The type of the items of a tuple, alone or as one of several types; any other type as it is."""
    tuples = [one for one in (kind, *get_args(kind)) if get_origin(one) is tuple]
    return get_args(tuples[0])[0] if tuples else kind


def _range_text(limits: msgspec.Meta) -> str:
    """Which numbers may be given, of a range that ends with ``le``."""
    return f"from {limits.ge:g} to {limits.le:g}" if limits.gt is None else f"above {limits.gt:g}, up to {limits.le:g}"


def _value_at(parts: list[str], data: Any) -> Any:
    """The value under the path, None where there is none."""
    for part in parts:
        if isinstance(data, list) and part.startswith("["):
            data = data[int(part.strip("[]"))]
        else:
            data = data.get(part) if isinstance(data, dict) else None
    return data


Remark = Callable[[str], str]
"""What is to be written behind a value, by its full name; "" for nothing."""


def to_toml(record: msgspec.Struct, remark: Remark = lambda _name: "") -> str:
    """The record with all its defaults, as TOML that reads back to the same; remarks become comments."""
    return "\n".join(_table_lines(msgspec.to_builtins(record), "", "", remark)).strip() + "\n"


def _table_lines(table: dict[str, Any], path: str, name: str, remark: Remark) -> list[str]:
    """Plain keys first, then tables and arrays of tables under their full names.

    path: for the heading, empty inside an array. name: the full name of the table.
    """
    plain = [
        f"{key} = {value_text(value)}{_comment(remark(_joined(name, key)))}"
        for key, value in table.items()
        if not _is_table(value)
    ]
    lines = [f"[{path}]", *plain, ""] if path and plain else plain
    for key, value in table.items():
        inner = _joined(path, key)
        if isinstance(value, dict):
            lines += _table_lines(value, inner, inner, remark)
        elif _is_table(value):
            for index, entry in enumerate(value):
                lines += [f"[[{inner}]]", *_table_lines(entry, "", f"{inner}[{index}]", remark), ""]
    return lines


def _joined(path: str, key: str) -> str:
    return f"{path}.{key}" if path else key


def _comment(remark: str) -> str:
    return f"  # {printable(remark)}" if remark else ""


def _is_table(value: object) -> bool:
    return isinstance(value, dict) or (isinstance(value, list | tuple) and any(isinstance(one, dict) for one in value))


def value_text(value: object) -> str:
    """One TOML value: JSON spells strings, numbers, booleans and lists of them alike, but for infinity."""
    if isinstance(value, float):
        return repr(value)
    return msgspec.json.encode(value).decode()
