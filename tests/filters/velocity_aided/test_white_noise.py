"""White noise of a sensor, by how its second differences follow each other."""

import numpy as np
import pytest

from attest_mav.filters.velocity_aided.white_noise import no_white_noise, observed

DT_S = 0.02
SECONDS = 60.0


def variance_of(readings, dt_s=DT_S):
    """The estimate after these readings, one a row."""
    noise = no_white_noise()
    for difference in np.diff(readings, n=2, axis=0).tolist():
        noise = observed(noise, tuple(difference), dt_s)
    return noise.variance


def times():
    return np.arange(0.0, SECONDS, DT_S)[:, None]


@pytest.mark.parametrize("sigma", [0.003, 1.0])
def test_white_noise_is_found_beside_motion(sigma):
    """The motion is a turn to and fro at 0.5 Hz, a hundred times as large as the smaller noise."""
    white = np.random.default_rng(1).normal(0.0, sigma, (times().size, 3))
    motion = 0.3 * np.sin(np.pi * times()) * np.array([1.0, -0.5, 0.2])
    assert variance_of(motion + white) == pytest.approx(sigma**2, rel=0.3)


@pytest.mark.parametrize("hertz", [0.1, 2.0, 5.0, 9.0, 15.0, 18.0])
def test_an_oscillation_is_no_white_noise(hertz):
    """Of the rate of the samples, 50 Hz: one that they show well, and vibration up to three eighths of it."""
    motion = np.sin(2.0 * np.pi * hertz * times() + np.array([0.0, 1.0, 2.0]))
    assert variance_of(motion) < 0.01 * 0.5


def test_gusts_between_samples_are_no_white_noise():
    """Noise with its power between a quarter and a third of the samples' rate, as turbulence leaves a low-pass."""
    white = np.random.default_rng(2).normal(0.0, 8.0, (times().size, 3))
    spectrum = np.fft.rfft(white, axis=0)
    cycles = np.fft.rfftfreq(times().size)[:, None]
    gusts = np.fft.irfft(np.where((cycles > 0.22) & (cycles < 0.33), spectrum, 0.0), n=times().size, axis=0)
    assert variance_of(gusts) == 0.0


def test_the_mean_of_a_new_noise_takes_half_a_minute_at_50_hz_and_a_hundred_samples_at_4_hz():
    rng = np.random.default_rng(3)
    for dt_s, samples in ((DT_S, 30.0 / DT_S), (0.25, 200)):
        quiet = np.zeros((2000, 3))
        loud = rng.normal(0.0, 1.0, (round(samples), 3))
        assert 0.4 < variance_of(np.vstack([quiet, loud]), dt_s) < 1.4
