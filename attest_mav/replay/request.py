"""The request of a replay, and the outputs beside its result.

A request can be pickled for another process. Pickle cannot restore a frozen dataclass that is compiled, since it sets
the fields one by one; so filters and window are pickled as a call of their class (``_AsCall``).
"""

from collections.abc import Callable
from dataclasses import dataclass, field, fields, is_dataclass
from math import inf
from typing import TYPE_CHECKING, Any, Final

from attest_mav.estimation.pipeline import PipelineSettings
from attest_mav.filters.base import AttitudeFilter
from attest_mav.logs.source import ByteSink, Progress
from attest_mav.replay.comparison import ComparisonSink
from attest_mav.replay.observer import FlightObserver
from attest_mav.replay.plan import VehicleChoice
from attest_mav.replay.smoothed import Smooth

if TYPE_CHECKING:
    from attest_mav.config.calibration import KeptCalibrations


class _AsCall:
    """A dataclass instance that pickle restores by calling its class with its fields."""

    def __init__(self, record: Any) -> None:
        self._record: Final = record

    def __reduce__(self) -> tuple[Any, ...]:
        """The class and the values of the fields."""
        record = self._record
        return type(record), tuple([_as_call(getattr(record, one.name)) for one in fields(record)])


def _as_call(value: Any) -> Any:
    """The value as pickle can take it; a filter that is no dataclass is left to its own ``__reduce__``."""
    return _AsCall(value) if is_dataclass(value) and not isinstance(value, type) else value


@dataclass(frozen=True)
class Window:
    """The part of a log that is read and counted, in seconds of log time."""

    start_s: float = 0.0
    """Inertial samples before this time are ignored."""
    end_s: float = inf
    """Inertial samples after this time are ignored."""
    skip_s: float = 30.0
    """Time after alignment that is left out of the figures."""


@dataclass(frozen=True)
class Request:
    """The work to do with a log."""

    filters: tuple[AttitudeFilter, ...] = ()
    """The filters to run; none for the filter that suits the log."""
    imu: str | None = None
    """Name of the inertial message; None to choose it."""
    reference: str | None = None
    """Name of the reference; None to choose it."""
    declination_deg: float | None = None
    """Declination, east positive; None to look it up."""
    window: Window = field(default_factory=Window)
    vehicle: VehicleChoice | None = None
    """The vehicle to read; None for the one with most inertial messages."""
    pipeline: PipelineSettings = field(default_factory=PipelineSettings)
    """Thresholds of the verdict, and what aids the filters."""
    as_it_came: bool = False
    """Whether filters know settings and field only from when the log tells them, as the daemon did in flight."""
    smooth: Smooth | None = None
    """The smoother, a function of a module so that pickle takes it; None to do without."""
    smooths_beside_truth: bool = False
    """Whether the smoothed attitude is compared too where the reference is another."""
    calibrations: "KeptCalibrations" = field(default_factory=dict)
    """Errors of sensors by earlier flights, which the filters begin with; see ``config.calibration``."""

    def __reduce__(self) -> tuple[Any, ...]:
        """The call that makes the request again, for pickle."""
        filters = tuple([_as_call(one) for one in self.filters])
        return Request, (
            filters,
            self.imu,
            self.reference,
            self.declination_deg,
            _as_call(self.window),
            self.vehicle,
            _as_call(self.pipeline),
            self.as_it_came,
            self.smooth,
            self.smooths_beside_truth,
            self.calibrations,
        )


class Outputs:
    """The receivers of a replay's by-products; None for no receiver."""

    def __init__(
        self,
        attitudes: ComparisonSink | None = None,
        annotated: ByteSink | None = None,
        progress: Progress | None = None,
        observer: FlightObserver | None = None,
        learned: "Callable[[KeptCalibrations], None] | None" = None,
    ) -> None:
        self.attitudes: Final = attitudes
        """Receives every attitude with its errors."""
        self.annotated: Final = annotated
        """Receives the log with the first filter's attitudes inserted."""
        self.progress: Final = progress
        """Is told the share of the work done, 0 to 1, once a stretch of the log."""
        self.observer: Final = observer
        """Sees the flight as it is replayed."""
        self.learned: Final = learned
        """Receives the errors of the sensors that the flight has shown, in the end."""
