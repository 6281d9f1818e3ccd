"""Logs named as files, folders and patterns."""

import pytest

from attest_mav.errors import UnreadableDataError
from attest_mav.runtime.log_paths import is_log_name, log_paths


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "deep" / "er").mkdir(parents=True)
    for name in ("b.tlog", "a.BIN", "deep/c.log", "deep/er/d.ulg.gz", "notes.txt", ".hidden.tlog", "deep/e.tlog.raw"):
        (tmp_path / name).write_bytes(b"1")
    return tmp_path


def test_a_folder_stands_for_the_logs_in_it_and_below(folder):
    expected = [str(folder / name) for name in ("a.BIN", "b.tlog", "deep/c.log", "deep/er/d.ulg.gz")]
    assert log_paths([str(folder)]) == expected


def test_a_pattern_stands_for_the_files_that_match(folder):
    assert log_paths([str(folder / "*.t*")]) == [str(folder / "b.tlog"), str(folder / "notes.txt")]
    assert log_paths([str(folder / "**" / "*.log")]) == [str(folder / "deep" / "c.log")]


def test_a_file_is_itself_whatever_its_name_and_each_counts_once(folder):
    odd = folder / "odd[1].dat"
    odd.write_bytes(b"1")
    named = [str(odd), str(folder / "missing.tlog"), str(folder / "b.tlog"), str(folder / "b.tlog")]
    assert log_paths(named) == named[:3]


@pytest.mark.parametrize(("name", "words"), [("", "no log in the folder"), ("*.ulg", "no file matches")])
def test_nothing_found_is_an_error_that_names_what_was_looked_for(tmp_path, name, words):
    with pytest.raises(UnreadableDataError, match=words) as caught:
        log_paths([f"{tmp_path}/{name}"])
    assert str(tmp_path) in str(caught.value)


@pytest.mark.parametrize(("name", "is_log"), [("A.TLOG", True), ("x.bin.zip", True), ("x.zip", False), ("log", False)])
def test_names_of_logs(name, is_log):
    assert is_log_name(name) is is_log
