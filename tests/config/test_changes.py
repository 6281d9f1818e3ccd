"""Single values changed by ``--set KEY=VALUE``."""

import pytest

from attest_mav.config.parsing import parse_config
from attest_mav.errors import ConfigError, UsageError

TEXT = "[output]\nrate_hz = 10\n[filter.leveling]\nheading_time_s = 5.0\n"


def test_a_change_replaces_a_value_and_leaves_the_rest():
    config = parse_config(TEXT, "file", ["output.rate_hz=50", "filter.velocity-aided.low_pass_hz=42.5"])
    assert config.output.rate_hz == 50
    assert config.filter.leveling.heading_time_s == 5.0
    assert config.filter.velocity_aided.low_pass_hz == 42.5


@pytest.mark.parametrize(
    ("change", "value"), [("filter.name=leveling", "leveling"), ("filter.name='leveling'", "leveling")]
)
def test_a_word_needs_no_quotes(change, value):
    assert parse_config("", "none", [change]).filter.name == value


def test_the_last_of_two_changes_holds():
    assert parse_config(TEXT, "file", ["output.rate_hz=50", "output.rate_hz=25"]).output.rate_hz == 25


@pytest.mark.parametrize("change", ["output.rate_hz", "=5", "output.=5", ".rate_hz=5", ""])
def test_another_form_says_what_is_expected(change):
    with pytest.raises(UsageError, match="expected KEY=VALUE"):
        parse_config(TEXT, "file", [change])


def test_a_value_is_no_table():
    with pytest.raises(UsageError, match="rate_hz is no table"):
        parse_config(TEXT, "file", ["output.rate_hz.low=5"])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("output.rate=5", "output.rate"),
        ("output.rate_hz=fast", "output.rate_hz"),
        ("output.rate_hz=-1", "output.rate_hz"),
        ("link=udpin", "link"),
        ("output.rate_hz=1\nx=2", "output.rate_hz"),
    ],
)
def test_a_wrong_key_or_value_is_named_as_in_a_file(change, words):
    with pytest.raises(ConfigError, match=f"^file and --set: .*{words}"):
        parse_config(TEXT, "file and --set", [change])
