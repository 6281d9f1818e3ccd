"""Frames of others on the line: stations, other components, a second vehicle, and forgers."""

from collections.abc import Callable
from math import radians
from typing import Any, Final

from attest_mav.algebra import q_to_euler
from attest_mav.evaluation.disturbed_flights.frames import edited, message_id, shifted
from attest_mav.evaluation.disturbed_flights.link_faults import MeddleMaker
from attest_mav.evaluation.disturbed_flights.row import SYSTEM, Meddle, Tools
from attest_mav.mavlink.constants import (
    MAV_AUTOPILOT_ARDUPILOTMEGA,
    MAV_AUTOPILOT_INVALID,
    MAV_CMD_REQUEST_MESSAGE,
    MAV_CMD_SET_MESSAGE_INTERVAL,
    MAV_PARAM_TYPE_REAL32,
    MAV_STATE_ACTIVE,
    MAV_TYPE_ONBOARD_CONTROLLER,
    MAV_TYPE_QUADROTOR,
)
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.settings import SimSettings

Values = dict[str, Any]
"""Fields of a message."""

BURST_STEP_S: Final = 0.02
"""Resolution of the times of what was stored, s."""
OUR_COMPONENT: Final = 193
LONGER_UP_S: Final = 37.0
"""The second vehicle was switched on so much earlier, s."""
STATION: Final = (255, 190)
TRUE_READING: Final[Values] = {"zacc": -1000, "xmag": 200, "zmag": -400}
WRONG_FIX: Final[Values] = {
    "fix_type": 3,
    "lat": -353_632_000,
    "lon": 1_491_652_000,
    "alt": 584_000,
    "satellites_visible": 12,
}

Maker = Callable[[float], bytes]
"""The frame that is sent at a time of the flight, s."""


def among(period_s: float, make_frame: Callable[[Tools], Maker]) -> MeddleMaker:
    """Another frame is delivered each period, beside those of the vehicle."""

    def make(tools: Tools) -> Meddle:
        frame_at = make_frame(tools)
        due_s = [0.0]

        def meddle(t_s: float, frames: list[bytes]) -> list[tuple[float, bytes]]:
            found = [(0.0, frame) for frame in frames]
            if t_s >= due_s[0]:
                due_s[0] = max(due_s[0] + period_s, t_s - period_s)
                found.append((0.0, frame_at(t_s)))
            return found

        return meddle

    return make


def heartbeat(system: int, component: int, vehicle_type: int, autopilot: int) -> Callable[[Tools], Maker]:
    """A heartbeat of this kind."""

    def make(tools: Tools) -> Maker:
        sender = tools.forger(system, component)
        return lambda _t_s: sender.heartbeat(vehicle_type, autopilot, 0, MAV_STATE_ACTIVE)

    return make


ONBOARD: Final = heartbeat(SYSTEM, 191, MAV_TYPE_ONBOARD_CONTROLLER, MAV_AUTOPILOT_INVALID)
SECOND_VEHICLE: Final = heartbeat(2, 1, MAV_TYPE_QUADROTOR, MAV_AUTOPILOT_ARDUPILOTMEGA)


def message(name: str, values_at: Callable[[Tools, float], Values], component: int = 1) -> Callable[[Tools], Maker]:
    """A message under the vehicle's ids, with values that depend on the time."""

    def make(tools: Tools) -> Maker:
        sender = tools.forger(SYSTEM, component)
        return lambda t_s: sender.message(name, values_at(tools, t_s))

    return make


def command(number: int, param1: float, param2: float) -> Callable[[Tools], Maker]:
    """A command of a ground station to us."""
    values = {"command": number, "target_system": SYSTEM, "target_component": OUR_COMPONENT}

    def make(tools: Tools) -> Maker:
        sender = tools.forger(*STATION)
        return lambda _t_s: sender.message("COMMAND_LONG", values | {"param1": param1, "param2": param2})

    return make


def interval(interval_us: float) -> Callable[[Tools], Maker]:
    """A station sets the interval of ATTITUDE_QUATERNION."""
    return command(MAV_CMD_SET_MESSAGE_INTERVAL, 31.0, interval_us)


REQUEST: Final = command(MAV_CMD_REQUEST_MESSAGE, 31.0, 0.0)


def true_attitude(tools: Tools, t_s: float) -> Values:
    """ATTITUDE as it should be."""
    roll, pitch, yaw = q_to_euler(tools.vehicle.truth(round(t_s * 1e9)).q_nb)
    return {"time_boot_ms": round(t_s * 1e3), "roll": roll, "pitch": pitch, "yaw": yaw}


def wrong_attitude(tools: Tools, t_s: float) -> Values:
    """The same, rolled by a radian."""
    values = true_attitude(tools, t_s)
    return values | {"roll": 1.0}


def inertial_reading(ahead_s: float) -> Callable[[Tools, float], Values]:
    """RAW_IMU of a vehicle that stands level, stamped ahead of the vehicle's clock."""
    return lambda _tools, t_s: TRUE_READING | {"time_usec": round((t_s + ahead_s) * 1e6)}


