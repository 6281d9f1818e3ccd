"""The files of ``attest-mav replay`` with the errors of sensors: the one to begin with, and the one to write."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from attest_mav.errors import ConfigError
from attest_mav.runtime.files import atomic_write, check_writable, reason_of

if TYPE_CHECKING:
    from attest_mav.config.calibration import KeptCalibrations

LARGEST_BYTES: Final = 1 << 20
"""A file of many vehicles has some ten thousand."""


def read_calibrations(path: str | None) -> "KeptCalibrations":
    """The errors in a file; none without one. ConfigError where it holds none."""
    if path is None:
        return {}
    from attest_mav.config.calibration import parse_calibrations  # noqa: PLC0415 - for --calibration only

    try:
        found = parse_calibrations(_bytes_of(Path(path)))
    except OSError as error:
        raise ConfigError(f"--calibration {path}: cannot be read: {reason_of(error)}") from None
    except ValueError as error:
        expected = "expected a file that --save-calibration has written, or the state file of a service"
        raise ConfigError(f"--calibration {path}: {error}; {expected}") from None
    if not found:
        raise ConfigError(f"--calibration {path}: holds the errors of no sensor; leave the option out")
    return found


def _bytes_of(path: Path) -> bytes:
    """The bytes of a file that is small enough to be one of these."""
    if not path.is_file() and path.exists():
        raise ValueError("is no file")
    with path.open("rb") as file:
        data = file.read(LARGEST_BYTES + 1)
    if len(data) > LARGEST_BYTES:
        raise ValueError(f"is larger than {LARGEST_BYTES} bytes")
    return data


class CalibrationOutput:
    """The errors that a flight has shown, beside those that were known before."""

    def __init__(self, known: "KeptCalibrations") -> None:
        self._known: Final = known
        self.text = b""
        """Of the file; empty while there is nothing to write."""

    def take(self, learned: "KeptCalibrations") -> None:
        """Take the errors at the end of the flight."""
        from attest_mav.config.calibration import calibrations_text, with_learned  # noqa: PLC0415 - for this alone

        if not learned:
            click.echo("attest-mav: the flight has not shown the errors of its sensors: none is added", err=True)
        if kept := with_learned(self._known, learned):
            self.text = calibrations_text(kept)


@contextmanager
def calibration_output(path: str | None, known: "KeptCalibrations") -> Iterator[CalibrationOutput | None]:
    """The output, whose file is written in the end where there is something to write; None without a path.

    UnwritableError at the begin where it cannot be written.
    """
    if path is None:
        yield None
        return
    check_writable(path)
    output = CalibrationOutput(known)
    yield output
    if output.text:
        with atomic_write(path) as file:
            file.write(output.text)
