"""The zero-phase high-pass against its defining response and against a signal library's output."""

from math import pi, tan

import numpy as np
import pytest

from attest_mav.evaluation.butterworth import highpass


def gain(frequency_hz, cutoff_hz, rate_hz):
    """Power response of a fourth-order Butterworth high-pass after the bilinear transform: what two passes leave."""
    ratio = tan(pi * cutoff_hz / rate_hz) / tan(pi * frequency_hz / rate_hz)
    return 1.0 / (1.0 + ratio**8)


@pytest.mark.parametrize("frequency_hz", [0.5, 2.0, 4.0, 5.0, 6.0, 10.0, 30.0])
def test_a_sinusoid_keeps_its_phase_and_the_share_that_the_response_says(frequency_hz):
    t = np.arange(4000) / 100.0
    wave = np.sin(2.0 * pi * frequency_hz * t + 0.4)
    inner = slice(1000, 3000)
    filtered = highpass(wave[:, np.newaxis], 5.0, 100.0)[inner, 0]
    assert filtered == pytest.approx(gain(frequency_hz, 5.0, 100.0) * wave[inner], abs=1e-9)


def test_half_the_power_passes_at_the_cutoff():
    assert gain(5.0, 5.0, 100.0) == pytest.approx(0.5)


def test_a_constant_is_removed_to_the_last_sample_and_a_slope_away_from_the_ends():
    columns = np.column_stack((np.full(600, 3.0), np.linspace(-1.0, 4.0, 600)))
    filtered = highpass(columns, 5.0, 100.0)
    assert filtered[:, 0] == pytest.approx(np.zeros(600), abs=1e-13)
    assert filtered[250:350, 1] == pytest.approx(np.zeros(100), abs=1e-12)


def test_reversed_input_gives_reversed_output_away_from_the_ends():
    noise = np.random.default_rng(4).standard_normal((1000, 1))
    forwards, backwards = highpass(noise, 5.0, 100.0), highpass(noise[::-1], 5.0, 100.0)[::-1]
    assert forwards[300:700] == pytest.approx(backwards[300:700], abs=1e-12)


def test_the_ends_are_treated_as_the_signal_library_does():
    """Values of scipy.signal.sosfiltfilt(butter(4, 0.1, "high", output="sos"), x), scipy 1.17."""
    k = np.arange(40)
    x = np.sin(0.3 * k) + 0.02 * k**1.5
    expected = (
        -0.05211236864217908,
        0.04653228300610912,
        0.15383142607346978,
        0.07196729629291199,
        -0.09211553411412354,
        0.09271176211526977,
        -0.25152883305985163,
        -0.03437791601039403,
    )
    assert highpass(x[:, np.newaxis], 5.0, 100.0)[[0, 1, 2, 10, 20, 30, 38, 39], 0] == pytest.approx(
        expected, abs=1e-12
    )
