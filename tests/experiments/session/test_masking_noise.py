import os
import subprocess
import sys

import numpy as np
import pytest

from slipscale.experiments.session.sound.masking_noise import MaskingNoise, Playback
from slipscale.faults import UserError

NULL_DEVICE = "pcm.!default { type null }\nctl.!default { type null }\n"


def run(program, **environment):
    """Run a program in a Python of its own: PortAudio looks for devices once a process."""
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )


def block_of(playback, samples):
    block = np.empty((samples, 2), dtype=np.float32)
    playback.fill(block)
    return block


def test_noise_fades_in_loops_without_a_gap_and_fades_out():
    noise = np.linspace(0.5, 1.0, 70, dtype=np.float32)
    playback = Playback(noise, fade_samples=100)
    playback.target = 1.0
    heard = np.concatenate([block_of(playback, n) for n in (64, 36, 1, 300)])
    expected = noise[np.arange(401) % 70] * np.minimum(np.arange(1, 402) / 100, 1)
    assert heard[:, 0] == pytest.approx(expected, abs=1e-6)
    assert np.array_equal(heard[:, 0], heard[:, 1])
    playback.target = 0.0
    assert not playback.silent.is_set()
    fading = np.concatenate([block_of(playback, 60), block_of(playback, 60)])
    assert playback.silent.is_set()
    assert np.all(fading[100:] == 0)
    assert np.all(fading[:99] > 0)


def test_noise_says_when_it_is_at_its_level():
    playback = Playback(np.ones(70, dtype=np.float32), fade_samples=100)
    playback.target = 1.0
    block_of(playback, 99)
    assert not playback.level.is_set()
    assert block_of(playback, 1)[-1, 0] == 1.0
    assert playback.level.is_set()


def test_a_level_that_would_clip_is_refused_before_anything_plays():
    with pytest.raises(UserError, match="level_db"):
        MaskingNoise(level_db=0.0, fade_s=0.1, seed=1)


def test_stopping_what_never_played_is_no_fault():
    MaskingNoise(level_db=-20.0, fade_s=0.1, seed=1).stop()


def test_without_a_device_the_check_and_the_start_name_the_remedy(tmp_path):
    program = """
from slipscale.experiments.session.sound.masking_noise import MaskingNoise, check_device
from slipscale.faults import RigError
print(check_device())
try:
    MaskingNoise(level_db=-20.0, fade_s=0.1, seed=1).start()
except RigError as error:
    print(error)
"""
    config = tmp_path / "none.conf"
    config.write_text("pcm.!default { type hw card 77 }\n")
    result = run(program, ALSA_CONFIG_PATH=str(config), HOME=str(tmp_path))
    if sys.platform.startswith("linux"):
        checked, started = result.stdout.splitlines()
        assert "no sound can be played" in checked
        assert "turn masking noise off" in checked
        assert started == f"masking noise: {checked}"


def test_without_portaudio_the_check_names_what_to_install():
    program = """
import sys
class Missing:
    def find_spec(self, name, path=None, target=None):
        if name == "sounddevice":
            raise OSError("PortAudio library not found")
sys.meta_path.insert(0, Missing())
from slipscale.experiments.session.sound.masking_noise import check_device
print(check_device())
"""
    assert "libportaudio2" in run(program).stdout


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="ALSA's null device is Linux's")
def test_noise_plays_on_a_real_stream_and_ends_silent(tmp_path):
    (tmp_path / ".asoundrc").write_text(NULL_DEVICE)
    program = """
from slipscale.experiments.session.sound import masking_noise
from slipscale.experiments.session.sound.masking_noise import MaskingNoise, check_device
masking_noise.STALL_S = 300.0
print(check_device())
masking = MaskingNoise(level_db=-20.0, fade_s=0.05, seed=1)
for _ in range(2):
    masking.start()
    masking.start()
    print(masking._playback._gain == 1.0, masking._stream.active, masking.state)
    masking.stop()
    masking.stop()
    print(masking._stream, masking._playback.silent.is_set(), masking.state)
"""
    result = run(program, HOME=str(tmp_path))
    played = ["True", "True", "playing", "None", "True", "silent"]
    assert result.stdout.split() == ["None", *played * 2], result.stderr


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="ALSA's null device is Linux's")
def test_a_device_that_takes_nothing_is_told_before_the_plate_moves(tmp_path):
    (tmp_path / ".asoundrc").write_text(NULL_DEVICE)
    program = """
from slipscale.experiments.session.sound import masking_noise
from slipscale.faults import RigError
masking_noise.STALL_S = 0.1
masking_noise.Playback.fill = lambda *_: None
masking = masking_noise.MaskingNoise(level_db=-20.0, fade_s=0.05, seed=1)
try:
    masking.start()
except RigError as error:
    print(error, masking.state)
"""
    result = run(program, HOME=str(tmp_path))
    assert "does not play" in result.stdout, result.stderr
    assert result.stdout.strip().endswith("silent")
