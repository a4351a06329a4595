"""Each protocol played in the real PsychoPy window, by synthetic keys, in both languages."""

from __future__ import annotations

import sys

import pytest

from slipscale.experiments.dataset.rows_from_journal import gather
from slipscale.experiments.dataset.schema import columns
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.participants.psychopy_window import PsychoPyWindow
from slipscale.experiments.running.begin_or_resume import plate_for, run_plan
from slipscale.experiments.session.operator import UnattendedOperator
from slipscale.experiments.session.parts import Setup
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.questions.visual_analogue import VisualAnalogueQuestion
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.steps import Adjust, Ask, Feedback
from slipscale.experiments.study.file import study_text
from slipscale.hardware.clock import VirtualClock
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

pytestmark = [
    pytest.mark.window,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the display is an Xvfb"),
]

GIVES_UP = 400  # frames
# A shipped study, its language, and what makes it short.
PLAYED = {
    "difference_threshold": (
        "fr",
        {
            "intervals = 2": "intervals = 3",
            "tracks = 2": "tracks = 1",
            "most_trials = 30": "most_trials = 2",
            "practice = 3": "practice = 1\nfeedback_s = 0.1",
            "catch_trials = 4": "catch_trials = 0",
        },
    ),
    "detection_threshold": (
        "en",
        {
            "most_trials = 60": "most_trials = 2",
            "practice = 3": "practice = 0",
            "catch_trials = 4": "catch_trials = 1",
        },
    ),
    "constant_stimuli": (
        "fr",
        {
            "comparisons_um_pp = [1.23, 1.26, 1.32, 1.4, 1.6]": "comparisons_um_pp = [1.6]",
            '"forced_choice"': '"yes_no"',
            "repetitions = 20": "repetitions = 2",
            "practice = 3": "practice = 0",
            "catch_trials = 4": "catch_trials = 0",
        },
    ),
    "paired_comparison": (
        "en",
        {
            "[1.0, 1.06, 1.12, 1.18, 1.24]": "[1.0, 1.12, 1.24]",
            "repetitions = 2": "repetitions = 1",
            "practice = 2": "practice = 0",
            "catch_trials = 2": "catch_trials = 0",
        },
    ),
    "matching": (
        "fr",
        {
            "[0.8, 1.2, 1.6]": "[1.2]",
            "repetitions = 3": "repetitions = 1",
            "practice = 2": "practice = 0",
            "catch_trials = 2": "catch_trials = 1",
        },
    ),
    "visual_analogue_scale": (
        "fr",
        {
            "[0.0, 0.5, 1.2, 2.3]": "[0.5, 2.3]",
            "repetitions = 3": "repetitions = 1",
            "practice = 1": "practice = 0",
            "catch_trials = 2": "catch_trials = 1",
            "resolution = 1.0": "resolution = 0.5",
            '"random"': '"middle"',
        },
    ),
    "ratio_to_standard": (
        "en",
        {
            "[0.3, 0.6, 1.8, 2.3]": "[0.6, 2.3]",
            "repetitions = 3": "repetitions = 1",
            "practice = 1": "practice = 0",
            "catch_trials = 2": "catch_trials = 1",
            "standard_every_trials = 1": "standard_every_trials = 2",
        },
    ),
    "magnitude_production": (
        "fr",
        {
            "[7.0, 10.0, 14.0, 20.0]": "[7.0, 14.0]",
            "repetitions = 2": "repetitions = 1",
            "practice = 1": "practice = 0",
            "[0.5, 0.8, 1.2, 1.8]": "[0.5, 1.8]",
            "repetitions = 3": "repetitions = 1",
        },
    ),
}


class Played(PsychoPyWindow):
    """A window that knows what it shows, so that the hand can press what fits."""

    shown = None
    again = 0  # how often the reference was felt again

    def perform(self, step, watch):
        self.shown, self.frames = step, 0
        return super().perform(step, watch)

    def adjust(self, step, turn, watch, *, again=0):
        self.shown, self.frames, self.again = step, 0, again
        return super().adjust(step, turn, watch, again=again)


