"""Records pickle and copy: samples, innovations, filters, and states in the middle of a run."""

import copy
import pickle
from importlib import import_module
from inspect import signature
from pkgutil import walk_packages

import pytest

import attest_mav
from attest_mav import (
    BARE_SENSOR,
    Aid,
    AttitudeFilter,
    FilterState,
    FlightParameters,
    Fusion,
    GradientDescent,
    ImuSample,
    Innovation,
    Leveling,
    LiveAttitude,
    RobustAdaptive,
    VelocityAided,
    VelocitySample,
    run,
)
from attest_mav.estimate import Estimate
from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.gradient_descent.filter import FixedField
from attest_mav.record import Record
from attest_mav.types import North, VelocityOrigin

LEVEL, RATES, FORCE, FIELD = (1.0, 0.0, 0.0, 0.0), (0.01, -0.02, 0.03), (0.1, -0.2, -9.8), (0.2, 0.01, 0.43)
IMU = ImuSample("RAW_IMU", 1, 1, 20_000_000, 5, RATES, FORCE, FIELD, saturated=True)
FIX = VelocitySample("GPS_RAW_INT", 1, 1, 0, 0, (1.0, 2.0, 0.0), False, VelocityOrigin.RECEIVER, 0.3)
FILTERS = (
    GradientDescent(beta=0.05, field=FixedField(0.4, 0.9)),
    GradientDescent(rest_bias=True, accel_time_s=2.0, heading_rate=0.01, field_gate=True),
    RobustAdaptive(),
    Leveling(),
    VelocityAided(),
)


def fields_of(record):
    """The record as plain values, all the way down."""
    if not isinstance(record, Record):
        return record
    return [fields_of(getattr(record, name)) for name in signature(type(record)).parameters]


@pytest.mark.parametrize(
    "record",
    [
        IMU,
        FIX,
        Innovation(Aid.VELOCITY, Fusion.INFLATED, 7, (1.0,), (0.5,), (0.25,)),
        Estimate("RAW_IMU", "leveling", 1, 2, LEVEL, RATES, North.TRUE, 0.1, 0.2, 0.02),
    ],
    ids=lambda record: type(record).__name__,
)
def test_a_record_comes_back_with_all_fields(record):
    for other in (pickle.loads(pickle.dumps(record)), copy.deepcopy(record)):  # noqa: S301 - our own bytes
        assert type(other) is type(record)
        assert fields_of(other) == fields_of(record)


@pytest.mark.parametrize("one", [*FILTERS, BARE_SENSOR, FlightParameters(low_pass_hz=5.0)], ids=repr)
def test_a_filter_comes_back_equal(one):
    assert pickle.loads(pickle.dumps(one)) == one  # noqa: S301 - our own bytes


@pytest.mark.parametrize("one", FILTERS, ids=lambda one: one.name)
@pytest.mark.parametrize("steps", [3, 400])
def test_a_run_goes_on_from_a_pickled_state(one, steps):
    """In the alignment of the flight filter, and long after."""
    state = one.initial(Start(LEVEL, (0.0, 0.0, 0.0), North.MAGNETIC, FORCE, FIELD))
    for k in range(steps):
        state = step(one, state, k)
    other = pickle.loads(pickle.dumps(state))  # noqa: S301 - our own bytes
    for k in range(steps, steps + 100):
        state, other = step(one, state, k), step(one, other, k)
    assert other.q_nb == state.q_nb
    assert other.gyro_bias == state.gyro_bias
    assert str(other.tilt_sigma) == str(state.tilt_sigma)


def step(one, state, k):
    t_ns = 20_000_000 * (k + 1)
    sample = ImuSample("RAW_IMU", 1, 1, t_ns, t_ns, RATES, FORCE, FIELD)
    at = t_ns - t_ns % 200_000_000
    fix = VelocitySample("GPS_RAW_INT", 1, 1, at, at, (1.0 + 0.1 * k, 2.0, 0.0), False, VelocityOrigin.RECEIVER)
    return one.step(state, 0.02, sample, FilterInputs(velocity=fix, declination=0.1))


def test_every_record_has_a_field_for_each_argument():
    kinds = [kind for kind in records() if kind not in {Record, AttitudeFilter}]
    assert len(kinds) > 60
    fields = {kind: {name for one in kind.__mro__ for name in declared(one)} for kind in kinds}
    missing = [
        (kind.__name__, name)
        for kind in kinds
        for name in signature(kind).parameters
        if name not in fields[kind] and not set_by_constructor(kind, name)
    ]
    assert missing == []


def declared(kind):
    return {*vars(kind), *getattr(kind, "__dataclass_fields__", {})}


def set_by_constructor(kind, name):
    """Whether the constructor, or one that it calls, sets the field; interpreted classes have no other trace of it."""
    codes = [one.__init__.__code__ for one in kind.__mro__ if hasattr(one.__init__, "__code__")]
    return any(name in code.co_names for code in codes)


def records():
    for module in walk_packages(attest_mav.__path__, "attest_mav."):
        if not module.name.endswith("__main__"):
            for kind in vars(import_module(module.name)).values():
                if isinstance(kind, type) and issubclass(kind, Record) and kind.__module__ == module.name:
                    yield kind


@pytest.mark.parametrize(
    "one", [ImuSample, ImuSample.with_readings, VelocityAided, VelocityAided.step, run, LiveAttitude]
)
def test_help_tells_what_a_name_is_and_takes(one):
    assert len(one.__doc__) > 20
    assert len(signature(one).parameters) >= 1


def test_fields_and_modules_are_documented():
    assert import_module("attest_mav.samples").__doc__.startswith("The records of inertial sensors")
    assert FilterState.aligned.__doc__.startswith("False while a filter")
    assert list(signature(ImuSample).parameters)[-2:] == ["saturated", "quantum"]
