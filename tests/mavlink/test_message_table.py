"""The table of messages that is kept: the same as pymavlink's module tells, and made anew when that changes."""

import sys

import pytest

from attest_mav.mavlink import message_table
from attest_mav.mavlink.message_table import message_rows, rows_of_module

ALL = "pymavlink.dialects.v20.all"
MODULE = """
class Message:
    id, msgname, crc_extra = 7, {name!r}, 21
    native_format, lengths, array_lengths, ordered_fieldnames = b"<cHf", [1, 2, 1], [9, 0, 0], ["a", "b", "c"]

mavlink_map = {{7: Message}}
"""


def row(name):
    return (7, name, 21, ["a", "b", "c"], ["9s", "2H", "f"])


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """The folder in which tables are kept."""
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path / "kept"))
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    return tmp_path / "kept"


@pytest.fixture
def own(tmp_path, monkeypatch, kept):
    """Writes a dialect of one message, which then is the module ``own_dialect``; its table is kept in ``kept``."""
    assert not kept.exists()
    monkeypatch.syspath_prepend(tmp_path)

    def write(name):
        (tmp_path / "own_dialect.py").write_text(MODULE.format(name=name))
        sys.modules.pop("own_dialect", None)

    yield write
    sys.modules.pop("own_dialect", None)


def files(folder):
    return [one for one in folder.rglob("messages_of_*") if one.is_file()]


def test_what_is_kept_is_what_the_module_tells(kept, monkeypatch):
    made = message_rows(ALL)
    assert made == rows_of_module(ALL)
    assert len(files(kept)) == 1
    monkeypatch.delattr(message_table, "rows_of_module")
    assert message_rows(ALL) == made


def test_the_table_is_made_anew_when_the_module_has_changed(own):
    own("ONE")
    assert message_rows("own_dialect") == [row("ONE")]
    own("THREE")
    assert message_rows("own_dialect") == [row("THREE")]


@pytest.mark.parametrize("damage", [b"", b"\xff", b"i\1\0\0\0", b"N"])
def test_a_table_that_is_damaged_is_made_anew(kept, own, damage):
    own("ONE")
    message_rows("own_dialect")
    (path,) = files(kept)
    path.write_bytes(damage)
    assert message_rows("own_dialect") == [row("ONE")]


def test_nothing_is_kept_where_python_keeps_no_bytecode(kept, own, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    own("ONE")
    assert message_rows("own_dialect") == [row("ONE")]
    assert files(kept) == []


def test_where_nothing_can_be_written_the_module_is_read_every_time(kept, own):
    kept.write_text("no folder")
    own("ONE")
    assert message_rows("own_dialect") == message_rows("own_dialect") == [row("ONE")]


def test_a_dialect_that_is_not_there_is_an_error():
    with pytest.raises(ModuleNotFoundError):
        message_rows("pymavlink.dialects.v20.nobodys")
