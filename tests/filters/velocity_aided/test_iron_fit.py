"""The regression of hard iron from readings with their attitudes, whose field and iron are known."""

import numpy as np
import pytest

from attest_mav.algebra import q_heading, q_to_matrix, q_unit
from attest_mav.filters.velocity_aided.aids.iron_fit import FIELD_NOISE, PRIOR, fitted, no_moments

FIELD = np.array([0.4, 0.1, 0.9])
IRON = np.array([0.12, -0.2, 0.05])


def attitudes(count, seed=2):
    """Random ones, evenly over all directions."""
    draws = np.random.default_rng(seed).standard_normal((count, 4))
    return [np.array(q_to_matrix(q_unit(tuple(one)))) for one in draws.tolist()]


def level(count):
    """A whole turn about the vertical."""
    return [np.array(q_to_matrix(q_heading(2.0 * np.pi * k / count))) for k in range(count)]


def regression_of(matrices, field=FIELD, noise=0.0, turn=0.1):
    rng, moments = np.random.default_rng(4), no_moments()
    for c in matrices:
        u = c.T @ field + IRON + noise * rng.standard_normal(3)
        moments = moments.with_reading(tuple(u.tolist()), tuple(tuple(row) for row in c.tolist()), turn, 1.0)
    return moments


def test_turns_about_all_axes_show_iron_and_field():
    moments = regression_of(attitudes(600))
    found = fitted(moments.regression(), FIELD_NOISE)
    assert found.iron == pytest.approx(tuple(IRON), abs=0.002)
    assert moments.field(found.iron) == pytest.approx(tuple(FIELD), abs=0.001)
    assert moments.regression().left(found.iron) < 1e-3 * moments.regression().left((0.0, 0.0, 0.0))


def test_a_level_turn_shows_the_level_iron_alone():
    found = fitted(regression_of(level(300)).regression(), FIELD_NOISE)
    assert found.iron[:2] == pytest.approx(tuple(IRON[:2]), abs=0.002)
    assert found.iron[2] == pytest.approx(0.0, abs=1e-9)
    assert np.sqrt(found.covariance[2][2]) == pytest.approx(PRIOR)
    assert np.sqrt(found.covariance[0][0]) < 0.01


def test_the_heading_of_another_time_may_be_any():
    """A field that is turned about the vertical is as good, where each time has a regression of its own."""
    first, second = attitudes(600)[:3], attitudes(600)[3:6]
    turned = np.array(q_to_matrix(q_heading(2.0))) @ FIELD
    apart = regression_of(first, turn=50.0).regression().and_of(regression_of(second, turned, turn=50.0).regression())
    assert fitted(apart, FIELD_NOISE).iron == pytest.approx(tuple(IRON), abs=0.002)
    # Taken for one field, the same readings show another iron.
    moments = regression_of(first, turn=50.0)
    for c in second:
        u = c.T @ turned + IRON
        moments = moments.with_reading(tuple(u.tolist()), tuple(tuple(row) for row in c.tolist()), 50.0, 1.0)
    assert np.linalg.norm(np.array(fitted(moments.regression(), FIELD_NOISE).iron) - IRON) > 0.05


def test_covariance_holds_for_noise():
    """Independent readings, each of which counts for the turn within which readings are alike."""
    off = []
    for seed in range(40):
        rng, moments = np.random.default_rng(seed), no_moments()
        for c in attitudes(20, seed):
            u = c.T @ FIELD + IRON + 0.05 * rng.standard_normal(3)
            moments = moments.with_reading(tuple(u.tolist()), tuple(tuple(row) for row in c.tolist()), 0.5, 1.0)
        found = fitted(moments.regression(), FIELD_NOISE)
        error = np.array(found.iron) - IRON
        off.append(error @ np.linalg.solve(np.array(found.covariance), error) / 3.0)
    assert 0.6 < np.mean(off) < 1.4


def test_news_is_what_is_far_and_explains_the_readings():
    nothing, wide = (0.0, 0.0, 0.0), 0.02
    clear = regression_of(attitudes(600)).regression()
    assert fitted(clear, FIELD_NOISE).is_news(clear, nothing, nothing, wide)
    assert not fitted(clear, FIELD_NOISE).is_news(clear, tuple(IRON), tuple(IRON), wide)
    # As large as this, noise is no iron: a magnet that comes and goes.
    noisy = regression_of(attitudes(600), noise=0.4).regression()
    assert not fitted(noisy, FIELD_NOISE).is_news(noisy, nothing, nothing, wide)
