"""An independent attitude for any MAVLink vehicle, and a verdict on the autopilot's own.

For programs: ``run`` gives the attitudes of a filter over numpy arrays, ``LiveAttitude`` those of one reading after the
other, ``replay_log`` the report on a recorded flight. docs/library.md shows them; the names below are stable, and
change only with an entry in CHANGELOG.md.

``attest_mav.types`` fixes units, frames and time for the whole package.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from attest_mav.errors import ArgumentError, AttestMavError
    from attest_mav.filters.base import AttitudeFilter, FilterInputs, FilterState, Start
    from attest_mav.filters.gradient_descent.filter import GradientDescent
    from attest_mav.filters.leveling.filter import Leveling
    from attest_mav.filters.registry import default_filter, filter_names
    from attest_mav.filters.robust_adaptive.filter import RobustAdaptive
    from attest_mav.filters.velocity_aided.filter import VelocityAided
    from attest_mav.filters.velocity_aided.parameters import BARE_SENSOR, FlightParameters
    from attest_mav.innovation import Aid, Fusion, Innovation
    from attest_mav.library.live import LiveAttitude
    from attest_mav.library.logs import read_log, replay_log
    from attest_mav.library.readings import Readings
    from attest_mav.library.running import run, run_readings
    from attest_mav.library.smoothing import smooth_readings
    from attest_mav.library.solution import Innovations, Solution
    from attest_mav.library.tables import read_table, write_table
    from attest_mav.samples import ImuSample, VelocitySample
    from attest_mav.types import North

_MODULES: Final = {
    "errors": ("ArgumentError", "AttestMavError"),
    "filters.base": ("AttitudeFilter", "FilterInputs", "FilterState", "Start"),
    "filters.gradient_descent.filter": ("GradientDescent",),
    "filters.leveling.filter": ("Leveling",),
    "filters.registry": ("default_filter", "filter_names"),
    "filters.robust_adaptive.filter": ("RobustAdaptive",),
    "filters.velocity_aided.filter": ("VelocityAided",),
    "filters.velocity_aided.parameters": ("BARE_SENSOR", "FlightParameters"),
    "innovation": ("Aid", "Fusion", "Innovation"),
    "library.live": ("LiveAttitude",),
    "library.logs": ("read_log", "replay_log"),
    "library.readings": ("Readings",),
    "library.running": ("run", "run_readings"),
    "library.smoothing": ("smooth_readings",),
    "library.solution": ("Innovations", "Solution"),
    "library.tables": ("read_table", "write_table"),
    "samples": ("ImuSample", "VelocitySample"),
    "types": ("North",),
}
"""Where each exported name is defined. A module is imported when one of its names is first asked for: the daemon does
without numpy."""

_HOMES: Final = {name: module for module, names in _MODULES.items() for name in names}

__all__ = [
    "BARE_SENSOR",
    "Aid",
    "ArgumentError",
    "AttestMavError",
    "AttitudeFilter",
    "FilterInputs",
    "FilterState",
    "FlightParameters",
    "Fusion",
    "GradientDescent",
    "ImuSample",
    "Innovation",
    "Innovations",
    "Leveling",
    "LiveAttitude",
    "North",
    "Readings",
    "RobustAdaptive",
    "Solution",
    "Start",
    "VelocityAided",
    "VelocitySample",
    "__version__",
    "default_filter",
    "filter_names",
    "read_log",
    "read_table",
    "replay_log",
    "run",
    "run_readings",
    "smooth_readings",
    "write_table",
]


def __getattr__(name: str) -> Any:
    """An exported name, or the version of the installed package."""
    if name == "__version__":
        from importlib.metadata import version  # noqa: PLC0415 - only for who asks

        return version("attest-mav")
    if name in _HOMES:
        return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
