"""The papers' figures: every one is drawn, with what it should show on its axes."""

import numpy as np
import pytest
from click.testing import CliRunner

from attest_mav.cli.evaluate import command as evaluate
from attest_mav.errors import UnwritableError, UsageError
from attest_mav.evaluation.papers import figures, figures_paper3
from attest_mav.evaluation.papers.paper2 import LIMIT_DEG

PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture(autouse=True)
def _few_runs(monkeypatch):
    pytest.importorskip("matplotlib", reason="figures need the extra report")
    monkeypatch.setattr(figures_paper3, "RUNS", 2)


@pytest.fixture(scope="module")
def drawn():
    """Figures by name, drawn once."""
    kept = {}

    def draw(name):
        if name not in kept:
            (chosen,) = [figure for figure in figures.ALL if figure.name == name]
            kept[name] = chosen.draw(1, map)
        return kept[name]

    return draw


@pytest.mark.parametrize("name", [figure.name for figure in figures.ALL])
def test_every_figure_has_titles_units_and_curves(drawn, name):
    figure = drawn(name)
    assert "Paper" in figure.get_suptitle()
    for axes in figure.axes:
        assert axes.get_title(loc="left")
        assert axes.lines
        assert all(np.isfinite(line.get_ydata()).all() for line in axes.lines)
    assert any(axes.get_xlabel() == "time, s" for axes in figure.axes)
    assert any(axes.get_legend() is not None for axes in figure.axes) or "plain" in name


def test_the_large_gain_shakes_and_the_small_one_does_not(drawn):
    """What the paper's figure is about."""
    close_ups = [
        axes.lines for axes in drawn("paper1-fig3-euler-angles").axes if axes.get_title(loc="left") == "roll, close up"
    ]
    shaking = [np.std(np.diff(lines[1].get_ydata())) for lines in close_ups]
    assert shaking[1] > 10.0 * shaking[0]


def test_the_recommended_logic_stays_within_the_claim_and_the_printed_one_does_not(drawn):
    largest = {
        axes.get_title(loc="left"): np.abs(axes.lines[0].get_ydata()).max()
        for axes in drawn("paper2-fig3-robust-adaptive").axes
    }
    assert largest["roll, recommended logic"] < LIMIT_DEG
    assert largest["roll, as printed"] > LIMIT_DEG


def test_the_command_draws_the_figures_of_the_chosen_papers(tmp_path):
    folder = tmp_path / "new" / "figures"
    result = CliRunner().invoke(evaluate, ["P2-h", "--workers", "1", "--plot", str(folder)])
    assert result.exit_code == 0, result.output
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["paper2-fig2-plain-filter.png", "paper2-fig3-robust-adaptive.png"]
    assert all((folder / name).read_bytes().startswith(PNG) for name in names)


def test_a_folder_that_cannot_be_made_is_one_clear_line_before_anything_runs(tmp_path):
    (tmp_path / "file").write_text("")
    result = CliRunner().invoke(evaluate, ["P2-h", "--workers", "1", "--plot", str(tmp_path / "file" / "figures")])
    assert isinstance(result.exception, UsageError)
    assert "cannot make the folder" in str(result.exception)
    assert not result.stdout


def test_a_figure_that_cannot_be_written_is_one_clear_line(tmp_path):
    (tmp_path / "paper2-fig2-plain-filter.png").mkdir()
    result = CliRunner().invoke(evaluate, ["P2-h", "--workers", "1", "--plot", str(tmp_path)])
    assert isinstance(result.exception, UnwritableError)


def test_without_matplotlib_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setattr(figures, "find_spec", lambda _: None)
    with pytest.raises(UsageError, match=r"attest-mav\[report\]"):
        figures.figures_for(["P1-a"])
