"""The search on costs that are known: a bowl with its bottom at 0.5, and logs that differ by an offset."""

import pytest

from attest_mav.errors import UnreadableDataError
from attest_mav.evaluation.tuning.search import CONFIGURED, Costs, Measured, search, split
from attest_mav.evaluation.tuning.space import Parameter, grid_points
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.replay.request import Request, Window

X = Parameter("x", 0.0, 1.0)
OFFSETS = {"a": 1.0, "b": 2.0, "c": 7.0}
CONFIGURED_X = 0.9
WHOLE = Window()


def request_of(point):
    """The request that carries a position in the place of a gain."""
    return Request((GradientDescent(beta=1.0 + (point[0] if point else CONFIGURED_X)),))


def bowl(trial):
    position = trial.request.filters[0].beta - 1.0
    return Measured((position - 0.5) ** 2 + OFFSETS[trial.path], "TRUTH")


def found(measure_one=bowl, steps=5):
    parts = split([(path, Measured(1.0)) for path in OFFSETS], 3, WHOLE)
    counts = []
    costs = Costs(request_of, measure_one, map, counts.append)
    return search(costs, parts, [X], grid_points([X], steps), steps), counts


def test_the_lowest_mean_over_the_tuning_logs_is_found_and_checked_on_the_others():
    result, counts = found()
    assert [part.path for part in result.parts if part.checks] == ["c"]
    assert result.best == (0.5,)
    assert result.ranked[0][1] == pytest.approx(1.5)
    assert result.checked[0.5,] == pytest.approx(7.0)
    assert result.configured == pytest.approx(1.5 + 0.16)
    assert result.configured_check == pytest.approx(7.16)
    # Five points and the configured one on two logs, and on the third; the neighbours are points of the grid.
    assert counts == list(range(1, 6 * 2 + 6 + 1))


def test_the_surroundings_show_how_flat_the_bottom_is():
    (flat,) = found()[0].flatness
    assert (flat.best, flat.below.text, flat.above.text, flat.at_end) == ("0.5", "0.25", "0.75", False)
    assert flat.below.cost == pytest.approx(1.5 + 0.0625)
    assert flat.above.cost == flat.below.cost


def test_a_bottom_at_the_end_of_the_range_is_told():
    def slope(trial):
        return Measured(trial.request.filters[0].beta)

    (flat,) = found(slope)[0].flatness
    assert flat.at_end
    assert flat.below is None


def test_a_point_that_gives_nothing_on_one_log_is_the_worst():
    def broken(trial):
        return Measured(None) if trial.path == "b" and trial.request.filters[0].beta == 1.5 else bowl(trial)

    result, _ = found(broken)
    assert result.best in {(0.25,), (0.75,)}
    assert result.ranked[-1][0] == (0.5,)


def test_nothing_at_all_is_an_error():
    with pytest.raises(UnreadableDataError, match="nothing was compared: why"):
        found(lambda _: Measured(None, error="why"))


@pytest.mark.parametrize(
    ("count", "every", "checking"), [(2, 3, [1]), (3, 3, [2]), (7, 3, [2, 5]), (4, 2, [1, 3]), (2, 9, [1])]
)
def test_every_so_many_th_log_checks(count, every, checking):
    parts = split([(str(k), Measured(1.0)) for k in range(count)], every, WHOLE)
    assert [index for index, part in enumerate(parts) if part.checks] == checking


def test_of_a_single_log_the_halves_tune_and_check():
    tuning, checking = split([("a", Measured(1.0, duration_s=50.0))], 3, Window(skip_s=4.0))
    assert (tuning.checks, tuning.window) == (False, Window(0.0, 25.0, 4.0))
    assert (checking.checks, checking.window.start_s) == (True, 25.0)
    assert CONFIGURED == ()
