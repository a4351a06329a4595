"""A new kind of step is handled everywhere, and every key of a study is read."""

import ast
from importlib.metadata import entry_points
from pathlib import Path
from typing import get_args

import pytest
from pydantic import BaseModel

from slipscale.experiments.journal.record_shapes import STEPS
from slipscale.experiments.journal.serialisation import ANSWERS
from slipscale.experiments.participants.psychopy_window.screens import SCREENS
from slipscale.experiments.session.session import Session
from slipscale.experiments.steps.replies import Answer
from slipscale.experiments.steps.steps import Adjust, ParticipantStep, Step
from slipscale.experiments.study.model import Study
from slipscale.stimuli.parameters import declared
from slipscale.stimuli.textures import KINDS

ROOT = Path(__file__).parents[3]
PRODUCT = ("analysis", "experiments", "hardware", "stimuli")


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
