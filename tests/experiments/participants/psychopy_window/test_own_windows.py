"""Windows of their own. No other window may be open: the last one that opens has the keyboard."""

from __future__ import annotations

import sys
from dataclasses import replace

import pytest
from PIL import Image

from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.psychopy_window import PsychoPyWindow
from slipscale.experiments.participants.psychopy_window.display import Display
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.steps import Instruct
from slipscale.experiments.steps.trial import Trial
from slipscale.hardware.clock import SystemClock

pytestmark = [
    pytest.mark.window,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="under Xvfb"),
]


def test_light_screens_are_light_in_a_window(display, tmp_path):
    picture = tmp_path / "screen.png"
    with Display(
        SystemClock(), full_screen=False, screen=0, size=(640, 400), theme="light"
    ) as shown:
        shown.draw((scene.Text(content="M", y=0.0, size=0.5),))
        shown.save(picture)
        shown.flip()
    image = Image.open(picture).convert("RGB")
    assert image.getpixel((2, 2)) == scene.COLOURS["light"]["ground"]
    assert min(sum(pixel) for pixel in image.getdata()) < 200


def test_a_progress_line_shows_the_finished_trials_and_is_gone_between_tasks(display, monkeypatch):
    with PsychoPyWindow(
        texts=load_texts("en"),
        clock=SystemClock(),
        pilot=False,
        full_screen=False,
        progress_line=True,
    ) as window:
        drawn = []
        draw = window.display.draw
        monkeypatch.setattr(
            window.display, "draw", lambda shown: drawn.append(shown) or draw(shown)
        )
        step = Instruct(text="Stroke.", trial=Trial(task="t", number=5, total=8))
        for each in (step, replace(step, trial=None)):
            frames = iter(range(3))

            def watch(frames=frames):
                if next(frames, None) is None:
                    raise TimeoutError

            with pytest.raises(TimeoutError):
                window.perform(each, watch)
    lines = [scene.progress_line(0.5), scene.progress_line(1.0)]
    assert lines[0][1].width == pytest.approx(lines[1][1].width / 2)
    assert set(lines[0]) <= set(drawn[0])
    assert not set(lines[0]) & set(drawn[-1])
