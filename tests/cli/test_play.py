"""``attest-mav play``: a recorded flight on a real link."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from attest_mav.cli.play import command
from attest_mav.errors import UnreadableDataError, UsageError

LAPS = Path(__file__).parent.parent / "data" / "copter_square_laps.tlog"


def test_a_log_is_heard_as_it_was_recorded(peer, heard):
    link = f"udpout:127.0.0.1:{peer.getsockname()[1]}"
    done = CliRunner().invoke(command, [str(LAPS), "--to", link, "--speed", "100"])
    assert done.exit_code == 0, done.output
    messages = heard(peer)
    assert f"{len(messages)} frames sent" in done.stderr
    samples = [one for one in messages if one.get_type() == "RAW_IMU"]
    assert len(samples) == 1000
    stamps = [one.time_usec for one in samples]
    assert stamps == sorted(stamps)


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ((LAPS, "--speed", "0"), UsageError, "--speed 0 is out of range"),
        ((LAPS, "--to", "sim:"), UsageError, "a log needs a real link"),
        (("missing.tlog",), UnreadableDataError, "cannot read missing.tlog"),
        ((Path(__file__),), UnreadableDataError, "no frame of a vehicle in it"),
    ],
)
def test_wrong_calls_say_what_is_expected(arguments, error, words):
    raised = CliRunner().invoke(command, [str(one) for one in arguments]).exception
    assert isinstance(raised, error)
    assert words in str(raised)
