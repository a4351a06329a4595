"""Kinds of questions: shared code names none of them, and a broken one is told in a sentence."""

import ast
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from types import SimpleNamespace

import pytest

from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.experiments.steps.questions import registry
from slipscale.experiments.steps.questions.base import Question
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.questions.comparison import ComparisonQuestion
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.questions.pointing import PointingQuestion
from slipscale.experiments.steps.questions.registry import kind_names, load_kind, watched
from slipscale.experiments.steps.questions.text import TextQuestion
from slipscale.experiments.steps.questions.visual_analogue import VisualAnalogueQuestion
from slipscale.experiments.steps.questions.whole_number import WholeNumberQuestion
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.screens.entry import TypedEntry
from slipscale.experiments.steps.steps import Ask
from slipscale.faults import UserError

ROOT = Path(__file__).parents[4]
PRODUCT = ("analysis", "experiments", "faults", "figure_style", "hardware", "stimuli", "src")
KINDS = "experiments/steps/questions/"
# Code that asks questions, and the public names. All other code calls methods of `Question`.
ASKS = (
    "experiments/protocols/",
    "experiments/protocol_parts/building_blocks/forced_choice.py",
    "experiments/study/headphone_test.py",
    "experiments/study/person_questions.py",
    "experiments/study/run_plan.py",
    "src/slipscale/protocol.py",
)
TEXTS = load_texts("en")
OURS = {
    load_kind(point.name)
    for point in entry_points(group="slipscale.questions")
    if point.value.startswith("slipscale.")
}


EXAMPLES = {
    type(question): question
    for question in (
        NumberQuestion(prompt="How slippery?"),
        YesNoQuestion(prompt="A difference?"),
        TextQuestion(prompt="What changed?"),
        ChoiceQuestion(prompt="Which hand?", options=(("l", "left"), ("r", "right"))),
        WholeNumberQuestion(prompt="Age?", minimum=18, maximum=99),
        ComparisonQuestion(prompt="Which?", options=("the first", "the second")),
        VisualAnalogueQuestion(
            prompt="Where?",
            left="rough",
            right="smooth",
            resolution=1.0,
            key_step=1.0,
            start=50.0,
            start_shown=True,
        ),
        PointingQuestion(
            prompt="Point.",
            start_mm=(-9.0, 0.0),
            target_mm=(9.0, 0.0),
            width_mm=3.0,
            bars=True,
            screen_height_mm=300.0,
        ),
    )
}


class AnyPerson:
    """A simulated person who feels two surfaces."""

    pace, impressions = 1.0, (40.0, 60.0)

    def stream(self, *purpose):
        return Stream("any", *purpose)

    def pick(self, strengths):
        return strengths.index(max(strengths))

    def notices(self):
        return True

    def estimate(self):
        return 12.5

    def rating(self, _start):
        return 62.4

    def verbal_report(self):
        return "less"


@pytest.mark.parametrize("kind", sorted(OURS, key=str), ids=lambda kind: kind.__name__)
def test_every_kind_has_a_screen_a_rehearsed_and_a_simulated_answer(kind):
    question = EXAMPLES[kind]
    scene = screen_for(Ask(name="answer", question=question), TEXTS).scene(0.0)
    assert question.prompt in str(scene)
    first, last = question.rehearsed(0.0), question.rehearsed(0.999)
    assert first != last or kind is TextQuestion
    for value in (first, last, question.simulated(AnyPerson(), "answer")):
        assert question.fits(value)
    assert not question.fits(None)


@pytest.mark.parametrize("seeks, value", [("most", 2.0), ("least", 1.0), ("odd", 1.0)])
def test_a_comparison_is_answered_by_what_was_felt(seeks, value):
    question = ComparisonQuestion(prompt="Which?", options=("first", "second"), seeks=seeks)
    assert question.simulated(AnyPerson(), "answer") == value


