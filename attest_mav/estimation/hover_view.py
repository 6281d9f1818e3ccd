"""The view of a VTOL plane: in the hover ATTITUDE shows the aircraft turned about its pitch axis.

A tailsitter is turned by 90 degrees, any other by its own pitch trim of the hover. Which view holds in a transition, or
in a mode that flies both ways, no message tells.
"""

from enum import IntEnum
from math import pi, radians
from typing import Final

from attest_mav.algebra import is_finite_number
from attest_mav.estimation.vehicle import Vehicle
from attest_mav.types import VehicleKind
from attest_mav.vehicle_settings import Setting

HOVER_MODES: Final = frozenset([17, 18, 19, 20, 21, 22, 23])
"""ArduPlane's modes QSTABILIZE, QHOVER, QLOITER, QLAND, QRTL, QAUTOTUNE and QACRO."""
BOTH_WAYS: Final = frozenset([10, 14, 15, 25])
"""AUTO, AVOID_ADSB, GUIDED and LOITER_ALT_QLAND hover or fly."""
VTOL_TYPES: Final = frozenset(range(19, 26))
"""MAV_TYPE of the VTOL kinds."""
TAILSITTER_TYPES: Final = frozenset([19, 20, 23])
"""MAV_TYPE of the VTOL kinds that hover nose-up."""
TAILSITTER_FRAME: Final = 10.0
"""Frame class that made a plane a tailsitter before there was a parameter for it."""
SAME: Final = radians(0.2)
"""Views that differ by less are one."""
NOSE_UP: Final = 0.5 * pi
ONLY_TAILSITTERS: Final = (4, 1, 0)
"""Before this firmware other VTOL planes had no view of the hover."""


class HoverView(IntEnum):
    """Whether ATTITUDE shows the view of the hover."""

    NO = 0
    YES = 1
    UNKNOWN = 2


def hover_view(vehicle: Vehicle) -> HoverView:
    """The view at present."""
    if not _hovers(vehicle):
        return HoverView.NO
    if _is_tailsitter(vehicle):
        return HoverView.UNKNOWN
    firmware = vehicle.firmware
    if firmware is not None and firmware < ONLY_TAILSITTERS:
        return HoverView.NO
    if vehicle.mode in HOVER_MODES:
        return HoverView.YES
    if vehicle.mode not in BOTH_WAYS:
        return HoverView.NO
    apart = hover_angle(vehicle) - vehicle.settings.get_or(Setting.PITCH_TRIM, 0.0)
    return HoverView.NO if abs(apart) < SAME else HoverView.UNKNOWN


def hover_angle(vehicle: Vehicle) -> float:
    """The pitch of the hover's view, rad."""
    trim = vehicle.settings.get_or(Setting.HOVER_PITCH_TRIM, 0.0)
    return trim + NOSE_UP if _is_tailsitter(vehicle) else trim


def _hovers(vehicle: Vehicle) -> bool:
    """True for a VTOL plane: by its setting, or by its MAV_TYPE while that is not told."""
    if vehicle.kind != VehicleKind.WING:
        return False
    told = vehicle.settings.get(Setting.HOVERS)
    return told != 0.0 if is_finite_number(told) else vehicle.vehicle_type in VTOL_TYPES


def _is_tailsitter(vehicle: Vehicle) -> bool:
    settings = vehicle.settings
    told = settings.get(Setting.TAILSITTER)
    if is_finite_number(told) and told != 0.0:
        return True
    return settings.get(Setting.HOVER_FRAME) == TAILSITTER_FRAME or vehicle.vehicle_type in TAILSITTER_TYPES
