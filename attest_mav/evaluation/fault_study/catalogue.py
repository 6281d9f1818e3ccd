"""The faults that are put into clean flights."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import radians
from typing import Final

from attest_mav.evaluation.fault_study import edits
from attest_mav.evaluation.fault_study.card import FaultGroup
from attest_mav.evaluation.fault_study.edits import Change
from attest_mav.types import Vec3

LanesOf = Callable[[Sequence[str]], Sequence[str]]


@dataclass(frozen=True)
class InjectedFault:
    """A fault, made by ``change`` from the names of the flight's inertial streams."""

    name: str
    change: Callable[[Sequence[str]], Change]
    group: FaultGroup = FaultGroup.SINGLE
    accused: str = ""
    """Fault of the first inertial stream, in words; "" where no inertial sensor alone is faulty."""
    duration_s: float = 15.0
    misleads: bool = False
    """The autopilot is misled by the first inertial stream; otherwise it is right throughout."""


def _gyro(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Vec3:
    """Degrees per second to rad/s."""
    return (radians(x), radians(y), radians(z))


def _of_one_sensor() -> list[InjectedFault]:
    """Faults of the first inertial stream."""
    return [
        InjectedFault("gyro x +2 deg/s", lambda n: edits.gyro_step(n[:1], _gyro(x=2.0)), accused="gyro x"),
        InjectedFault("gyro y -5 deg/s", lambda n: edits.gyro_step(n[:1], _gyro(y=-5.0)), accused="gyro y"),
        InjectedFault("gyro z +3 deg/s", lambda n: edits.gyro_step(n[:1], _gyro(z=3.0)), accused="gyro z"),
        InjectedFault("gyro reads zero", lambda n: edits.gyro_scale(n[:1], 0.0), accused="gyro"),
        InjectedFault("gyro x 1.5", lambda n: edits.gyro_scale(n[:1], 1.5), accused="gyro"),
        InjectedFault("accel y -1.5", lambda n: edits.accel_step(n[:1], (0.0, -1.5, 0.0)), accused="accelerometer y"),
        InjectedFault("accel z +2", lambda n: edits.accel_step(n[:1], (0.0, 0.0, 2.0)), accused="accelerometer z"),
        InjectedFault("accel x 0.5", lambda n: edits.accel_scale(n[:1], 0.5)),
        InjectedFault("accel stuck", lambda n: edits.accel_stuck(n[:1]), accused="accelerometer"),
        InjectedFault("all frozen", lambda n: edits.frozen(n[:1])),
    ]


def _of_the_receiver() -> list[InjectedFault]:
    """Faults of the receiver, and of all magnetometers."""
    return [
        InjectedFault("receiver off", lambda _: edits.receiver_off(), duration_s=50.0),
        InjectedFault("receiver +5 m/s", lambda _: edits.receiver_offset((5.0, 0.0, 0.0))),
        InjectedFault("receiver ramp", lambda _: edits.receiver_ramp((0.0, 0.5, 0.0))),
        InjectedFault("receiver late 0.4", lambda _: edits.receiver_late(0.4)),
        InjectedFault("receiver frozen", lambda _: edits.receiver_frozen()),
        InjectedFault("receiver noise", lambda _: edits.receiver_noise(1.5)),
        InjectedFault("compass 150 mG", lambda _: edits.compass_offset((0.15, 0.0, 0.0))),
    ]


def _of_all_sensors() -> list[InjectedFault]:
    """Faults that all inertial sensors share."""
    both = FaultGroup.BOTH_SENSORS
    return [
        InjectedFault("both gyros x +3", lambda n: edits.gyro_step(n, _gyro(x=3.0)), both),
        InjectedFault("both gyros y +4", lambda n: edits.gyro_step(n, _gyro(y=4.0)), both),
        InjectedFault("both gyros z +3", lambda n: edits.gyro_step(n, _gyro(z=3.0)), FaultGroup.BOTH_VERTICAL),
        InjectedFault("both accels x +1", lambda n: edits.accel_step(n, (1.0, 0.0, 0.0)), both),
    ]


def _misleading(fault: InjectedFault) -> InjectedFault:
    return InjectedFault(
        f"{fault.name}, misled", fault.change, fault.group, fault.accused, fault.duration_s, misleads=True
    )


def _all_faults() -> tuple[InjectedFault, ...]:
    one, shared = _of_one_sensor(), _of_all_sensors()
    misled = [_misleading(fault) for fault in (*one, *shared)]
    return (*one, *_of_the_receiver(), *shared, *misled)


INJECTED: Final = _all_faults()
"""All of them, in the order of the table."""
