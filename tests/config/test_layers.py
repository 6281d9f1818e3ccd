"""Layers over each other, and what a valid configuration probably does not mean."""

import pytest

from attest_mav.config.layers import command_line_layer, environment_layers, file_layer, layered
from attest_mav.config.parsing import parse_config
from attest_mav.config.remarks import remarks
from attest_mav.errors import ConfigError

BAUD = "a baud rate is a whole number, such as 921600"
FILE = "[output]\nrate_hz = 5\nmax_sigma_deg = 2\n[[link]]\nurl = 'udpin::1'\nwait = false\n[[link]]\nurl = 'sim:'\n"


def test_later_layers_win_key_by_key_and_each_value_has_its_origin():
    found = layered(
        [
            file_layer(FILE, "a.toml"),
            file_layer("[output]\nrate_hz = 6\n[log]\nstatus_s = 2\n", "b.toml"),
            *environment_layers(
                {"ATTEST_MAV__OUTPUT__RATE_HZ": "7", "ATTEST_MAV__FILTER__VELOCITY_AIDED__MAG_DELAY_S": "0.1", "X": "1"}
            ),
            command_line_layer(["log.level=debug"]),
        ]
    )
    config = found.config
    assert (config.output.rate_hz, config.output.max_sigma_deg) == (7.0, 2.0)
    assert (config.log.status_s, config.log.level, config.filter.velocity_aided.mag_delay_s) == (2.0, "debug", 0.1)
    assert found.origins == {
        "output.rate_hz": "ATTEST_MAV__OUTPUT__RATE_HZ",
        "output.max_sigma_deg": "a.toml",
        "link[0].url": "a.toml",
        "link[0].wait": "a.toml",
        "link[1].url": "a.toml",
        "filter.velocity-aided.mag_delay_s": "ATTEST_MAV__FILTER__VELOCITY_AIDED__MAG_DELAY_S",
        "log.status_s": "b.toml",
        "log.level": "--set",
    }


def test_links_are_replaced_as_a_whole():
    found = layered([file_layer(FILE, "a"), *environment_layers({"ATTEST_MAV__LINK": "[{url = 'udpin::2'}]"})])
    assert [link.url for link in found.config.link] == ["udpin::2"]
    assert {name: origin for name, origin in found.origins.items() if "link" in name} == {
        "link[0].url": "ATTEST_MAV__LINK"
    }


@pytest.mark.parametrize(
    ("layers", "said"),
    [
        ([file_layer(FILE, "a"), file_layer("[output]\nrate = 1", "b")], r"^b: unknown key output\.rate"),
        ([file_layer("[output]\nrate_hz = 0", "a"), file_layer("", "b")], r"^a: output\.rate_hz: expected"),
        (environment_layers({"ATTEST_MAV__OUTPUT__RATEHZ": "1"}), "^ATTEST_MAV__OUTPUT__RATEHZ: unknown key"),
        (environment_layers({"ATTEST_MAV__OUTPUT": "1"}), "^ATTEST_MAV__OUTPUT: output: expected"),
        ([file_layer("[raw_imu]\ngyro_radps = 0.1", "a"), file_layer("", "b")], "^a and b: raw_imu: "),
    ],
)
def test_an_error_names_the_layer_that_makes_it(layers, said):
    with pytest.raises(ConfigError, match=said):
        layered(layers)


def test_what_is_no_toml_is_named_with_its_place():
    with pytest.raises(ConfigError, match=r"^x: not valid TOML: .*at line 1, column 5"):
        file_layer("a = ?\n", "x")


@pytest.mark.parametrize(
    ("urls", "said"),
    [
        (
            ("serial:/dev/ttyS0", "udpin::1", "serial:/dev/ttyS0:57600"),
            r"link\[2\]\.url: /dev/ttyS0 belongs to link\[0\]",
        ),
        (("udpin::5", "udpin:0.0.0.0:5"), r"link\[1\]\.url: port 5 belongs to link\[0\]"),
        (("tcpin:[::1]:5", "tcpin:[::1]:5"), "port 5"),
    ],
)
def test_two_links_on_one_device_or_port_are_an_error(urls, said):
    with pytest.raises(ConfigError, match=said):
        parse_config("".join(f"[[link]]\nurl = '{url}'\n" for url in urls), "x")


@pytest.mark.parametrize(
    "urls",
    [("udpin::0", "udpin::0"), ("udpin::5", "tcpin::5"), ("udpin:127.0.0.1:5", "udpin:127.0.0.2:5"), ("sim:",) * 2],
)
def test_links_that_can_be_together_are_none(urls):
    assert len(parse_config("".join(f"[[link]]\nurl = '{url}'\n" for url in urls), "x").link) == 2


@pytest.mark.parametrize("value", ["1e-308", "5e-324", "1e300"])
def test_a_number_that_nobody_can_mean_is_an_error(value):
    with pytest.raises(ConfigError, match=r"filter\.robust-adaptive\.c: expected 0, or a size from 1e-15 to 1e\+15"):
        parse_config(f"[filter.robust-adaptive]\nc = {value}\n", "x")


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("serial:/dev/ttyS0:912600", ["link[0].url: baud rate 912600 is unusual; is 921600 meant?"]),
        (
            "serial:/dev/ttyS0:57k",
            ["link[0].url: '57k' is taken for a part of the device's name; " + BAUD],
        ),
        ("serial:/dev/serial/by-path/usb-0:1.2:1.0", []),
        ("serial:/dev/ttyS0:921600", []),
    ],
)
def test_an_unusual_baud_rate_is_remarked(url, said):
    assert list(remarks(parse_config(f"[[link]]\nurl = '{url}'\n", "x"), [])) == said


@pytest.mark.parametrize(
    ("url", "listen", "clashes"),
    [
        ("tcpin:127.0.0.1:5760", "127.0.0.1:5760", True),
        ("tcpin:0.0.0.0:5760", "127.0.0.1:5760", True),
        ("tcpin::5760", "0.0.0.0:5760", True),
        ("tcpin::5760", "127.0.0.1:5761", False),
        ("tcpin::0", "127.0.0.1:0", False),
        ("udpin::5760", "127.0.0.1:5760", False),
        ("tcp:127.0.0.1:5760", "127.0.0.1:5760", False),
    ],
)
def test_a_page_on_the_port_of_a_link_is_remarked(url, listen, clashes):
    config = parse_config(f"[[link]]\nurl = 'sim:'\n[[link]]\nurl = '{url}'\n[web]\nlisten = '{listen}'\n", "x")
    said = "web.listen: port 5760 belongs to link[1]: there would be no page; choose another port"
    assert list(remarks(config, [])) == ([said] if clashes else [])


def test_parameters_of_a_filter_that_does_not_run_are_remarked():
    text = "[filter]\nname = 'leveling'\n[filter.leveling]\ngravity = 9.8\n[filter.gradient-descent]\nbeta = 0.1\n"
    found = layered([file_layer(text, "x")])
    assert list(remarks(found.config, found.origins)) == [
        "filter.gradient-descent.beta: has no effect: the filter is leveling"
    ]
