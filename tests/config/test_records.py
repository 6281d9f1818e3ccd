import dataclasses
import tomllib
from math import nan
from pathlib import Path
from typing import get_args

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attest_mav.config.filters import FilterConfig
from attest_mav.config.parsing import parse_config
from attest_mav.config.records import Config, LinkConfig, SpeedSource, VelocitySource
from attest_mav.config.text import to_toml
from attest_mav.errors import ConfigError
from attest_mav.estimation.vehicle import SPEED_SOURCES
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.registry import default_filter, filter_names
from attest_mav.mavlink.component.vehicle_data import POSITION_MESSAGES
from attest_mav.vehicle_settings import VehicleSettings

CONFIGS = Path(__file__).parents[2] / "configs"


def test_the_commented_file_has_every_key_with_its_default():
    table = tomllib.loads((CONFIGS / "attest-mav.toml").read_text())
    link = LinkConfig(url=table["link"][0]["url"])
    defaults = tomllib.loads(to_toml(msgspec.structs.replace(Config(), link=(link,))))
    assert table == defaults


def test_every_key_of_the_commented_file_has_a_comment():
    lines = (CONFIGS / "attest-mav.toml").read_text().splitlines()
    for number, line in enumerate(lines):
        if line and not line.startswith(("#", "[")):
            block = next(row for row in reversed(lines[:number]) if "=" not in row or row.startswith("#"))
            assert block.startswith("#"), f"{line!r} has no comment above it"


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("*.toml")), ids=lambda path: path.name)
def test_the_shipped_files_are_valid_and_shown_configurations_read_back(path):
    config = parse_config(path.read_text(), path.name)
    assert config.link
    assert parse_config(to_toml(config), "shown") == config


def test_nothing_is_needed():
    assert parse_config("", "empty") == Config()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[outputt]", "unknown key outputt; did you mean output?"),
        ("[output]\nratehz = 5", "unknown key output.ratehz; did you mean rate_hz?"),
        ("[output]\nx = 5", "unknown key output.x; expected one of system_id, component_id, rate_hz"),
        ("[[link]]\nurl = 'sim:'\npublsh = []", "unknown key link[0].publsh; did you mean publish?"),
        ("[filter.gradient-descent]\nbta = 1", "unknown key filter.gradient-descent.bta; did you mean beta?"),
        ("[filter.gradient_descent]", "unknown key filter.gradient_descent; did you mean gradient-descent?"),
        ("[output]\ncomponent_id = 300", "output.component_id: expected int <= 255, got 300"),
        ("[output]\ncomponent_id = 0", "output.component_id: expected int >= 1, got 0"),
        ("[vehicle]\nsystem_id = '1'", "vehicle.system_id: expected int, got str"),
        ("[vehicle]\nsystem_id = true", "vehicle.system_id: expected int, got bool"),
        ("[output]\nrate_hz = 0", "output.rate_hz: expected float >= 0.01, got 0"),
        (
            "[streams]\nfurther_imu_messages = 'all'",
            "further_imu_messages: expected auto, or a list of RAW_IMU or SCALED_IMU",
        ),
        (
            "[streams]\nfurther_imu_messages = ['X']",
            "streams.further_imu_messages[0]: expected RAW_IMU or SCALED_IMU or",
        ),
        ("[streams]\nimu_bytes_per_s = -5", "streams.imu_bytes_per_s: expected float >= 0.0, got -5"),
        ("[output]\nrate_hz = 5e-324", "output.rate_hz: expected float >= 0.01, got 5e-324"),
        ("[streams]\nimu_hz = 1e-320", "streams.imu_hz: expected float >= 0.01, got 1e-320"),
        ("[output]\ncomponent_id = 1", "output.component_id: 1 belongs to the autopilot"),
        ("[output]\ncomponent_id = 190", "output.component_id: 190 belongs to ground stations"),
        ("[output]\nsystem_id = 255", "output.system_id: 255 belongs to ground stations"),
        (f"x = {'[' * 5000}{']' * 5000}", "nested too deeply"),
        (f"x = {'{a = ' * 5000}1{'}' * 5000}", "nested too deeply"),
        ("[output]\nrate_hz = nan", "output.rate_hz: expected a number, got nan"),
        ("[output]\nrate_hz = inf", "output.rate_hz: expected float <= 1000.0, got inf"),
        ("[estimate]\ndeclination_deg = 'x'", "expected auto or a number from -180 to 180, got 'x'"),
        ("[estimate]\ndeclination_deg = 181", "expected auto or a number from -180 to 180, got 181"),
        ("[filter]\nname = 'kalman'", "filter.name: expected auto or gradient-descent or "),
        ("[verdict]\ntilt_deg = 'x'", "verdict.tilt_deg: expected auto or a number above 0, up to 90, got 'x'"),
        ("[verdict]\ntilt_deg = 0", "verdict.tilt_deg: expected auto or a number above 0, up to 90, got 0"),
        ("[[link]]\nurl = 'foo'", "link[0].url: link 'foo': expected serial:"),
        ("[[link]]", "link[0]: the key url is missing"),
        ("[[link]]\nurl = 'sim:'\npublish = ['x']", "link[0].publish[0]: expected attitude_quaternion or "),
        ("[[link]]\nurl = 'sim:'\n[[link]]\nurl = 5", "link[1].url: expected str, got int"),
        (
            "[[link]]\nurl = 'sim:'\nsigning = 'require'",
            'link[0].key_file: signing = "require" needs a key; name the file that holds it',
        ),
        ("[[link]]\nurl = 'sim:'\nsigning = 'yes'", "link[0].signing: expected off or sign or require, got 'yes'"),
        ("[[link]]\nurl = 'sim:'\nparameters = 1", "link[0].parameters: expected bool, got int"),
        ("[web]\nlisten = 3", 'expected str, got int; for example listen = "127.0.0.1:8484"'),
        ("[record]\nfolder = true", 'got bool; for example folder = "/var/log/attest-mav"'),
        ("[[link]]\nurl = 5", 'link[0].url: expected str, got int; for example url = "udpin:0.0.0.0:14550"'),
        ("[web]\nhosts = 'x'", 'web.hosts: expected array, got str; for example hosts = ["drone.local"]'),
        ("[estimate]\nstale_s = 'x'", "estimate.stale_s: expected float, got str; for example stale_s = 0.5"),
        ("[filter.gradient-descent]\nbeta = 'x'", "beta: expected float, got str; for example beta = "),
        ("link = 3", "link: expected array, got int"),
        ("output = 3", "output: expected object, got int"),
        ("output", "not valid TOML"),
        ("[output]\n[output]", "not valid TOML"),
    ],
)
def test_every_error_names_the_file_and_the_key(text, said):
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "my.toml")
    assert str(caught.value).startswith("my.toml: ")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 78


