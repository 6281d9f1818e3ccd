"""The files of ``attest-mav replay`` with the errors of sensors: the one to begin with, and the one to write."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, Final

import click

from attest_mav.errors import ConfigError
from attest_mav.runtime.files import atomic_write, reason_of

if TYPE_CHECKING:
    from attest_mav.config.calibration import KeptCalibrations


def read_calibrations(path: str | None) -> "KeptCalibrations":
    """The errors in a file; none without one. ConfigError where it holds none."""
    if path is None:
        return {}
    from attest_mav.config.calibration import parse_calibrations  # noqa: PLC0415 - for --calibration only

    try:
        found = parse_calibrations(Path(path).read_bytes())
    except OSError as error:
        raise ConfigError(f"--calibration {path}: cannot be read: {reason_of(error)}") from None
    except ValueError as error:
        expected = "expected a file that --save-calibration has written, or the state file of a service"
        raise ConfigError(f"--calibration {path}: {error}; {expected}") from None
    if not found:
        raise ConfigError(f"--calibration {path}: holds the errors of no sensor; leave the option out")
    return found


class CalibrationOutput:
    """Writes the errors that a flight has shown, beside those that were known before."""

    def __init__(self, file: IO[bytes], known: "KeptCalibrations") -> None:
        self._file: Final = file
        self._known: Final = known

    def take(self, learned: "KeptCalibrations") -> None:
        """Take the errors at the end of the flight."""
        from attest_mav.config.calibration import calibrations_text, newest  # noqa: PLC0415 - for this output only

        if not learned:
            click.echo("attest-mav: the flight has not shown the errors of its sensors: none is added", err=True)
        self._file.write(calibrations_text(newest({**self._known, **learned})))


@contextmanager
def calibration_output(path: str | None, known: "KeptCalibrations") -> Iterator[CalibrationOutput | None]:
    """The output in a file that appears when it is written; None without a path."""
    if path is None:
        yield None
        return
    with atomic_write(path) as file:
        yield CalibrationOutput(file, known)
