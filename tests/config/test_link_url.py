import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attest_mav.config.link_url import Scheme, parse_link
from attest_mav.errors import UsageError


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("serial:/dev/ttyAMA0:921600", "serial:/dev/ttyAMA0:921600"),
        ("serial:/dev/ttyAMA0", "serial:/dev/ttyAMA0:115200"),
        ("serial:/dev/ttyAMA0,57600", "serial:/dev/ttyAMA0:57600"),
        ("/dev/ttyACM0", "serial:/dev/ttyACM0:115200"),
        ("/dev/ttyACM0,57600", "serial:/dev/ttyACM0:57600"),
        ("/dev/ttyACM0:57600", "serial:/dev/ttyACM0:57600"),
        (
            "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0:57600",
            "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0:57600",
        ),
        ("serial:/dev/serial/by-path/pci-0:14.0-port0", "serial:/dev/serial/by-path/pci-0:14.0-port0:115200"),
        ("udp:0.0.0.0:14550", "udpin:0.0.0.0:14550"),
        ("udpin:0.0.0.0:14550", "udpin:0.0.0.0:14550"),
        ("udpin://127.0.0.1:14550", "udpin:127.0.0.1:14550"),
        ("udpin::14550", "udpin:127.0.0.1:14550"),
        ("udpin:14550", "udpin:127.0.0.1:14550"),
        ("tcpin:5760", "tcpin:127.0.0.1:5760"),
        ("udpin:127.0.0.1:0", "udpin:127.0.0.1:0"),
        ("udpin:[::1]:14550", "udpin:[::1]:14550"),
        ("udpout:gcs.local:14550", "udpout:gcs.local:14550"),
        ("TCP:10.0.0.2:5760", "tcp:10.0.0.2:5760"),
        ("sim:", "sim:"),
        ("sim:square", "sim:square"),
        ("sim:?receiver-off@30+60", "sim:?receiver-off@30+60"),
        ("sim:square?gyro1-bias-x=5@20,reboot@9", "sim:square?gyro1-bias-x=5@20,reboot@9"),
        ("sim:square?", "sim:square"),
    ],
)
def test_what_is_understood(text, plain):
    assert str(parse_link(text)) == plain
    assert parse_link(plain) == parse_link(text), "the plain form means the same"


def test_a_simulation_has_a_scenario_and_faults():
    url = parse_link("sim:square?gyro1-bias-x=5@20,reboot@9")
    assert (url.scenario, url.faults) == ("square", ("gyro1-bias-x=5@20", "reboot@9"))
    assert parse_link("sim:square").faults == ()


@pytest.mark.parametrize("text", ["udpin:14550", "udp::14550", "tcpin::1"])
def test_listeners_bind_loopback_unless_an_address_is_given(text):
    assert parse_link(text).host == "127.0.0.1"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "expected serial:"),
        ("udpx:1.2.3.4:1", "expected serial:"),
        ("127.0.0.1:14550", "expected serial:"),
        ("udpin", "expected serial:"),
        ("udpin:127.0.0.1:65536", "port of 0 to 65535"),
        ("udpin:127.0.0.1:-1", "port of 0 to 65535"),
        ("udpin:127.0.0.1:x", "port of 0 to 65535"),
        ("udpout:127.0.0.1:0", "port of 1 to 65535"),
        ("udpout:14550", "no host"),
        ("tcp:127.0.0.1", "port of 1 to 65535"),
        ("serial:", "no device"),
        ("/dev/ttyACM0,x", "baud rate 'x': expected a number, such as 115200"),
        ("serial:/dev/ttyACM0,", "baud rate '': expected a number"),
        ("/dev/ttyACM0,57600:x", "baud rate '57600:x': expected a number"),
        ("serial:/dev/ttyAMA0:0", "baud rate 0"),
        ("/dev/ttyACM0,99999999999999", "baud rate"),
        ("udpin:127.0.0.1:14550\n", "printable"),
        ("x" * 10_000, "at most 512"),
    ],
)
def test_what_is_not_understood_is_one_clear_line(text, said):
    with pytest.raises(UsageError, match=said) as caught:
        parse_link(text)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 700


@settings(derandomize=True, max_examples=300)
@given(st.text(max_size=80) | st.from_regex(r"(serial|udp|udpin|udpout|tcp|tcpin|sim|/dev/)[:,/0-9a-z\[\].-]{0,30}"))
def test_any_text_parses_or_is_a_usage_error(text):
    try:
        url = parse_link(text)
    except UsageError:
        return
    assert parse_link(str(url)) == url
    assert 0 <= url.port <= 65535
    assert url.scheme in Scheme
