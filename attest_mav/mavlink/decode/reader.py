"""The base of all readers: payload to samples, in SI units and radians; a refusal has a reason."""

from abc import abstractmethod
from typing import Final

from attest_mav.mavlink.wire.frame import Frame
from attest_mav.samples import Sample


class Reader:
    """Reads one kind of message. refusal: why the last one gave no sample, or empty; refused: how many gave none."""

    def __init__(self, name: str) -> None:
        self.name: Final = name
        self.refusal = ""
        self.refused = 0

    @abstractmethod
    def read(self, frame: Frame) -> list[Sample]:
        """The samples in one frame of this kind."""

    def refuse(self, frame: Frame, reason: str) -> list[Sample]:
        """No samples, and the reason."""
        self.refused += 1
        self.refusal = f"{self.name} of system {frame.system}: {reason}"
        return []