@settings(derandomize=True, max_examples=200)
@given(st.text(max_size=200))
def test_any_text_is_a_configuration_or_an_error(text):
    try:
        parse_config(text, "any")
    except ConfigError:
        return


def outcome(text):
    """What is wrong with the text, empty when nothing is."""
    try:
        parse_config(text, "f")
    except ConfigError as error:
        return str(error)
    return ""


VALUES = (
    "0",
    "-1",
    "1e9",
    "true",
    "'x'",
    "''",
    "[]",
    "['x']",
    "[[1]]",
    "{}",
    "{a = 1}",
    "[{}]",
    "1979-05-27",
    "nan",
    "-inf",
)


@pytest.mark.parametrize("value", VALUES)
def test_any_value_under_any_key_is_taken_or_an_error_that_names_it(value):
    whole = msgspec.to_builtins(msgspec.structs.replace(Config(), link=(LinkConfig(url="sim:"),)))
    for table, keys in whole.items():
        for key in [*keys] if isinstance(keys, dict) else ["url", "publish", "wait"]:
            header = f"[{table}]" if isinstance(keys, dict) else f"[[{table}]]"
            if table == "link" and key != "url":
                header += "\nurl = 'sim:'"
            said = outcome(f"{header}\n{key} = {value}")
            assert said == "" or (key in said and "\n" not in said)


@pytest.mark.parametrize("name", filter_names())
def test_every_filter_can_be_named_and_has_its_own_defaults(name):
    built = parse_config(f"[filter]\nname = '{name}'", "x").filter.build()
    assert built.name == name
    assert built == default_filter(name)


@pytest.mark.parametrize("name", ["gradient-descent", "robust-adaptive", "leveling"])
def test_every_parameter_reaches_its_filter(name):
    """Each number or flag is changed a little, alone, and the filter must show it."""
    default = default_filter(name)
    for key in default.__dataclass_fields__:
        value = getattr(default, key)
        if key == "field":
            continue
        changed = not value if isinstance(value, bool) else value * 0.999 + (0.001 if key == "max_accel_g" else 0.0)
        if value == 0.0 and not isinstance(value, bool):
            changed = 0.5
        text = str(changed).lower()
        built = parse_config(f"[filter]\nname = '{name}'\n[filter.{name}]\n{key} = {text}", "x").filter.build()
        assert getattr(built, key) == pytest.approx(changed, rel=1e-12)
        assert built != default


def test_infinity_is_a_value_where_it_means_something():
    config = parse_config("[filter]\nname = 'leveling'\n[filter.leveling]\nr_sideslip = inf", "x")
    assert parse_config(to_toml(config), "shown") == config


def test_a_fixed_field_is_given_by_its_dip():
    text = "[filter]\nname = 'gradient-descent'\n[filter.gradient-descent]\nreference_dip_deg = 60"
    built = parse_config(text, "x").filter.build()
    assert isinstance(built, GradientDescent)
    assert built.field.b_x == pytest.approx(0.5)
    assert built.field.b_z == pytest.approx(0.8660254)


