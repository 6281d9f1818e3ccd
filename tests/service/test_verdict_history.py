"""Which verdicts are told: accusations at once, doubts that last."""

from math import nan

import pytest

from attest_mav.estimation.events import Agreement, Verdict
from attest_mav.service.verdict_history import VerdictHistory

A, D, U = Agreement.AGREE, Agreement.DISAGREE, Agreement.UNDECIDED


def told(agreements, interval_s):
    """The times (s) at which a run of verdicts at that interval is told, with what is told."""
    history = VerdictHistory()
    lines = []
    for k, agreement in enumerate(agreements):
        rx_ns = round(k * interval_s * 1e9)
        if history.take(Verdict(agreement, "", nan, nan, "ATTITUDE", rx_ns, rx_ns)) is not None:
            lines.append((k * interval_s, agreement))
    return lines


def test_an_accusation_and_its_end_are_told_at_once():
    assert told([A] * 10 + [D] * 10 + [U] * 10, 0.1) == [(0.0, A), (1.0, D), (2.0, U)]


@pytest.mark.parametrize("interval_s", [0.25, 0.5, 1.0])
def test_a_doubt_that_comes_and_goes_is_not_told(interval_s):
    assert told([A, A, U, A, U, U, A] * 60, interval_s) == [(0.0, A)]


def test_a_doubt_that_lasts_is_told():
    assert told([A] * 5 + [U] * 30, 1.0) == [(0.0, A), (15.0, U)]


def test_an_accusation_is_told_even_between_doubts():
    assert [agreement for _, agreement in told([A, U, D, U, A, U, D], 1.0)] == [A, D, U, D]
