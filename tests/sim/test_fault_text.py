from math import inf, radians

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attest_mav.errors import UsageError
from attest_mav.sim.fault_text import parse_fault, parse_faults, spelling
from attest_mav.sim.faults import KINDS


@pytest.mark.parametrize(
    ("text", "name", "span_s", "size", "sensors", "axes"),
    [
        ("gyro1-bias-x=5@20+15", "gyro-bias", (20.0, 35.0), radians(5.0), (0,), (0,)),
        ("gyro-bias-z=-3@20", "gyro-bias", (20.0, inf), radians(-3.0), (0, 1), (2,)),
        ("gyro2-scale=10@1+2", "gyro-scale", (1.0, 3.0), 0.1, (1,), (0, 1, 2)),
        ("accel2-stuck=5@10+12", "accel-stuck", (10.0, 22.0), 5.0, (1,), (0, 1, 2)),
        ("accel-bias-y=0.5@1e1+0.5", "accel-bias", (10.0, 10.5), 0.5, (0, 1), (1,)),
        ("imu2-freeze@0", "imu-freeze", (0.0, inf), 0.0, (1,), ()),
        ("compass=100@7", "compass", (7.0, inf), 0.1, (0, 1), (0, 1, 2)),
        ("compass1-x=-300@7", "compass", (7.0, inf), -0.3, (0,), (0,)),
        ("receiver-off@30+60", "receiver-off", (30.0, 90.0), 0.0, (0, 1), ()),
        ("receiver-offset-east=1@3", "receiver-offset", (3.0, inf), 1.0, (0, 1), (1,)),
        ("receiver-late=0.5@3", "receiver-late", (3.0, inf), 0.5, (0, 1), ()),
        ("trim-y=5@3", "trim", (3.0, inf), radians(5.0), (0, 1), (1,)),
        ("attitude-offset-down=40@3", "attitude-offset", (3.0, inf), radians(40.0), (0, 1), (2,)),
    ],
)
def test_what_is_understood(text, name, span_s, size, sensors, axes):
    fault = parse_fault(text)
    assert fault.kind.name == name
    assert (fault.start_s, fault.end_s) == pytest.approx(span_s)
    assert fault.size == pytest.approx(size)
    assert (fault.sensors, fault.axes) == (sensors, axes)


def test_a_size_is_on_its_axes_alone():
    assert parse_fault("accel-bias-y=2@0").vector == (0.0, 2.0, 0.0)
    assert parse_fault("receiver-offset=2@0").vector == (2.0, 2.0, 0.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "fault '': expected NAME[=SIZE]@START[+DURATION], for example gyro1-bias-x=5@20+15"),
        ("receiver-off", "expected NAME[=SIZE]@START"),
        ("@5", "expected NAME[=SIZE]@START"),
        ("reboot@1@2", "START '1@2': expected a number"),
        ("gyro-bais=5@20", "unknown fault 'gyro-bais'; did you mean gyro-bias?"),
        ("gyro1-bais-x=5@20", "did you mean gyro-bias?"),
        ("reciever-off@20", "did you mean receiver-off?"),
        ("GYRO-BIAS=5@20", "unknown fault 'GYRO-BIAS'; expected one of gyro-bias, gyro-scale, "),
        ("qqqq@20", "expected one of gyro-bias, "),
        ("gyro3-bias=5@20", "there is no sensor 3: expected 1 or 2, or no number for both"),
        ("gyro0-bias=5@20", "there is no sensor 0"),
        ("gyro01-bias=5@20", "there is no sensor 01"),
        ("receiver1-off@20", "receiver-off takes no number"),
        ("gyro-bias-w=5@20", "gyro-bias has no axis w: expected x, y, z, or none for all"),
        ("receiver-offset-down=5@20", "receiver-offset has no axis down: expected north, east, or none for all"),
        ("receiver-off-x@20", "receiver-off has no axis x"),
        ("gyro-bias@20", "gyro-bias needs a size in deg/s: gyro-bias=SIZE@START"),
        ("receiver-off=3@20", "receiver-off takes no size"),
        ("gyro-bias=@20", "gyro-bias in deg/s '': expected a number"),
        ("gyro-bias=x@20", "gyro-bias in deg/s 'x': expected a number"),
        ("gyro-bias=501@20", "gyro-bias in deg/s 501 is out of range: expected -500 to 500"),
        ("gyro-bias=nan@20", "gyro-bias in deg/s nan is out of range"),
        ("receiver-noise=0@20", "receiver-noise in m/s 0 is out of range: expected 0.01 to 100"),
        ("receiver-off@", "START '': expected a number"),
        ("receiver-off@-1", "START -1 is out of range: expected 0 to 1e+06"),
        ("receiver-off@inf", "START inf is out of range"),
        ("receiver-off@1+", "DURATION '': expected a number"),
        ("receiver-off@1+0", "DURATION 0: expected more than 0 s, or none for ever"),
        ("receiver-off@1+-2", "DURATION -2 is out of range"),
        ("reboot@1+2", "reboot has no duration"),
    ],
)
def test_what_cannot_be_meant_is_one_clear_error(text, said):
    with pytest.raises(UsageError) as caught:
        parse_faults(["receiver-off@1", text])
    assert said in str(caught.value)
    assert str(caught.value).startswith(f"fault {text!r}: ")


@given(st.text(max_size=40) | st.from_regex(r"(gyro|imu|receiver)[12]?-[a-z]{3,6}(-[xyz])?=?[0-9]*@[0-9+.e-]{0,9}"))
@settings(derandomize=True, max_examples=300, deadline=None)
def test_any_text_is_a_fault_or_a_usage_error(text):
    try:
        fault = parse_fault(text)
    except UsageError:
        return
    assert 0.0 <= fault.start_s < fault.end_s


def test_names_are_told_apart():
    names = [kind.name for kind in KINDS]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("gyro-bias", "gyro[N]-bias[-A]=DEG/S"),
        ("imu-silent", "imu[N]-silent"),
        ("compass", "compass[N][-A]=MG"),
        ("receiver-late", "receiver-late=S"),
        ("reboot", "reboot"),
    ],
)
def test_a_spelling_shows_what_may_be_chosen(name, text):
    (kind,) = (kind for kind in KINDS if kind.name == name)
    assert spelling(kind) == text
