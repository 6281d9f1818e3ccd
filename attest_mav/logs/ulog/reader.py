"""The base of all readers of topics."""

from collections.abc import Sequence
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.samples import Sample

SYSTEM: Final = 1
COMPONENT: Final = 1
"""The ids of the vehicle: a log is that of one vehicle."""
MICRO_NS: Final = 1000
TIME: Final = "timestamp"
"""Of publication, us; every topic has it."""
SAMPLE_TIME: Final = "timestamp_sample|timestamp"
"""Of the sensor's reading, where the topic tells it."""


@mypyc_attr(allow_interpreted_subclasses=True)
class TopicReader:
    """Makes samples of one instance of a topic. names: the fields that it wants, as for ``Selection``; time first."""

    def __init__(self, names: Sequence[str] = (TIME,)) -> None:
        self.names: Final = tuple(names)

    def read(self, t_ns: int, numbers: list[float]) -> list[Sample]:
        """The samples of a message. t_ns: the first number in ns."""
        return []
