"""All that is asked beside the trials, played in the real window: by touch alone, and aloud."""

from __future__ import annotations

import csv
import json
import sys

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.participants.psychopy_window import PsychoPyWindow
from slipscale.experiments.running.begin_or_resume import plate_for, run_plan
from slipscale.experiments.session.operator import Request, UnattendedOperator
from slipscale.experiments.session.parts import Setup
from slipscale.experiments.session.sound.question_sounds import ImaginedSounds
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.questions.comparison import ComparisonQuestion
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.screens.entry import CLEAR, ENTER
from slipscale.experiments.steps.steps import Ask, Feedback
from slipscale.hardware.clock import VirtualClock
from slipscale.stimuli import headphone_sounds

pytestmark = [
    pytest.mark.window,
    pytest.mark.usefixtures("display"),
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the display is an Xvfb"),
]

GIVES_UP = 400  # frames
STUDY = """name = "mine"
title = "Mine"
amplitudes_um_pp = [0.0, 1.2]
informed_consent = true

[keys]
{keys}

[headphone_test]
trials = 1
needed = 1

[[tasks]]
protocol = "magnitude_estimation"
practice = 0
repetitions = 1

[[about_you]]
name = "country"
prompt = {{ en = "Where?", fr = "Où ?" }}
options = ["AL", "AT", "BE", "BG", "HR", "CY", "CZ", "DK", "EE", "FI", "FR", "DE"]

[[questionnaires]]
name = "habits"
description = "Made up"
title = {{ en = "Habits", fr = "Habitudes" }}
instructions = {{ en = "How much do you agree?", fr = "Êtes-vous d'accord ?" }}
options = {{ "1" = {{ en = "no", fr = "non" }}, "2" = {{ en = "yes", fr = "oui" }} }}
items = [{{ name = "h01", prompt = "?" }}, {{ name = "h02", prompt = "?" }}]
"""


class Played(PsychoPyWindow):
    """A window that knows what it shows, so that the hand can touch what fits."""

    step = None

    def perform(self, step, watch):
        self.step, self.frames, self.touched = step, 0, 0
        return super().perform(step, watch)


def presses(step):
    """Return what a person presses at a step, one after the other."""
    question = step.question if isinstance(step, Ask) else None
    if isinstance(question, NumberQuestion):
        return ("4", "2", ENTER)
    if isinstance(question, ComparisonQuestion):
        return (str(step.played.sound.quiet),)
    if isinstance(question, ChoiceQuestion):
        return (f"{CLEAR}12", "2", ENTER) if question.is_long else ("1",)
    return (" ",)


class Hand(UnattendedOperator):
    """Touches what is drawn, or presses keys; types what is said. Polled at every frame."""

    def __init__(self, window, *, touch):
        super().__init__()
        self.window = window
        self.touch = touch
        self.answering = None

    def tell(self, status):
        super().tell(status)
        self.answering = status.answering

    def poll(self):
        if self.answering:
            self.answering = None
            return Request(what="answer", reason="42")
        window = self.window
        if window.step is None or isinstance(window.step, Feedback):
            return super().poll()
        window.frames += 1
        assert window.frames < GIVES_UP, f"it does not go on after {window.step}"
        todo = presses(window.step)
        if window.frames % 4 == 0 and window.touched < len(todo):
            pressed = todo[window.touched]
            if not self.touch:
                for character in pressed:
                    window.display.handle.dispatch_event("on_text", character)
                window.touched += 1
            elif self.touches(pressed):
                window.touched += 1
        return super().poll()

    def touches(self, pressed):
        """Touch the key that presses something, if it is on the screen."""
        display = self.window.display
        areas = [item for item in self.window._shown if isinstance(item, scene.Area)]
        for area in areas:
            if area.presses == pressed:
                x = display.handle.width / 2 + area.x * display._unit
                y = display.handle.height / 2 + area.y * display._unit
                display.handle.dispatch_event("on_mouse_press", round(x), round(y), 1, 0)
                return True
        if pressed.startswith(CLEAR):  # further down the list: its arrow
            self.touches(scene.DOWN)
        elif pressed == "2" and not any(area.presses == "2" for area in areas):
            return True  # a list has no digits to touch
        return False


WAYS = {
    "touch": ("touch = true", "fr", "window"),
    "aloud": ('numbers = "spoken"', "en", "operator"),
}


@pytest.mark.parametrize("way", WAYS)
def test_a_session_is_answered_by_touch_alone_or_aloud(way, plan, tmp_path, monkeypatch):
    keys, language, source = WAYS[way]
    monkeypatch.setattr(headphone_sounds, "TONE_S", 0.1)
    monkeypatch.setattr(headphone_sounds, "GAP_S", 0.0)
    made, clock = plan(STUDY.format(keys=keys), language=language), VirtualClock()
    plate = plate_for(made, "mock", clock)
    window = Played(texts=made.texts(), clock=clock, pilot=True, full_screen=False)
    with Journal.create(made.journal_path(tmp_path), clock) as journal, plate, window:
        outcome = run_plan(
            made,
            Setup(
                plate=plate,
                participant=window,
                journal=journal,
                clock=clock,
                operator=Hand(window, touch=way == "touch"),
                sounds=ImaginedSounds(),
            ),
            spec="mock",
        )
    assert outcome == "complete"
    assert build_dataset(tmp_path) == []
    (path,) = tmp_path.glob("sub-01/beh/*_beh.tsv")
    with path.open() as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    assert {(row["estimate"], row["response_time_source"]) for row in rows} == {("42", source)}
    people = (tmp_path / "participants.tsv").read_text().splitlines()[1].split("\t")
    assert people[:3] == ["sub-01", "yes", "DE"]
    assert (tmp_path / "phenotype" / "habits.tsv").read_text().split()[-2:] == ["1", "1"]
    told = json.loads(path.with_suffix(".json").read_text())["Slipscale"]["headphone_test"]
    assert told["result"] == "passed"
