"""Each protocol played in the real PsychoPy window, by synthetic keys, in both languages."""

from __future__ import annotations

import sys

import pytest

from experiments.dataset.rows_from_journal import gather
from experiments.dataset.schema import columns
from experiments.journal.journal import Journal
from experiments.journal.run_record import read_plan
from experiments.participants.psychopy_window import PsychoPyWindow
from experiments.protocols.steps import Adjust, Ask, Feedback, YesNoQuestion
from experiments.running.run import plate_for, run_plan
from experiments.session.operator import UnattendedOperator
from experiments.study.file import study_text
from hardware.clock import SystemClock

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
        },
    ),
}


class Played(PsychoPyWindow):
    """A window that knows what it shows, so that the hand can press what fits."""

    shown = None

    def perform(self, step, watch):
        self.shown, self.frames = step, 0
        return super().perform(step, watch)

    def adjust(self, step, turn, watch):
        self.shown, self.frames = step, 0
        return super().adjust(step, turn, watch)


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
            from pyglet.window import key  # noqa: PLC0415 - needs the display

            for motion in (key.MOTION_UP, key.MOTION_UP, key.MOTION_DOWN, key.MOTION_NEXT_PAGE):
                handle.dispatch_event("on_text_motion", motion)
            handle.dispatch_event("on_mouse_scroll", 0, 0, 0.0, 2.0)
        yes_no = isinstance(step, Ask) and isinstance(step.question, YesNoQuestion)
        pressed = (self.yes if yes_no else "2") if isinstance(step, Ask) else " "
        handle.dispatch_event("on_text", pressed)


@pytest.mark.parametrize("name", PLAYED)
def test_a_protocol_is_played_to_its_end_in_the_window(name, display, plan, tmp_path):
    language, changes = PLAYED[name]
    text = study_text(name)
    for long, short in changes.items():
        assert long in text
        text = text.replace(long, short)
    made, clock = plan(text, language=language), SystemClock()
    path = made.journal_path(tmp_path)
    plate = plate_for(made, "mock", clock)
    window = Played(texts=made.texts(), clock=clock, pilot=True, full_screen=False)
    with Journal.create(path, clock) as journal, plate, window:
        outcome = run_plan(
            made,
            spec="mock",
            plate=plate,
            participant=window,
            journal=journal,
            clock=clock,
            operator=Hand(window, made.texts()["window.yes_key"]),
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
        answers = {row[protocol.answer] for row in rows}
        if name == "matching":
            # Up twice, down once, a page of five down, and two notches of the wheel: two down.
            assert all(
                row["matched_um_pp"] == pytest.approx(row["interval2_amplitude_um_pp"] - 0.04)
                for row in rows
            )
        else:
            assert answers <= {2.0, "2", "yes"}
