"""docs/extending/adding-a-question.md: its example is built, installed and used."""

import csv
import json
import sys
from importlib import import_module

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.psychopy_window import PsychoPyWindow
from slipscale.experiments.participants.psychopy_window.layout import faults
from slipscale.experiments.running.begin_or_resume import plate_for, run_plan
from slipscale.experiments.session.operator import Request, UnattendedOperator
from slipscale.experiments.session.parts import Setup
from slipscale.experiments.session.sound.question_sounds import ImaginedSounds
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.screens.entry import ENTER
from slipscale.experiments.steps.steps import Ask
from slipscale.faults import plug_ins
from slipscale.hardware.clock import VirtualClock
from tests.support.example_package import COMMANDS, EXTENDING, ExamplePackage, tables

STUDY = (EXTENDING / "affect" / "affect.toml").read_text(encoding="utf-8")
SHORT = STUDY.replace("repetitions = 8", "repetitions = 2")
# A pilot without its analysis, which takes as long as all else.
UNDISTURBED = """
from pathlib import Path
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
plans = pilot_plans("affect.toml", participants=1, seed=None, language=None)
run_pilot(Path("whole"), plans, tell=print)
"""
TEXTS = load_texts("en")


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    return ExamplePackage("affect", tmp_path_factory.mktemp("laboratory"))


