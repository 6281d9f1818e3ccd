"""Filters of one's own, by the name of their class."""

from dataclasses import replace
from math import nan

import pytest

from attest_mav import ArgumentError, FlightParameters, GradientDescent, Leveling, RobustAdaptive
from attest_mav.config.parsing import parse_config
from attest_mav.errors import UsageError
from attest_mav.filters.own import own_filter, own_parameters, search_here
from attest_mav.filters.registry import default_filter

MODULE = """
from dataclasses import dataclass

from attest_mav import AttitudeFilter, FilterState


@dataclass(frozen=True)
class Held(AttitudeFilter):
    gain: float = 1.0

    def __post_init__(self):
        if self.gain < 0.0:
            raise ValueError(f"gain = {self.gain}: expected 0 or more")

    @property
    def name(self):
        return "held"

    def initial(self, start):
        return FilterState(start.q_nb, start.gyro_bias, False, False)

    def step(self, state, dt_s, sample, inputs):
        return state


class Bare(Held):
    def __init__(self, gain, *rest, low=2, **others):
        raise TypeError


class NoFilter:
    pass
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    """The name of a module with a filter, which can be imported."""
    (tmp_path / "held_filters.py").write_text(MODULE, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    return "held_filters"


def test_a_class_by_its_name_is_a_filter_with_its_parameters(module):
    assert default_filter(f"{module}:Held").name == "held"
    assert own_filter(f"{module}:Held", {"gain": 3.0}).gain == 3.0


def test_the_parameters_of_a_class_are_told_with_their_defaults(module):
    assert own_parameters(f"{module}:Held") == {"gain": 1.0}
    assert own_parameters(f"{module}:Bare") == {"gain": None, "low": 2}


def test_a_configuration_names_the_class_and_its_parameters(module):
    text = f'[filter]\nname = "own"\n[filter.own]\nclass = "{module}:Held"\nparameters = {{ gain = 2.5 }}\n'
    config = parse_config(text, "a.toml").filter
    assert config.build().gain == 2.5
    assert config.named(f"{module}:Held").gain == 2.5
    changed = parse_config(text, "a.toml", ["filter.own.parameters.gain=4.0"]).filter
    assert changed.build().gain == 4.0


@pytest.mark.parametrize(
    ("name", "parameters", "words"),
    [
        ("{}:Nothing", {}, "no such class; expected a subclass of attest_mav.AttitudeFilter"),
        ("{}:NoFilter", {}, "it is no AttitudeFilter"),
        ("{}:Held", {"gian": 1.0}, "gian"),
        ("{}:Held", {"gain": -1.0}, "gain = -1.0: expected 0 or more"),
        ("{}:a b", {}, "expected MODULE:CLASS"),
        (":Held", {}, "expected MODULE:CLASS"),
        ("missing_module:Held", {}, "no module missing_module; expected one that is installed"),
    ],
)
def test_a_name_that_is_wrong_is_explained(module, name, parameters, words):
    with pytest.raises(UsageError, match=words):
        own_filter(name.format(module), parameters)


def test_the_current_folder_comes_last(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.path", ["first"])
    search_here(str(tmp_path))
    search_here(str(tmp_path))
    import sys  # noqa: PLC0415 - after it was replaced

    assert sys.path == ["first", str(tmp_path)]


def test_a_filter_of_that_name_that_does_not_exist_lists_those_that_do():
    with pytest.raises(UsageError, match=r"unknown filter .x.; known filters: gradient-descent, .*, and MODULE:CLASS"):
        default_filter("x")


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (lambda: GradientDescent(beta=-1.0), "GradientDescent: beta = -1.0; expected a number above 0"),
        (lambda: GradientDescent(min_accel_g=2.0), "max_accel_g = 1.5; expected more than min_accel_g, 2.0"),
        (lambda: RobustAdaptive(r_accel=nan), "RobustAdaptive: r_accel = nan; expected a number above 0"),
        (lambda: Leveling(spacing_s=-0.1), "Leveling: spacing_s = -0.1; expected 0 or more"),
        (lambda: FlightParameters(fix_delay_s=nan), "FlightParameters: fix_delay_s = nan; expected 0 or more"),
        (lambda: replace(FlightParameters(), velocity_gate=0.0), "velocity_gate = 0.0; expected a number above 0"),
    ],
)
def test_a_parameter_that_makes_no_sense_is_refused_where_the_filter_is_made(made, words):
    with pytest.raises(ArgumentError, match=words):
        made()
