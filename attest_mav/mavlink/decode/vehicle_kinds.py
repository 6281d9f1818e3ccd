"""How a vehicle of each MAV_TYPE moves."""

from typing import Final

from attest_mav.mavlink.constants import (
    MAV_TYPE_COAXIAL,
    MAV_TYPE_DECAROTOR,
    MAV_TYPE_DODECAROTOR,
    MAV_TYPE_FIXED_WING,
    MAV_TYPE_GENERIC_MULTIROTOR,
    MAV_TYPE_GROUND_ROVER,
    MAV_TYPE_HELICOPTER,
    MAV_TYPE_HEXAROTOR,
    MAV_TYPE_OCTOROTOR,
    MAV_TYPE_QUADROTOR,
    MAV_TYPE_SURFACE_BOAT,
    MAV_TYPE_TRICOPTER,
    MAV_TYPE_VTOL_DUOROTOR,
    MAV_TYPE_VTOL_QUADROTOR,
    MAV_TYPE_VTOL_RESERVED2,
    MAV_TYPE_VTOL_RESERVED3,
    MAV_TYPE_VTOL_RESERVED4,
    MAV_TYPE_VTOL_RESERVED5,
    MAV_TYPE_VTOL_TILTROTOR,
)
from attest_mav.types import VehicleKind

WINGS: Final = (
    MAV_TYPE_FIXED_WING,
    MAV_TYPE_VTOL_DUOROTOR,
    MAV_TYPE_VTOL_QUADROTOR,
    MAV_TYPE_VTOL_TILTROTOR,
    MAV_TYPE_VTOL_RESERVED2,
    MAV_TYPE_VTOL_RESERVED3,
    MAV_TYPE_VTOL_RESERVED4,
    MAV_TYPE_VTOL_RESERVED5,
)
"""Aeroplanes, and the VTOL kinds."""
COPTERS: Final = (
    MAV_TYPE_QUADROTOR,
    MAV_TYPE_COAXIAL,
    MAV_TYPE_HELICOPTER,
    MAV_TYPE_HEXAROTOR,
    MAV_TYPE_OCTOROTOR,
    MAV_TYPE_TRICOPTER,
    MAV_TYPE_DODECAROTOR,
    MAV_TYPE_DECAROTOR,
    MAV_TYPE_GENERIC_MULTIROTOR,
)
"""Copters and helicopters."""
SURFACE_VEHICLES: Final = (
    MAV_TYPE_GROUND_ROVER,
    MAV_TYPE_SURFACE_BOAT,
)
"""Ground vehicles and boats."""


def vehicle_kind(vehicle_type: int) -> VehicleKind:
    """How a vehicle of this MAV_TYPE moves; UNKNOWN for a type that is none of the above."""
    if vehicle_type in WINGS:
        return VehicleKind.WING
    if vehicle_type in COPTERS:
        return VehicleKind.ROTARY
    return VehicleKind.SURFACE if vehicle_type in SURFACE_VEHICLES else VehicleKind.UNKNOWN
