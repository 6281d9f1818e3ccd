"""``attest-mav tune`` as a user meets it."""

import json
import sys
import tomllib
from pathlib import Path

import pytest
from click.testing import CliRunner

from attest_mav.cli.tune import command
from attest_mav.config.parsing import parse_config
from attest_mav.errors import UnreadableDataError, UsageError

CUTS = Path(__file__).parent.parent / "data"
LOG = CUTS / "copter_trim_told.tlog"
BASE = (LOG, "--filter", "gradient-descent", "--skip", "2", "--workers", "1")


def tune(*arguments):
    return CliRunner().invoke(command, [*map(str, arguments)])


def test_one_log_tunes_and_checks_by_its_halves_and_the_tables_fit(tmp_path):
    bad = tmp_path / "bad.tlog"
    bad.write_bytes(b"not a log at all\n" * 50)
    done = tune(*BASE, bad, "--param", "beta=0.01:1:log", "--steps", "3")
    assert done.exit_code == 65
    assert done.stderr.count("\n") == 1, "the bad log, and no progress in a pipe"
    assert str(bad) in done.stderr
    lines = done.stdout.splitlines()
    assert max(len(line.rstrip()) for line in lines) <= 80
    assert any(line.startswith("  one log: its first ") for line in lines)
    toml = done.stdout[done.stdout.index("[filter.gradient-descent]") :]
    parse_config(toml, "pasted")
    assert tomllib.loads(toml)["filter"]["gradient-descent"]["beta"] in {0.01, 0.1, 1.0}


def test_the_json_ranks_the_points_and_keeps_the_other_values():
    done = tune(*BASE, "--param", "beta=0.02,0.5", "--json", "--set", "filter.gradient-descent.alpha=7.0")
    assert done.exit_code == 0
    result = json.loads(done.stdout)
    assert [one["parameters"] for one in result["points"]] in (
        [{"beta": 0.02}, {"beta": 0.5}],
        [{"beta": 0.5}, {"beta": 0.02}],
    )
    costs = [one["cost"] for one in result["points"]]
    assert costs == sorted(costs)
    assert result["configured"]["parameters"] == {"beta": 0.033}
    assert result["logs"][0]["best"] == costs[0]
    assert [one["checks"] for one in result["logs"]] == [False, True]
    (flat,) = result["flatness"]
    assert (flat["below"] or flat["above"])["cost"] == costs[1]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--param", "gain=1,2"), "gradient-descent has no gain; its parameters: beta, full_fusion, alpha"),
        (("--param", "beta=1,2", "--param", "beta=3,4"), "given twice"),
        (("--param", "beta=1:50"), "beta"),
        (("--param", "beta=fast,slow"), "beta"),
        (("--param", "beta=0:1", "--steps", "1"), "--steps 1"),
        (("--param", "beta=0:1", "--runs", "0"), "--runs 0"),
        (("--param", "beta=0:1", "--check-every", "1"), "--check-every 1"),
        (("--param", "beta=0:1", "--cost", "tilt"), "--cost tilt: expected one of tilt.rms"),
    ],
)
def test_what_cannot_be_meant_is_refused_before_the_work(options, words):
    error = tune("/nonexistent.tlog", *BASE[1:], *options).exception
    assert isinstance(error, UsageError)
    assert words in str(error)


def test_a_filter_of_ones_own_is_tuned_with_the_parameters_of_its_table(tmp_path, monkeypatch):
    (tmp_path / "my_filters.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    config = tmp_path / "a.toml"
    config.write_text('[filter.own]\nclass = "my_filters:Turned"\nparameters = { full_fusion = false }\n')
    own = ("--filter", "my_filters:Turned", "--param", "beta=0.02,0.5", "--json", "--config", config)
    result = json.loads(tune(LOG, *own, "--skip", "2", "--workers", "1").stdout)
    same = ("--param", "beta=0.02,0.5", "--json", "--set", "filter.gradient-descent.full_fusion=false")
    expected = json.loads(tune(*BASE, *same).stdout)
    assert result["points"] == expected["points"]
    assert result["configured"] == expected["configured"]
    best = result["points"][0]["parameters"]["beta"]
    told = parse_config(result["toml"], "pasted").filter.own
    assert (told.filter_class, told.parameters) == ("my_filters:Turned", {"full_fusion": False, "beta": best})
    error = tune(LOG, *own[:2], "--param", "gain=1,2").exception
    assert "my_filters:Turned has no gain; its parameters: " in str(error)
    error = tune(LOG, *own[:2], "--param", "beta=-1,1").exception
    assert isinstance(error, UsageError)
    assert "beta" in str(error)
    error = tune(LOG, "--filter", "my_filters:None", "--param", "beta=1,2").exception
    assert "no such class" in str(error)


OWN = """
from attest_mav import AttitudeFilter, GradientDescent


class Turned(AttitudeFilter):
    def __init__(self, beta=GradientDescent().beta, full_fusion=True):
        self.beta, self.full_fusion = beta, full_fusion
        self._inner = GradientDescent(beta=beta, full_fusion=full_fusion)

    @property
    def name(self):
        return "turned"

    def initial(self, start):
        return self._inner.initial(start)

    def step(self, state, dt_s, sample, inputs):
        return self._inner.step(state, dt_s, sample, inputs)
"""


def test_an_unknown_filter_names_those_that_exist():
    error = tune(LOG, "--filter", "kalman", "--param", "beta=0:1").exception
    assert isinstance(error, UsageError)
    assert "velocity-aided" in str(error)


def test_no_usable_log_is_an_error(tmp_path):
    done = tune(tmp_path / "missing.tlog", *BASE[1:], "--param", "beta=0.1,0.2")
    assert isinstance(done.exception, UnreadableDataError)
