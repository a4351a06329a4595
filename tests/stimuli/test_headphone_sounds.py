"""The sounds of the headphone test: levels, phases and ears."""

import itertools

import numpy as np
import pytest

from slipscale.faults import UserError
from slipscale.stimuli.headphone_sounds import EARS, NoiseInEar, Tones

RATE_HZ = 8_000


def tone_of(sound, number):
    """Return both channels of one tone, without its ramps."""
    begin = round((number - 1) * 1.5 * RATE_HZ)
    return sound.samples(RATE_HZ)[begin + 800 : begin + 7_200].astype(float)


@pytest.mark.parametrize("quiet, antiphase", list(itertools.permutations((1, 2, 3), 2)))
def test_one_tone_is_6_db_quieter_and_another_in_antiphase(quiet, antiphase):
    sound = Tones(quiet=quiet, antiphase=antiphase, level_db=-20.0)
    for number in (1, 2, 3):
        left, right = tone_of(sound, number).T
        level_db = 20 * np.log10(np.sqrt(2 * np.mean(left**2)))
        assert level_db == pytest.approx(-26.0 if number == quiet else -20.0, abs=0.01)
        assert right == pytest.approx(-left if number == antiphase else left, abs=1e-9)


def test_from_two_loudspeakers_the_tone_in_antiphase_is_the_quietest():
    """What cancels in the air between them is the sum of both channels."""
    sound = Tones(quiet=1, antiphase=3, level_db=-20.0)
    powers = [np.mean(tone_of(sound, number).sum(axis=1) ** 2) for number in (1, 2, 3)]
    assert int(np.argmin(powers)) + 1 == 3


def test_the_tones_are_200_hz_with_pauses_and_no_clicks():
    sound = Tones(quiet=2, antiphase=1, level_db=-6.0)
    samples = sound.samples(RATE_HZ)
    assert samples.shape == (4 * RATE_HZ, 2)
    assert sound.duration_s == 4.0
    spectrum = np.abs(np.fft.rfft(tone_of(sound, 3)[:, 0]))
    assert np.fft.rfftfreq(6_400, 1 / RATE_HZ)[np.argmax(spectrum)] == 200.0
    assert not samples[RATE_HZ + 1 : round(1.5 * RATE_HZ)].any()
    assert np.abs(np.diff(samples[:, 0])).max() < 0.09


@pytest.mark.parametrize("ear", EARS)
def test_the_noise_is_in_the_ear_that_is_said_at_its_level(ear):
    sound = NoiseInEar(ear=ear, level_db=-20.0, seed=3)
    samples = sound.samples(RATE_HZ).astype(float)
    heard = np.sqrt(2 * np.mean(samples**2, axis=0))
    for channel, name in enumerate(("left", "right")):
        if ear in (name, "both"):
            assert 20 * np.log10(heard[channel]) == pytest.approx(-20.0, abs=1.5)
        else:
            assert heard[channel] == 0.0
    assert len(samples) == sound.duration_s * RATE_HZ


@pytest.mark.parametrize("quiet, antiphase", [(1, 1), (0, 2), (2, 4)])
def test_a_trial_that_proves_nothing_is_refused(quiet, antiphase):
    with pytest.raises(UserError, match="two different tones"):
        Tones(quiet=quiet, antiphase=antiphase, level_db=-20.0)