class Hand(UnattendedOperator):
    """Presses keys of the window, once a screen; polled at every frame."""

    def __init__(self, window, yes):
        super().__init__()
        self.window = window
        self.yes = yes

    def poll(self):
        window = self.window
        if window.shown is not None and not isinstance(window.shown, Feedback):
            window.frames += 1
            assert window.frames < GIVES_UP, f"it does not go on after {window.shown}"
            # What is pressed before a screen's first frame is no answer.
            if window.frames % 4 == 0:
                self.press(window.shown, window.display.handle, first=window.frames == 4)
        return super().poll()

    def press(self, step, handle, *, first):
        if isinstance(step, Adjust) and first:
            from pyglet.window import key

            elsewhere = (key.MOTION_LEFT, key.MOTION_BEGINNING_OF_LINE)  # they turn nothing
            turns = (key.MOTION_UP, key.MOTION_UP, key.MOTION_DOWN, key.MOTION_NEXT_PAGE)
            for motion in (*elsewhere, *turns):
                handle.dispatch_event("on_text_motion", motion)
            handle.dispatch_event("on_mouse_scroll", 0, 0, 0.0, 2.0)
            if step.again and not self.window.again:
                handle.dispatch_event("on_text", "r")
                return
        question = step.question if isinstance(step, Ask) else None
        if isinstance(question, VisualAnalogueQuestion):
            self.mark(handle, first=first)
            return
        if isinstance(question, NumberQuestion):
            handle.dispatch_event("on_text", "2" if first else "\r")
            return
        yes_no = isinstance(question, YesNoQuestion)
        pressed = (self.yes if yes_no else "2") if isinstance(step, Ask) else " "
        handle.dispatch_event("on_text", pressed)

    def mark(self, handle, *, first):
        """Put the mark to 48 by keys alone, to 75 by the mouse alone in every second trial."""
        from pyglet.window import key

        by_mouse = self.window.shown.trial.number % 2 == 0
        if first and by_mouse:
            # The line is 1.1 of the window's 800 pixels long: 75 is 220 to the right of 640.
            handle.dispatch_event("on_mouse_press", 900, 440, 1, 0)
            handle.dispatch_event("on_mouse_drag", 861, 445, -39, 5, 1, 0)
        elif by_mouse:
            handle.dispatch_event("on_mouse_press", 640, 80, 1, 0)
        elif first:
            handle.dispatch_event("on_text", " ")  # no mark is put yet: that is said
            for motion in (key.MOTION_LEFT, key.MOTION_LEFT, key.MOTION_LEFT, key.MOTION_RIGHT):
                handle.dispatch_event("on_text_motion", motion)
        else:
            handle.dispatch_event("on_text", " ")


@pytest.mark.parametrize("name", PLAYED)
def test_a_protocol_is_played_to_its_end_in_the_window(name, display, plan, tmp_path):
    language, changes = PLAYED[name]
    text = study_text(name)
    for long, short in changes.items():
        assert long in text
        text = text.replace(long, short)
    made, clock = plan(text, language=language), VirtualClock()
    path = made.journal_path(tmp_path)
    plate = plate_for(made, "mock", clock)
    window = Played(texts=made.texts(), clock=clock, pilot=True, full_screen=False)
    with Journal.create(path, clock) as journal, plate, window:
        outcome = run_plan(
            made,
            Setup(
                plate=plate,
                participant=window,
                journal=journal,
                clock=clock,
                operator=Hand(window, made.texts()["window.yes_key"]),
            ),
            spec="mock",
        )
    assert outcome == "complete"
    gathered = gather(read_plan(path)[1])
    for protocol, _ in made.tasks():
        rows = [
            {column: described.value(trial) for column, described in columns(protocol).items()}
            for trial in gathered.trials[protocol.task]
        ]
        assert len(rows) == made.planned_trials() if len(made.tasks()) == 1 else rows
        assert {row["response_time_source"] for row in rows} <= {"window", "ptb"}
        answers = {row[PLATE_AMPLITUDE.named(protocol.answer)] for row in rows}
        if name == "matching":
            # Up twice, down once, a page of five down, and two notches of the wheel: two down.
            # The reference is felt again, and they are turned once more.
            assert [row["felt_again"] for row in rows] == [1.0] * 3
            assert all(
                row["matched_um_pp"] == pytest.approx(row["interval2_amplitude_um_pp"] - 0.08)
                for row in rows
            )
        elif protocol.task == "magnitudeproduction":
            for row in rows:
                # Up twice, down once, five down, two up: two down, where the plate can go there.
                aim = max(row["interval2_amplitude_um_pp"] - 2 * 0.05, 0.1)
                assert row["produced_um_pp"] == pytest.approx(aim, abs=0.21)
                assert row["turns"] > 0
        elif name == "visual_analogue_scale":
            assert [row["rating"] for row in rows] == [48.0, 75.0, 48.0]
        else:
            assert answers <= {2.0, "2", "yes"}
