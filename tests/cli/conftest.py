"""A command of the project as a user meets it, without a process of its own."""

import sys

import pytest

from attest_mav.cli.main import main


@pytest.fixture
def attest_mav(monkeypatch, capsys):
    """Runs a command in this process; (exit code, standard output, standard error)."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["attest-mav", *map(str, arguments)])
        try:
            main()
            code = 0
        except SystemExit as end:
            code = end.code
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run
