"""One output on one link: its own rate, the one that a station has set, and the one in the place of another output."""

from dataclasses import dataclass
from typing import Final

from attest_mav.mavlink.component.onboard import SUBSTITUTE_NS
from attest_mav.mavlink.component.outputs import OUTPUTS, SUBSTITUTE, TEXTS, Output
from attest_mav.mavlink.component.schedule import STOPPED, Schedule
from attest_mav.mavlink.signing.settings import SigningSettings


@dataclass(frozen=True)
class PortSettings:
    """The outputs of one link."""

    publish: tuple[str, ...] = ("attitude_quaternion", TEXTS)
    """Names of the outputs that are sent without being requested."""
    yields: bool = True
    """Outputs that can be taken for the autopilot's own are held back while another onboard computer of the vehicle is
    heard on the link."""
    yields_to_stations: bool = True
    """The same while a ground station is heard on a link that brings the vehicle too."""
    outputs: tuple[Output, ...] = OUTPUTS
    """All outputs that can be published or requested."""
    parameters: bool = False
    """Whether our parameters can be read and set here."""
    signing: SigningSettings | None = None
    """The signatures of the link, None where nothing is signed."""


class Channel:
    """One output on one link, whose attitude has the rate ``hz``."""

    def __init__(self, output: Output, settings: PortSettings, hz: float) -> None:
        self.output: Final = output
        self.schedule = _schedule(output, settings, hz)
        self._settings = settings
        self._substitute = _substitute(output, settings, hz)

    def use(self, settings: PortSettings, hz: float) -> None:
        """Send by other settings and at another rate of our own from now on, Hz; a station's interval stays."""
        self._settings = settings
        interval = self.schedule.interval
        self.schedule = _schedule(self.output, self._settings, hz)
        self._substitute = _substitute(self.output, self._settings, hz)
        self.schedule.interval = interval

    def due(self, t_ns: int, holds_back: bool) -> bool:
        """Whether the sample at ``t_ns`` is to be sent. holds_back: outputs that mislead are held back."""
        if holds_back and self.output.misleads:
            return False
        if holds_back and self._substitute is not None and self.schedule.period_ns == STOPPED:
            return self._substitute.due(t_ns)
        return self.schedule.due(t_ns)


def _schedule(output: Output, settings: PortSettings, hz: float) -> Schedule:
    """The schedule of an output on a link whose attitude has the rate ``hz``; silent where it is not published."""
    return Schedule(int(1e9 / (output.hz or hz)) if output.name in settings.publish else STOPPED)


def _substitute(output: Output, settings: PortSettings, hz: float) -> Schedule | None:
    """The schedule of the output that goes out in the place of one that is published and held back."""
    replaced = [one for one in settings.outputs if one.misleads and not one.only_configured]
    misleads = any(one.name in settings.publish for one in replaced)
    return Schedule(max(int(1e9 / hz), SUBSTITUTE_NS)) if misleads and output.message == SUBSTITUTE else None
