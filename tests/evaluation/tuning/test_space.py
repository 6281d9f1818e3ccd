"""Ranges and choices of parameters, and the points among them."""

import pytest

from attest_mav.errors import UsageError
from attest_mav.evaluation.tuning.space import Parameter, grid_points, parse_parameter, random_points

KNOWN = ("beta", "alpha", "rest_bias")
BETA = parse_parameter("beta=0.01:1:log", KNOWN, "gradient-descent")
ALPHA = parse_parameter("alpha=1:5", KNOWN, "gradient-descent")
REST = parse_parameter("rest_bias=true,false", KNOWN, "gradient-descent")


def texts(parameters, points):
    return [tuple(one.text(position) for one, position in zip(parameters, point, strict=True)) for point in points]


def test_a_grid_has_every_combination_with_the_ends_of_ranges():
    points = texts((BETA, REST), grid_points((BETA, REST), 3))
    assert points == [(beta, rest) for beta in ("0.01", "0.1", "1") for rest in ("true", "false")]
    assert texts((ALPHA,), grid_points((ALPHA,), 5)) == [("1",), ("2",), ("3",), ("4",), ("5",)]


def test_a_random_point_lies_in_its_range_and_equal_seeds_give_equal_points():
    points = random_points((BETA, ALPHA, REST), 200, 7)
    assert points == random_points((BETA, ALPHA, REST), 200, 7)
    assert points != random_points((BETA, ALPHA, REST), 200, 8)
    found = texts((BETA, ALPHA, REST), points)
    assert all(0.01 <= float(beta) <= 1.0 and 1.0 <= float(alpha) <= 5.0 for beta, alpha, _ in found)
    assert {rest for _, _, rest in found} == {"true", "false"}
    below = sum(float(beta) < 0.1 for beta, _, _ in found)
    assert 70 < below < 130, "half of a logarithmic range lies below its geometric middle"


def test_neighbours_are_those_of_the_grid_and_end_with_the_range():
    grid = BETA.grid(5)
    assert BETA.beside(grid[2], 5) == (grid[1], grid[3])
    assert BETA.beside(grid[0], 5) == (None, grid[1])
    assert REST.beside(1.0, 5) == (0.0, None)
    assert Parameter("one", choices=("7",)).beside(0.0, 5) == (None, None)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("gain=0:1", "has no gain; its parameters: beta, alpha, rest_bias"),
        ("beta", "expected NAME=LOW:HIGH"),
        ("beta=", "expected NAME=LOW:HIGH"),
        ("beta=1:0", "a LOW below HIGH"),
        ("beta=0:1:log", "a LOW above 0"),
        ("beta=0:1:lin", "expected NAME=LOW:HIGH"),
        ("beta=0:x", "'x' is no number"),
        ("beta=0:inf", "'inf' is no number"),
        ("beta=0.1,,0.2", "a value is missing"),
    ],
)
def test_what_cannot_be_meant_is_refused(text, words):
    with pytest.raises(UsageError, match="--param") as caught:
        parse_parameter(text, KNOWN, "gradient-descent")
    assert words in str(caught.value)


def test_a_grid_that_is_too_large_is_refused():
    with pytest.raises(UsageError, match="--runs"):
        grid_points((BETA, ALPHA), 101)
