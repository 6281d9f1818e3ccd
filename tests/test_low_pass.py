"""The low-pass filters: how much of a motion they hide between samples."""

import pytest

from attest_mav.low_pass import aliased_share


@pytest.mark.parametrize(
    ("cutoff_hz", "dt_s", "share"),
    [(20.0, 0.02, 16.0 / 641.0), (20.0, 0.05, 0.5), (20.0, 0.25, 625.0 / 626.0), (0.0, 0.001, 1.0)],
)
def test_the_share_that_samples_miss_grows_with_corner_and_interval(cutoff_hz, dt_s, share):
    assert aliased_share(cutoff_hz, dt_s) == pytest.approx(share, rel=1e-12)
