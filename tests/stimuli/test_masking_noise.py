import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from slipscale.faults import UserError
from slipscale.stimuli.masking_noise import pink_noise, ramp

RATE_HZ = 48_000.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_power_density_falls_as_one_over_f(seed):
    noise = pink_noise(level_db=-20, seed=seed)
    frequency_hz, density = signal.welch(noise, RATE_HZ, nperseg=8192)
    audible = (frequency_hz > 100) & (frequency_hz < 15_000)
    slope, _ = np.polyfit(np.log(frequency_hz[audible]), np.log(density[audible]), 1)
    assert slope == pytest.approx(-1, abs=0.03)


def test_every_octave_holds_the_same_power():
    noise = pink_noise(level_db=-20, seed=1)
    frequency_hz = np.fft.rfftfreq(noise.size, 1 / RATE_HZ)
    power = np.abs(np.fft.rfft(noise)) ** 2
    octaves = [
        power[(frequency_hz >= low) & (frequency_hz < 2 * low)].sum()
        for low in (500, 1000, 2000, 4000, 8000)
    ]
    assert np.ptp(10 * np.log10(octaves)) < 0.4


@pytest.mark.parametrize("level_db", [-40.0, -20.0, -16.0])
def test_the_level_is_the_root_mean_square_re_a_full_scale_sine(level_db):
    noise = pink_noise(level_db=level_db, seed=1).astype(float)
    sine = np.sin(2 * np.pi * 1000 * np.arange(48_000) / RATE_HZ)
    ratio = np.sqrt(np.mean(noise**2)) / np.sqrt(np.mean(sine**2))
    assert 20 * math.log10(ratio) == pytest.approx(level_db, abs=0.001)


def test_the_band_holds_all_power():
    noise = pink_noise(level_db=-20, seed=1, low_hz=200, high_hz=5000)
    frequency_hz = np.fft.rfftfreq(noise.size, 1 / RATE_HZ)
    power = np.abs(np.fft.rfft(noise)) ** 2
    outside = power[(frequency_hz < 199.9) | (frequency_hz > 5000.1)].sum()
    assert outside < 1e-10 * power.sum()


def test_the_end_meets_the_beginning():
    noise = pink_noise(level_db=-20, seed=1).astype(float)
    steps = np.abs(np.diff(noise))
    assert abs(noise[0] - noise[-1]) < steps.max()


def test_the_seed_decides_the_noise():
    first, again, other = (pink_noise(level_db=-20, seed=seed, duration_s=1) for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_a_level_that_would_clip_is_refused_with_the_highest_that_does_not():
    with pytest.raises(UserError, match="at most -") as refusal:
        pink_noise(level_db=-3, seed=1)
    highest_db = float(str(refusal.value).split("at most ")[1].split(",")[0])
    assert np.abs(pink_noise(level_db=highest_db, seed=1)).max() <= 1


@pytest.mark.parametrize("level_db", [math.nan, math.inf, -math.inf])
def test_a_level_that_is_no_number_is_refused(level_db):
    with pytest.raises(UserError, match="finite number of dB"):
        pink_noise(level_db=level_db, seed=1)


def test_a_band_that_nothing_fits_is_refused():
    with pytest.raises(UserError, match="no frequency"):
        pink_noise(level_db=-20, seed=1, sample_rate_hz=30.0, duration_s=1)


@given(st.floats(0, 1), st.sampled_from([0.0, 1.0]), st.integers(1, 2000), st.integers(0, 1000))
def test_a_fade_never_jumps_overshoots_or_turns_back(gain, target, samples, fade_samples):
    gains = np.concatenate([[gain], ramp(gain, target, samples, fade_samples)])
    assert np.abs(np.diff(gains)).max() <= 1 / max(fade_samples, 1) + 1e-12
    assert gains.min() >= 0
    assert gains.max() <= 1
    assert np.all(np.diff(np.abs(gains - target)) <= 1e-12)


def test_a_fade_takes_as_long_as_it_should():
    gains = ramp(0.0, 1.0, 150, 100)
    assert gains[98] < 1
    assert gains[100] == 1
