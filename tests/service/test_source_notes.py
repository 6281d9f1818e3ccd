"""Remarks on sources, with a decoder of one attribute."""

from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.stream import Stream
from attest_mav.service.source_notes import SourceNotes

SECOND = 1_000_000_000


class Decoder:
    refusals: dict[str, str]


def test_a_reason_whose_number_changes_is_one_line_a_minute():
    notebook, decoder = Notebook(), Decoder()
    notes = SourceNotes(notebook)
    told = []
    for second in range(125):
        decoder.refusals = {"RAW_IMU": f"its time is impossible ({second} us)"}
        notes.refusals(decoder, Stream(27, "RAW_IMU", 50.0, 1), second * SECOND)
        told += [(second, note.text) for note in notebook.take()]
    assert [second for second, _ in told] == [0, 60, 120]


def test_another_reason_is_told_when_its_minute_comes():
    notebook, decoder = Notebook(), Decoder()
    notes = SourceNotes(notebook)
    for second in range(70):
        decoder.refusals = {"RAW_IMU": "first" if second == 0 else "second"}
        notes.refusals(decoder, Stream(27, "RAW_IMU", 50.0, 1), second * SECOND)
    assert [note.text for note in notebook.take()] == ["first", "second"]
