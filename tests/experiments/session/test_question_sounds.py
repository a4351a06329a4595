"""The headphone test's sounds on a sound output: what the card is handed, and a null device."""

import os
import subprocess
import sys

import numpy as np
import pytest

from slipscale.experiments.session.sound.question_sounds import Once

NULL_DEVICE = "pcm.!default { type null }\nctl.!default { type null }\n"
PROGRAM = """
from threading import Event
from slipscale.experiments.session.sound.masking_noise import check_device
from slipscale.experiments.session.sound.question_sounds import Once, SoundOutput
from slipscale.stimuli.headphone_sounds import NoiseInEar, Tones
print(check_device())
fill, played = Once.fill, Event()
Once.fill = lambda *words: (fill(*words), played.set())
output = SoundOutput()
output.start(Tones(quiet=1, antiphase=2, level_db=-20.0))
print(played.wait(300))
output.start(NoiseInEar(ear="left", level_db=-30.0, seed=1))
output.stop()
output.stop()
print(output.missing == "")
"""


def test_samples_are_handed_over_once_and_then_there_is_silence():
    samples = np.arange(1, 11, dtype=np.float32).reshape(5, 2)
    playing = Once(samples)
    heard = []
    for size in (2, 2, 2, 3):
        block = np.full((size, 2), 9.0, dtype=np.float32)
        playing.fill(block)
        heard.append(block)
    whole = np.concatenate(heard)
    assert np.array_equal(whole[:5], samples)
    assert not whole[5:].any()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="a null device of ALSA")
def test_the_sounds_play_on_a_device_and_can_be_broken_off(tmp_path):
    config = tmp_path / "null.conf"
    config.write_text(NULL_DEVICE)
    result = subprocess.run(
        [sys.executable, "-W", "error", "-c", PROGRAM],
        env=os.environ | {"ALSA_CONFIG_PATH": str(config), "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert result.stdout.split() == ["None", "True", "True"], result.stderr
