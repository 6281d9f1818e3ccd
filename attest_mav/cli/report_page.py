"""The page of a replayed flight on its way into a file."""

from importlib.resources import files
from typing import IO, Any, Final

from attest_mav.cli.version import version_text
from attest_mav.report.page import Assets, page_of
from attest_mav.report.recorder import FlightRecorder


class ReportPage:
    """Collects the series of one flight, and writes them with its figures."""

    def __init__(self, file: IO[bytes]) -> None:
        self.recorder: Final = FlightRecorder()
        self._file: Final = file

    def write(self, report: dict[str, Any]) -> None:
        """Write the page in UTF-8. Bytes of a name that are no text become question marks."""
        self.recorder.finish()
        folder = files("attest_mav.report")
        names = ("palette.css", "page.css", "page.js")
        palette, style, script = [folder.joinpath(name).read_text(encoding="utf-8") for name in names]
        page = page_of(report, self.recorder, Assets(palette + style, script, version_text()))
        self._file.write(page.encode(errors="replace"))
