"""Find installed kinds of questions: the entry points in the group ``slipscale.questions``.

Each entry point is a class derived from `Question`. The functions of another package's kind,
of its screens and of its answer fields are wrapped, so that error messages name the package and the
line.
"""

from __future__ import annotations

import inspect
import reprlib
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import cache
from importlib.metadata import EntryPoint
from types import FunctionType, new_class
from typing import Any, TypeVar

from slipscale.experiments.steps.questions.base import Question
from slipscale.experiments.steps.replies import BACK, Reply, is_answer
from slipscale.experiments.steps.screens.entry import Entry
from slipscale.experiments.steps.screens.screen import Screen
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.plug_ins import OURS, QUESTIONS, called, installed, package_of

T = TypeVar("T", Question, Screen, Entry)
# Types that the functions of a kind, its screens and its answer fields must return.
RETURNED: Mapping[str, type] = {
    "fits": bool, "entry": Entry, "screen": Screen, "scene": tuple, "body": tuple, "listed": tuple,
}  # fmt: skip


def kind_names() -> list[str]:
    """Return the names of all installed kinds of questions, sorted."""
    return list(installed(QUESTIONS))


@cache
def load_kind(name: str) -> type[Question]:
    """Return the installed kind of question with a given name.

    Raises
    ------
    KeyError
        If no kind of question with this name is installed.
    UserError
        If the entry point cannot be imported or is not a class derived from `Question`, or if the
        class lacks a required method.
    """
    point = installed(QUESTIONS)[name]
    named = _named(point)
    kind: object = called(point, point.load, named)
    if not (isinstance(kind, type) and issubclass(kind, Question)):
        raise UserError(
            "{named}: its entry point is {kind}, expected a class derived from Question",
            named=named,
            kind=reprlib.repr(kind),
        )
    if lacking := sorted({*kind.__abstractmethods__} | ({"EXPECTED"} - {*dir(kind)})):
        raise UserError(
            "{named}: {name} lacks {lacking}; define everything that is required",
            named=named,
            name=kind.__name__,
            lacking=", ".join(lacking),
        )
    return kind


def watched(question: Question, asker: str) -> Question:
    """Return a question whose functions report their errors in a sentence.

    Parameters
    ----------
    question : Question
    asker : str
        Who asks the question, for messages.

    Raises
    ------
    UserError
        If no package registers the question's kind.
    """
    kind = type(question)
    package = kind.__module__.partition(".")[0]
    for name, point in installed(QUESTIONS).items():
        if point.module.partition(".")[0] == package and load_kind(name) is kind:
            if package_of(point) == OURS:
                return question
            made = {each.name: getattr(question, each.name) for each in fields(question)}
            for own, value in made.items():
                if not _plain(value):
                    raise UserError(
                        "{named}: the field '{own}' is {value}, which a journal cannot hold; "
                        "expected texts, numbers, true or false, and tuples or tables of these",
                        named=_named(point),
                        own=own,
                        value=repr(value),
                    )
            return _watched_kind(kind, point)(**made)
    raise UserError(
        "{asker}: {kind} is not an installed kind of question; expected an entry "
        "point in the group {group}",
        asker=asker,
        kind=kind.__name__,
        group=QUESTIONS,
    )


def _plain(value: object) -> bool:
    if isinstance(value, Mapping):
        return all(isinstance(key, str) and _plain(each) for key, each in value.items())
    if isinstance(value, tuple | list):
        return all(map(_plain, value))
    return value is None or is_answer(value)


def _named(point: EntryPoint) -> str:
    return Message(
        "kind of question '{name}' of the package {package}",
        name=point.name,
        package=package_of(point),
    )


@cache
def _watched_kind(kind: type[Question], point: EntryPoint) -> type[Question]:
    return _reporting(kind, Question, point, _own_parts_watched(point))


def _own_parts_watched(point: EntryPoint) -> Callable[[Any, object], None]:
    """Return a function that also watches the screens and answer fields that a kind returns."""

    def check(question: Question, found: object) -> None:
        def fits(_part: object, outcome: object) -> None:
            if not isinstance(outcome, Reply) or outcome.timed_out or outcome.value == BACK:
                return
            if not (is_answer(outcome.value) and question.fits(outcome.value)):
                raise UserError(
                    "{named} accepted {value}, expected {expected}",
                    named=_named(point),
                    value=repr(outcome.value),
                    expected=question.EXPECTED,
                )

        if isinstance(found, Screen):
            found.__class__ = _reporting(type(found), Screen, point, fits)
        elif isinstance(found, Entry):
            found.__class__ = _reporting(type(found), Entry, point, fits)

    return check


def _reporting(
    kind: type[T], base: type, point: EntryPoint, check: Callable[[Any, object], None]
) -> type[T]:
    """Derive a class that watches the functions of ``base`` and checks their results."""

    def reporting(function: Callable[..., Any]) -> Callable[..., Any]:
        def call(self: T, *arguments: Any, **options: Any) -> Any:
            found = called(point, lambda: function(self, *arguments, **options), _named(point))
            if not isinstance(found, RETURNED.get(function.__name__, object)):
                raise UserError(
                    "{named}: {function} returned {found}, expected a {expected}",
                    named=_named(point),
                    function=function.__name__,
                    found=repr(found),
                    expected=RETURNED[function.__name__].__name__,
                )
            check(self, found)
            return found

        return call

    members: dict[str, Any] = {"__slots__": (), "__module__": kind.__module__}
    for name in (name for name in vars(base) if not name.startswith("_")):
        own: Any = inspect.getattr_static(kind, name)
        if isinstance(own, property) and own.fget:
            members[name] = property(reporting(own.fget))
        elif isinstance(own, FunctionType):
            members[name] = reporting(own)
    derived: type[T] = new_class(kind.__name__, (kind,), exec_body=lambda own: own.update(members))
    return derived