@pytest.fixture(scope="module")
def affect(package):
    """Install the package in this process; return its module of the question."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(package.site)
        plug_ins.installed.cache_clear()
        yield import_module("affect_grid")
        for name in ("affect_grid", "feelings", "mean_feelings"):
            sys.modules.pop(name, None)
    plug_ins.installed.cache_clear()


@pytest.fixture
def question(affect):
    words = {word: word for word in ("left", "right", "bottom", "top", "how")}
    return affect.AffectGrid(prompt="How does it feel?", **words)


@pytest.mark.parametrize(
    "valence, arousal, number", [(1, 1, 1), (9, 1, 9), (1, 2, 10), (7, 5, 43), (9, 9, 81)]
)
def test_a_cell_has_a_number_that_gives_back_valence_and_arousal(affect, valence, arousal, number):
    assert affect.number_of(valence, arousal) == number
    assert affect.parts_of(number) == (valence, arousal)


@pytest.mark.parametrize("value", [0, 82, 1.5, "5", True, None])
def test_other_values_are_no_cell(question, value):
    assert not question.fits(value)


@pytest.mark.parametrize("typed", ["75", "7", "7 10", "0 5", "a b", "7 5 1"])
def test_an_operator_types_two_numbers_from_1_to_9(question, typed):
    entry = question.entry(TEXTS)
    assert [entry.press(each) for each in "7 5\r"][-1].value == 43
    assert [entry.press(each) for each in f"{typed}\r"][-1].reason == "window.out_of_bounds"


def test_the_keys_start_in_the_middle_and_stop_at_the_edge(question):
    screen = question.screen(TEXTS, None, False)
    screen.move(1)
    screen.turn(-1)
    assert screen.typed == "6 4"
    screen.turn(1_000_000)
    assert screen.press(ENTER, 1.0).value == 78


def test_an_interrupted_choice_is_restored(question):
    screen = question.screen(TEXTS, None, False)
    screen.offer("7 5")
    assert screen.press(ENTER, 1.0).value == 43


def test_without_a_choice_nothing_is_submitted_and_the_instruction_lights_up(question):
    screen = question.screen(TEXTS, 2.0, False)
    assert screen.press(ENTER, 1.0) is None
    (how,) = (item for item in screen.scene(1.0) if getattr(item, "content", "") == "how")
    assert how.colour == "accent"
    screen.move(1)
    assert screen.press(ENTER, 2.0) is None  # the time is over
    assert screen.expire(2.0).timed_out
    assert list(faults(screen.scene(1.0))) == []


class Hand(UnattendedOperator):
    """Chooses valence 7 and arousal 5 on each grid; continues elsewhere. Polled at every frame."""

    def __init__(self, window, way):
        super().__init__()
        self.window, self.way, self.frames, self.answering = window, way, 0, None

    def tell(self, status):
        super().tell(status)
        self.answering = status.answering

    def poll(self):
        if self.answering:
            self.answering = None
            return Request(what="answer", reason="7 5")
        self.frames += 1
        assert self.frames < 2000
        if self.window.step and self.frames % 4 == 0:
            on_grid = isinstance(self.window.step, Ask)
            for name, *arguments in self.inputs() if on_grid else [("on_text", " ")]:
                self.window.display.handle.dispatch_event(name, *arguments)
            self.window.step = None
        return super().poll()

    def inputs(self):
        from pyglet.window import key

        if self.way == "keys":
            return [*2 * [("on_text_motion", key.MOTION_RIGHT)], ("on_text", " ")]
        (button,) = (item for item in self.window._shown if isinstance(item, scene.Area))
        return [self.press(2 * 0.052, 0.0), self.press(button.x, button.y)]

    def press(self, x, y):
        display = self.window.display
        middle_x, middle_y = display.handle.width / 2, display.handle.height / 2
        place = (round(middle_x + x * display._unit), round(middle_y + y * display._unit))
        return "on_mouse_press", *place, 1, 0


class Played(PsychoPyWindow):
    """A window that knows what it shows until the hand has answered."""

    step = None

    def _show_first(self, screen, watch):
        onset_s = super()._show_first(screen, watch)
        self.step = self.performed
        return onset_s

    def perform(self, step, watch):
        self.performed, self.step = step, None
        return super().perform(step, watch)


WAYS = {"keys": "", "mouse": "", "touch": "touch = true", "aloud": 'numbers = "spoken"'}


@pytest.mark.window
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the display is an Xvfb")
@pytest.mark.parametrize("way", WAYS)
def test_the_grid_is_answered_in_a_window(way, affect, plan, tmp_path, display):
    made, clock = plan(f"{SHORT}\n[keys]\n{WAYS[way]}\n", language="en"), VirtualClock()
    plate = plate_for(made, "mock", clock)
    window = Played(texts=made.texts(), clock=clock, pilot=True, full_screen=False)
    with Journal.create(made.journal_path(tmp_path), clock) as journal, plate, window:
        setup = Setup(
            plate=plate,
            participant=window,
            journal=journal,
            clock=clock,
            operator=Hand(window, way),
            sounds=ImaginedSounds(),
        )
        assert run_plan(made, setup, spec="mock") == "complete"
    assert build_dataset(tmp_path) == []
    (path,) = tmp_path.glob("sub-01/beh/*_beh.tsv")
    with path.open() as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    assert len(rows) == 6
    assert {(row["feeling"], row["valence"], row["arousal"]) for row in rows} == {("43", "7", "5")}
    source = "operator" if way == "aloud" else "window"
    assert {row["response_time_source"] for row in rows} == {source}


def test_a_killed_pilot_is_resumed_with_the_same_tables_and_analysed(package):
    package.run(COMMANDS, "study validate affect.toml")
    package.run(UNDISTURBED)
    whole = tables(package.folder / "whole")
    journal = package.folder / "killed/sourcedata/sub-01/sub-01_run-01_journal.jsonl"
    package.kill_pilot(journal, "affect.toml", "--participants", "1", "--out", "killed")
    said = package.run(COMMANDS, f"resume {journal}", "data build killed", "analyse killed")
    assert tables(package.folder / "killed") == whole
    lines = whole["sub-01_task-feelings_run-01_beh.tsv"].decode().splitlines()
    rows = list(csv.DictReader(lines, delimiter="\t"))
    assert "Valence and arousal: The mean valence was" in said
    out = package.folder / "killed/derivatives/slipscale"
    numbers = json.loads((out / "inference.json").read_text())["own_mean_feelings"]["numbers"]
    for part in ("valence", "arousal"):
        mean = sum(float(row[part]) for row in rows) / len(rows)
        assert numbers[part] == pytest.approx(mean)
    sidecar = json.loads((package.folder / "killed/task-feelings_beh.json").read_text())
    assert sidecar["valence"]["Description"] == "Valence: 1 (unpleasant) to 9 (pleasant)"
    software = json.loads((out / "results.json").read_text())["software"]
    assert software["slipscale-affect"] == "1.0"
