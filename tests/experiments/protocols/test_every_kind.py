"""A new kind of step or question is handled everywhere, and every key of a study is read."""

import ast
from importlib.metadata import entry_points
from pathlib import Path
from typing import get_args

import pytest
from pydantic import BaseModel

from slipscale.experiments.journal.record_shapes import STEPS
from slipscale.experiments.journal.serialisation import ANSWERS
from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.psychopy_window.screens import SCREENS, screen_for
from slipscale.experiments.session.session import Session
from slipscale.experiments.steps.questions.base import Question
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.questions.comparison import ComparisonQuestion
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.questions.pointing import PointingQuestion
from slipscale.experiments.steps.questions.text import TextQuestion
from slipscale.experiments.steps.questions.visual_analogue import VisualAnalogueQuestion
from slipscale.experiments.steps.questions.whole_number import WholeNumberQuestion
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.replies import Answer
from slipscale.experiments.steps.steps import Adjust, Ask, ParticipantStep, Step
from slipscale.experiments.study.model import Study
from slipscale.stimuli.parameters import declared
from slipscale.stimuli.textures import KINDS

ROOT = Path(__file__).parents[3]
PRODUCT = ("analysis", "experiments", "hardware", "stimuli")
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


# With slots, each class exists twice; the second one is used.
KINDS_OF_QUESTION = {kind.__name__: kind for kind in Question.__subclasses__()}.values()


@pytest.mark.parametrize("kind", KINDS_OF_QUESTION, ids=lambda kind: kind.__name__)
def test_every_kind_of_question_has_a_screen_and_a_rehearsed_answer(kind):
    question = EXAMPLES[kind]
    scene = screen_for(Ask(name="answer", question=question), load_texts("en")).scene(0.0)
    assert question.prompt in str(scene)
    first, last = question.rehearsed(0.0), question.rehearsed(0.999)
    assert first != last or kind is TextQuestion
    assert question.fits(first)
    assert question.fits(last)
    assert not question.fits(None)


def test_every_kind_of_step_has_a_record_a_performer_and_a_screen(laboratory, monkeypatch):
    kinds, sessions = set(get_args(Step)), []
    monkeypatch.setattr(Session, "run", lambda self: sessions.append(self) or "complete")
    laboratory.run()
    assert {kind.__name__ for kind in kinds} == set(STEPS)
    assert set(SCREENS) == {*get_args(ParticipantStep), Adjust}
    assert [set(session._actions) for session in sessions] == [kinds]


def test_every_kind_of_answer_reads_back_from_a_journal():
    kinds = {kind.__name__ for kind in get_args(Answer) if kind is not type(None)}
    assert set(ANSWERS) == kinds | {"Adjusted"}  # a kind of reply
    assert {answer.__name__ for _, answer in STEPS.values() if answer} == set(ANSWERS)


def models(annotation):
    """Yield the models that a field's type names."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from models(part)


def keys_of(model, found):
    """Gather the keys of a model and of the models in it."""
    if model not in found:
        found[model] = set(model.model_fields)
        for field in model.model_fields.values():
            for inner in models(field.annotation):
                keys_of(inner, found)
    return found


class Reads(ast.NodeVisitor):
    """Names that are read as attributes or keys; checks of a model's own are no use of a key."""

    def __init__(self):
        self.names = set()

    def visit_FunctionDef(self, node):
        checks = any("validator" in ast.unparse(each) for each in node.decorator_list)
        if not (checks or node.name.startswith("valid_")):
            self.generic_visit(node)

    def visit_Attribute(self, node):
        if isinstance(node.ctx, ast.Load):
            self.names.add(node.attr)
        self.generic_visit(node)

    def visit_Assign(self, node):
        if ast.unparse(node.targets[0]) == "KEY" and isinstance(node.value, ast.Constant):
            self.names.add(node.value.value)  # read from the file before the model is made
        self.generic_visit(node)


@pytest.fixture(scope="module")
def read():
    """Return every name that the product reads."""
    reads = Reads()
    for folder in PRODUCT:
        for path in (ROOT / folder).rglob("*.py"):
            reads.visit(ast.parse(path.read_text(encoding="utf-8")))
    # Parameters of stimuli are read by their declarations.
    return reads.names.union(*map(declared, KINDS.values()))


def test_every_key_of_a_study_is_read(read):
    found = keys_of(Study, {})
    for point in entry_points(group="slipscale.protocols"):
        if point.value.startswith("slipscale."):
            keys_of(point.load().options, found)
    assert len(found) > 20
    unread = {f"{model.__name__}.{key}" for model, keys in found.items() for key in keys - read}
    assert unread == set()


def test_a_key_that_nothing_reads_is_found(read):
    class Made(BaseModel):
        nobody_reads_this_level: float = 0.0

    class Outer(BaseModel):
        parts: tuple[Made, ...] | None = None

    keys = keys_of(Outer, {})
    assert keys[Made] - read == {"nobody_reads_this_level"}
