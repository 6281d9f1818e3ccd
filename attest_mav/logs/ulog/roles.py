"""The uses of PX4's topics in a recorded flight. Further instances of a topic have their number in the name."""

from typing import Final

from attest_mav.logs.source import MessageRoles

INSTANCES: Final = 4
"""So many instances of a topic are told apart."""


def stream_of(topic: str, instance: int) -> str:
    """The name of one instance of a topic."""
    return topic if instance == 0 else f"{topic}_{instance}"


IMU: Final = tuple(stream_of("vehicle_imu", number) for number in range(INSTANCES))
ESTIMATORS: Final = tuple(stream_of("estimator_attitude", number) for number in range(INSTANCES))
RECEIVERS: Final = ("vehicle_gps_position", *(stream_of("sensor_gps", number) for number in range(INSTANCES)))
TRUTH: Final = "vehicle_attitude_groundtruth"
OWN: Final = "vehicle_attitude"

ULOG_ROLES: Final = MessageRoles(
    inertial=("sensor_combined", *IMU),
    truth=(TRUTH,),
    reference=(TRUTH, OWN),
    named_reference=(TRUTH, OWN, *ESTIMATORS),
    autopilot=(OWN,),
    untimed=(),
    other_sensors={name: tuple([other for other in IMU if other != name]) for name in IMU},
)
"""A simulator's truth precedes the autopilot's attitude. sensor_combined is the sensor that the estimator has selected,
at its full rate; vehicle_imu is each sensor, in most logs a few times a second. sensor_combined is used alone, because
it does not tell which of the sensors it is."""