def naming(source, names):
    """Return which of the names a module imports or uses."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Name | ast.Attribute):
            found.add(node.id if isinstance(node, ast.Name) else node.attr)
        elif isinstance(node, ast.ImportFrom):
            found |= {each.name for each in node.names}
    return found & names


def test_only_its_module_and_those_who_ask_it_name_a_kind():
    modules = {kind.__name__: f"{kind.__module__.rpartition('.')[2]}.py" for kind in OURS}
    named = set()
    for folder in PRODUCT:
        for path in (ROOT / folder).rglob("*.py"):
            where = path.relative_to(ROOT).as_posix()
            if not where.startswith(ASKS):
                found = naming(path.read_text(encoding="utf-8"), set(modules))
                named |= {(where, kind) for kind in found if where != KINDS + modules[kind]}
    assert named == set()


def test_a_kind_that_is_named_is_found():
    source = "from slipscale.protocol import TextQuestion\nisinstance(step, q.NumberQuestion)"
    names = {"TextQuestion", "NumberQuestion", "YesNoQuestion"}
    assert naming(source, names) == {"TextQuestion", "NumberQuestion"}


def test_every_class_derived_from_question_is_registered():
    folder = ROOT / KINDS
    bases = {
        node.name
        for path in folder.glob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef) and "Question" in map(ast.unparse, node.bases)
    }
    assert bases == {kind.__name__ for kind in OURS}
    assert len(OURS) == 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Grip(Question):
    """How much grip, in whole numbers."""

    EXPECTED = "a whole number"

    def fits(self, value):
        return isinstance(value, int)

    def rehearsed(self, place, /):
        return round(place)

    def entry(self, _texts, /):
        return TypedEntry(lambda line: Reply(value=line if line == "wrong" else int(line)))

    def body(self, _entry, _texts, /):
        raise KeyError("lost")


class Unfinished(Question):
    """A kind without its methods."""


@pytest.fixture
def grip(monkeypatch):
    """Return a function that installs a kind of question of the name grip, in a package ourlab."""
    known = dict(registry.installed(registry.QUESTIONS))

    def install(kind):
        class Point:
            name, module = "grip", __name__
            dist = SimpleNamespace(name="ourlab")
            load = staticmethod(lambda: kind)

        monkeypatch.setattr(registry, "installed", lambda _: {**known, "grip": Point()})
        load_kind.cache_clear()

    yield install
    load_kind.cache_clear()


@pytest.mark.parametrize(
    "kind, said",
    [
        (Unfinished, "'grip' of the package ourlab: Unfinished lacks EXPECTED, fits, rehearsed"),
        (int, "entry point is <class 'int'>, expected a class derived from Question"),
        (Grip(prompt="?"), "expected a class derived from Question"),
    ],
)
def test_what_is_no_kind_of_question_is_refused(grip, kind, said):
    grip(kind)
    with pytest.raises(UserError, match=said):
        load_kind("grip")


def test_an_error_of_a_kind_names_the_package_and_the_line(grip):
    grip(Grip)
    question = watched(Grip(prompt="Grip?"), "protocol 'grip'")
    assert isinstance(question, Grip)
    assert question.fits(1)
    screen = question.screen(TEXTS, None, False)
    with pytest.raises(UserError, match=r"'grip' of the package ourlab raised KeyError.*line \d+"):
        screen.scene(0.0)
    entry = question.entry(TEXTS)
    with pytest.raises(UserError, match="raised ValueError: invalid literal"):
        [entry.press(each) for each in "x\r"]


class Wrong(Grip):
    """Returns what nobody expects."""

    def fits(self, _value):
        return "yes"

    def body(self, _entry, _texts, /):
        return "a picture"

    def screen(self, texts, time_limit_s, back, /):
        return Grip.screen(self, texts, time_limit_s, back) if back else None


@pytest.mark.parametrize(
    "use, said",
    [
        (lambda q: q.fits(1), "fits returned 'yes', expected a bool"),
        (lambda q: q.screen(TEXTS, None, False), "screen returned None, expected a Screen"),
        (lambda q: q.screen(TEXTS, None, True).scene(0.0), "body returned 'a picture', exp"),
    ],
)
def test_a_result_of_another_type_is_refused(grip, use, said):
    grip(Wrong)
    with pytest.raises(UserError, match=f"'grip' of the package ourlab: {said}"):
        use(watched(Wrong(prompt="Grip?"), "protocol 'grip'"))


@pytest.mark.parametrize("part", ["entry", "screen"])
def test_an_answer_that_does_not_fit_is_no_answer(grip, part):
    grip(Grip)
    question = watched(Grip(prompt="Grip?"), "protocol 'grip'")
    made = question.entry(TEXTS) if part == "entry" else question.screen(TEXTS, None, False)
    elapsed_s = () if part == "entry" else (1.0,)
    with pytest.raises(UserError, match="accepted 'wrong', expected a whole number"):
        [made.press(each, *elapsed_s) for each in "wrong\r"]


def test_a_kind_that_no_package_registers_cannot_be_asked():
    with pytest.raises(UserError, match="protocol 'grip': Grip is not an installed kind"):
        watched(Grip(prompt="Grip?"), "protocol 'grip'")


def test_a_shipped_kind_is_asked_as_it_is():
    question = NumberQuestion(prompt="Grip?")
    assert watched(question, "protocol 'grip'") is question
    assert "number" in kind_names()
