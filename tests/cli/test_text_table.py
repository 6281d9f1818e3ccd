"""Tables for people: aligned, as narrow as the terminal, and free of escape sequences in a pipe."""

import os
import pty

import click

from attest_mav.cli import text_table
from attest_mav.cli.text_table import PIPE_COLUMNS, TextTable, figures, screen_width, words


def plain(table, width=PIPE_COLUMNS):
    return click.unstyle(table.text(width)).splitlines()


def test_words_stand_left_and_figures_right_under_their_headings():
    table = TextTable(words("error"), *figures("tilt\nrms", "max"), words("reason"))
    table.add_row("velocity-aided", "0.1", "12.5", "agrees")
    table.add_row("own", "-", "3", "none")
    assert plain(table) == [
        "",
        "                 tilt",
        " error            rms   max  reason",
        " " + 35 * "─",
        " velocity-aided   0.1  12.5  agrees",
        " own                -     3  none",
        "",
    ]


def test_a_table_that_is_too_wide_folds_its_words_and_no_figure():
    table = TextTable(words("log"), *figures("s"))
    table.add_row("a long name of several words", "1234567.5")
    assert plain(table, 25)[3:-1] == [" a long name", " of several", " words        1234567.5"]
    assert max(len(line) for line in plain(table, 25)) <= 25
    assert any("1234567.5" in line for line in plain(table, 5))


def test_a_word_that_is_too_long_is_cut_and_none_of_it_is_lost():
    table = TextTable(words("log"), *figures("s"))
    table.add_row("x" * 50, "1")
    assert "".join(line.split()[0] for line in plain(table, 24)[3:-1]) == "x" * 50


def test_rows_of_less_weight_are_dim_and_the_caption_stands_below():
    table = TextTable(words("a"))
    table.add_row("b", dim=True)
    table.caption = "1 of 2"
    assert "\x1b[2m b\x1b[0m" in table.text(PIPE_COLUMNS)
    assert plain(table)[-2:] == [" 1 of 2", ""]


def test_the_width_is_that_of_the_terminal(monkeypatch):
    ours, theirs = pty.openpty()
    with os.fdopen(theirs, "w") as terminal:
        monkeypatch.setattr(text_table.sys, "stdout", terminal)
        monkeypatch.setattr(text_table.os, "get_terminal_size", {terminal.fileno(): os.terminal_size((132, 40))}.get)
        assert screen_width() == 132
        monkeypatch.setattr(text_table.os, "get_terminal_size", lambda _: os.terminal_size((0, 0)))
        assert screen_width() == PIPE_COLUMNS
    os.close(ours)


def test_a_pipe_has_a_width_of_its_own(tmp_path, monkeypatch):
    with (tmp_path / "out").open("w") as file:
        monkeypatch.setattr(text_table.sys, "stdout", file)
        assert screen_width() == PIPE_COLUMNS