def extreme_reading(tools: Tools, t_s: float) -> Values:
    """RAW_IMU with readings at the ends of their range."""
    fields = ("xacc", "yacc", "zacc", "xgyro", "ygyro", "zgyro", "xmag", "ymag", "zmag")
    readings = {field: tools.rng.choice((-32768, 32767, 0)) for field in fields}
    return {**readings, "time_usec": round(t_s * 1e6) + 7000}


def wrong_fix(tools: Tools, t_s: float) -> Values:
    """A fix that flies at 200 m/s in a random direction."""
    return WRONG_FIX | {"time_usec": round(t_s * 1e6), "vel": 20_000, "cog": tools.rng.randrange(36_000)}


def parameter(name: bytes, value: Callable[[Tools], float]) -> Callable[[Tools, float], Values]:
    """PARAM_VALUE that nobody has asked for."""
    kind = MAV_PARAM_TYPE_REAL32
    return lambda tools, _t_s: {"param_id": name, "param_value": value(tools), "param_type": kind, "param_count": 900}


def second_vehicle(tools: Tools) -> Meddle:
    """Another vehicle with the same ids, in the hover."""
    other = FakeAutopilot(SimSettings(scenario="hover", fast_rate_hz=50.0), 7, tools.dialect)
    is_heard = False

    def meddle(t_s: float, frames: list[bytes]) -> list[tuple[float, bytes]]:
        nonlocal is_heard
        others = other.frames_until(round((t_s + LONGER_UP_S) * 1e9))
        found = [(0.0, frame) for frame in [*frames, *(others if is_heard else [])]]
        is_heard = True  # all that it sent before is no part of the disturbance
        return found

    return meddle


def burst(length_s: float, ahead_s: float, spread_s: float = 0.0) -> MeddleMaker:
    """All that a vehicle with the same ids has sent, from its start for so long, comes at once, or within a spread.

    ahead_s: its clock at the start of what comes, before that of the vehicle at that moment, s; negative for behind.
    """

    def make(tools: Tools) -> Meddle:
        other = FakeAutopilot(SimSettings(scenario="coordinated-turns", fast_rate_hz=50.0), 7, tools.dialect)
        steps = range(round(length_s / BURST_STEP_S))
        stored = [(step, one) for step in steps for one in other.frames_until(round(1e9 * BURST_STEP_S * step))]

        def meddle(t_s: float, frames: list[bytes]) -> list[tuple[float, bytes]]:
            found = [(0.0, frame) for frame in frames]
            shift_ms = round(1e3 * (t_s + ahead_s))
            for step, frame in stored:
                found.append((spread_s * step / len(steps), shifted(tools.dialect, frame, shift_ms)))
            stored.clear()
            return found

        return meddle

    return make


def lowering_rates(period_s: float, rate_hz: int) -> MeddleMaker:
    """A station that the vehicle hears sets all groups of messages to one rate."""

    def make(tools: Tools) -> Meddle:
        station = tools.forger(*STATION)
        due_s = [0.0]

        def meddle(t_s: float, frames: list[bytes]) -> list[tuple[float, bytes]]:
            if t_s >= due_s[0]:
                due_s[0] = t_s + period_s
                tools.vehicle.handle(station.request_data_stream(SYSTEM, 1, 0, rate_hz), round(t_s * 1e9))
            return [(0.0, frame) for frame in frames]

        return meddle

    return make


def with_field(scale: float, turn_mgauss: int) -> MeddleMaker:
    """The magnetometers read another field: scaled, and turned by a magnet along the nose."""

    def make(tools: Tools) -> Meddle:
        ids = tools.ids("RAW_IMU", "SCALED_IMU2")

        def magnetised(frame: bytes) -> bytes:
            if message_id(frame) not in ids:
                return frame
            layout = tools.dialect.by_id[message_id(frame)]
            x, y, z = layout.pick("xmag", "ymag", "zmag").unpack(frame[10:-2])
            field = {"xmag": round(scale * x) + turn_mgauss, "ymag": round(scale * y), "zmag": round(scale * z)}
            return edited(tools.dialect, frame, **field)

        return lambda _t_s, frames: [(0.0, magnetised(frame)) for frame in frames]

    return make


def denying(*names: str) -> MeddleMaker:
    """The vehicle denies every command, and these messages do not come."""

    def make(tools: Tools) -> Meddle:
        missing, ack = tools.ids(*names), tools.ids("COMMAND_ACK")

        def answered(frame: bytes) -> bytes:
            return edited(tools.dialect, frame, result=2) if message_id(frame) in ack else frame

        return lambda _t_s, frames: [(0.0, answered(one)) for one in frames if message_id(one) not in missing]

    return make


def spinning(_tools: Tools, t_s: float) -> Values:
    """ATTITUDE of a gimbal that turns."""
    return {"time_boot_ms": round(t_s * 1e3), "roll": radians(30.0), "pitch": 0.0, "yaw": (3.0 * t_s) % 3.0}