@pytest.mark.parametrize("key", ["low_pass_hz", "fix_delay_s", "mag_delay_s", "accel_bias_sigma"])
def test_what_the_flight_filter_must_know_reaches_it(key):
    text = f"[filter]\nname = 'velocity-aided'\n[filter.velocity-aided]\n{key} = 0.03125"
    parameters = parse_config(text, "x").filter.build().parameters
    assert getattr(parameters, key) == 0.03125
    changed = {key: 0.03125}
    if key == "low_pass_hz":
        changed["low_pass_delay_sigma"] = 0.0  # a corner that the user tells is certain
    assert parameters == dataclasses.replace(default_filter("velocity-aided").parameters, **changed)


@pytest.mark.parametrize(
    ("lines", "asked_for"),
    [
        ("", VehicleSettings(20.0, 0.1)),
        ("low_pass_hz = 'auto'\nfix_delay_s = 'auto'", VehicleSettings(20.0, 0.1)),
        ("low_pass_hz = 33", VehicleSettings(nan, 0.1)),
        ("fix_delay_s = 0", VehicleSettings(20.0, nan)),
    ],
)
def test_a_number_is_not_asked_of_the_autopilot_and_holds_against_it(lines, asked_for):
    built = parse_config(f"[filter]\nname = 'velocity-aided'\n[filter.velocity-aided]\n{lines}", "x").filter.build()
    assert repr(built.default_settings) == repr(asked_for)  # NaN equals nothing, but is written like itself
    told = built.with_vehicle_settings(VehicleSettings(77.0, 0.5)).parameters
    assert told.low_pass_hz == (33.0 if "33" in lines else 77.0)
    assert told.fix_delay_s == (0.0 if "= 0" in lines else 0.5)


@pytest.mark.parametrize("value", ["'automatic'", "-1", "1001", "true"])
def test_a_low_pass_that_cannot_be_meant_is_named(value):
    with pytest.raises(ConfigError, match=r"filter.velocity-aided.low_pass_hz: expected"):
        parse_config(f"[filter.velocity-aided]\nlow_pass_hz = {value}", "x")


def test_left_to_itself_it_flies_the_filter_for_flight_with_its_parameters():
    config = parse_config("[filter.velocity-aided]\nlow_pass_hz = 40", "x")
    assert config.filter.name == "auto"
    assert config.filter.chosen == config.filter.build().name == "velocity-aided"
    assert config.filter.build().parameters.low_pass_hz == 40.0


def test_scales_of_raw_readings_go_together():
    with pytest.raises(ConfigError, match="raw_imu: accel_mps2 and gyro_radps go together"):
        parse_config("[raw_imu]\naccel_mps2 = 0.01", "x")


@pytest.mark.parametrize("name", ["attitude_quaternion", "attitude_quaternion_cov", "named_values"])
def test_an_output_is_chosen_by_its_name_in_the_table(name):
    (link,) = parse_config(f"[[link]]\nurl = 'sim:'\npublish = ['{name}']", "x").link
    assert link.publish == (name,)


@pytest.mark.parametrize("name", ["RAW_IMU", "SCALED_IMU", "SCALED_IMU2", "SCALED_IMU3", "HIGHRES_IMU"])
def test_every_inertial_message_can_be_named(name):
    assert parse_config(f"[streams]\nimu_messages = ['{name}']", "x").streams.imu_messages == (name,)
    assert name in outcome("[streams]\nimu_messages = ['GPS_RAW_INT']"), "a wrong name is answered with the right ones"


def test_the_words_that_the_configuration_repeats_are_those_of_the_code():
    """It does not import the packages that act on them, but for tables of names."""
    assert get_args(SpeedSource) == SPEED_SOURCES
    assert get_args(VelocitySource) == ("GPS_RAW_INT", *POSITION_MESSAGES, "none")
    assert get_args(FilterConfig.__annotations__["name"]) == ("auto", *filter_names(), "own")


def test_links_of_the_command_line_replace_those_of_the_file():
    config = parse_config("[[link]]\nurl = 'sim:'\npublish = []", "x").with_links(("udpin::0", "sim:"))
    assert [link.url for link in config.link] == ["udpin::0", "sim:"]
    assert config.link[1] == LinkConfig(url="sim:")


@pytest.mark.parametrize(
    ("text", "keeps"),
    [("", False), ("signing = 'sign'\nkey_file = 'k'", True), ("parameters = true", True), ("key_file = 'k'", False)],
)
def test_state_is_kept_where_a_link_signs_or_has_parameters(text, keeps):
    assert parse_config(f"[[link]]\nurl = 'sim:'\n{text}", "x").keeps_state == keeps
