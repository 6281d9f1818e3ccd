"""The messages of a ULog besides its data: parameters, information, texts.

(PX4's ULog file format. A key is a type and a name, ``float MPC_XY_P``.)
"""

import re
from struct import Struct, error
from typing import Final

from attest_mav.logs.ulog.layout import KINDS
from attest_mav.logs.ulog.reader import COMPONENT, MICRO_NS, SYSTEM
from attest_mav.mavlink.constants import MAV_AUTOPILOT_PX4
from attest_mav.mavlink.decode.autopilot_parameters import parameters_of
from attest_mav.mavlink.decode.firmware import text_samples
from attest_mav.samples import Sample
from attest_mav.types import Version
from attest_mav.vehicle_reports import FirmwareSample, ParameterSample

MODULE: Final = re.compile(r"\[\w+\] ")
"""The module that a text comes from: "[sensors] Gyro #0 fail"."""
TEXT_AT: Final = 9
"""Place of the text in a logged string, behind its level and time."""
TAGGED_TEXT_AT: Final = 11
"""The same in one with a tag."""
RELEASE: Final = "ver_sw_release"
_TIME: Final = Struct("<Q")


class Keyed:
    """A message with a key and a value. kind: the letter of ``struct`` of the value, "" for another one."""

    def __init__(self, kind: str, name: str, value: bytes) -> None:
        self.kind: Final = kind
        self.name: Final = name
        self.value: Final = value

    @property
    def number(self) -> float | None:
        """The value as a number, None if it is none."""
        if self.kind in {"", "s"}:
            return None
        try:
            return float(Struct(f"<{self.kind}").unpack(self.value)[0])
        except error:
            return None


def keyed(body: bytes) -> Keyed:
    """The key and the value in a message's body."""
    end = 1 + body[0] if body else 0
    kind, _, name = body[1:end].decode("ascii", "replace").partition(" ")
    return Keyed(KINDS.get(kind, ""), name, body[end:])


class MessageReader:
    """Makes samples of these messages."""

    def __init__(self) -> None:
        self._known: Final = {one.name: one for one in parameters_of(MAV_AUTOPILOT_PX4)}
        self._told: Final[dict[str, float]] = {}

    def parameter(self, body: bytes, rx_ns: int) -> list[Sample]:
        """One ParameterSample; those behind the first of a parameter are changes."""
        told = keyed(body)
        parameter, number = self._known.get(told.name), told.number
        value = None if parameter is None or number is None else parameter.value(number)
        if parameter is None or number is None or value is None:
            return []
        is_listed = self._told.get(told.name, number) == number
        self._told[told.name] = number
        name, setting = told.name, parameter.setting
        return [ParameterSample("parameter", SYSTEM, COMPONENT, rx_ns, name, setting, value, is_listed)]

    def information(self, body: bytes, rx_ns: int) -> list[Sample]:
        """A FirmwareSample where the version of the firmware is told."""
        told = keyed(body)
        number = told.number
        if told.name != RELEASE or not number:
            return []
        return [FirmwareSample(RELEASE, SYSTEM, COMPONENT, rx_ns, version_of(int(number)))]

    def text(self, body: bytes, text_at: int) -> list[Sample]:
        """The samples of ``text_samples``."""
        if len(body) < text_at:
            return []
        rx_ns = _TIME.unpack_from(body, text_at - _TIME.size)[0] * MICRO_NS
        text = body[text_at:].decode("utf-8", "replace").strip()
        return text_samples("logging", SYSTEM, COMPONENT, rx_ns, MODULE.sub("", text, count=1))


def version_of(number: int) -> Version:
    """Major, minor and patch; the lowest of the four bytes is the kind of release."""
    return (number >> 24) & 0xFF, (number >> 16) & 0xFF, (number >> 8) & 0xFF
