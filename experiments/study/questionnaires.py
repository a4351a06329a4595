"""Questionnaires, whose items usually share answer options and are recorded by item code.

An item is a question about the participant. Unlike answers to `about_you`, answers to items are
stored in one table per questionnaire (BIDS folder ``phenotype``).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import Annotated, Literal

from pydantic import Field, field_validator

from slipscale.experiments.languages.texts import FEWEST_ANSWERS, MOST_OPTIONS
from slipscale.experiments.protocol_parts.base import Label, Words
from slipscale.experiments.protocol_parts.simulated_answers import SimulatedAnswer, as_asked
from slipscale.experiments.steps.questions.base import CONSENT
from slipscale.experiments.steps.steps import Ask, Instruct, Steps
from slipscale.experiments.study.person_questions import TAKEN, PersonQuestion, Translated, distinct
from slipscale.faults import UserError
from slipscale.faults.frozen_table import FrozenTable, setting
from slipscale.faults.message import Message
from slipscale.faults.toml_lines import Place
from slipscale.faults.validation import Fault

MOST_ITEMS = 200
# The columns that identify a row in a questionnaire's table, in addition to the participant.
ROW = ("session_id", "run")

Answers = (
    Annotated[tuple[Words, ...], Field(min_length=FEWEST_ANSWERS, max_length=MOST_OPTIONS)]
    | Annotated[dict[Words, Translated], Field(min_length=FEWEST_ANSWERS, max_length=MOST_OPTIONS)]
)


class Item(FrozenTable):
    """An item of a questionnaire."""

    name: Label = Field(
        description=(
            "Code of the item, which is also the name of its column in the questionnaire's table."
        )
    )
    prompt: Words | Translated = Field(
        description="Text of the item, or a table with the text in each language."
    )
    options: Answers | None = setting(
        None, "Possible answers to this item, if they differ from the answers of the questionnaire."
    )

    @field_validator("name")
    @classmethod
    def _free(cls, value: str) -> str:
        if value in (*TAKEN, CONSENT, *ROW):
            raise ValueError("expected another code: a column with this name already exists")
        return value

    _distinct = field_validator("options")(distinct)


class Questionnaire(FrozenTable):
    """A questionnaire, whose items are asked one at a time in the given order."""

    name: Label = Field(description="Name of the questionnaire's table, phenotype/<name>.tsv.")
    description: Words = Field(
        description="Description of the questionnaire for readers of the data set: its purpose "
        "and source."
    )
    title: Words | Translated | None = setting(None, "Title shown above the instructions.")
    instructions: Words | Translated | None = setting(
        None, "Text shown before the first item; default: none."
    )
    options: Answers = Field(
        description="Possible answers, as in `about_you`. A table gives the wording in each "
        "language for each code that is stored in the data."
    )
    when: Literal["before", "after"] = setting(
        "before", "Whether the questionnaire is presented before or after the tasks."
    )
    items: Annotated[tuple[Item, ...], Field(min_length=1, max_length=MOST_ITEMS)] = Field(
        description="Items in the order of presentation."
    )

    _distinct = field_validator("options")(distinct)

    def questions(self) -> list[PersonQuestion]:
        """Return the items as questions about the participant."""
        return [
            PersonQuestion(name=item.name, prompt=item.prompt, options=item.options or self.options)
            for item in self.items
        ]

    def asks(self, language: str, texts: Mapping[str, str]) -> list[Ask]:
        """Return the steps that present each item in a language.

        Raises
        ------
        UserError
            If an item, the title or the instructions are not available in the language.
        """
        for words in (self.title, self.instructions):
            if isinstance(words, dict) and language not in words:
                raise UserError(
                    "questionnaires: '{name}' lacks a title or instructions in '{language}'",
                    name=self.name,
                    language=language,
                )
        return [
            replace(question.ask(language, texts), task=self.name) for question in self.questions()
        ]

    def steps(self, language: str, texts: Mapping[str, str]) -> Steps:
        """Yield the instructions, then the items."""
        if self.instructions is not None:
            title = "" if self.title is None else _words(self.title, language)
            yield Instruct(title=title, text=_words(self.instructions, language))
        for ask in self.asks(language, texts):  # noqa: UP028  a list takes no answers
            yield ask

    def simulated(self) -> dict[tuple[str, str], SimulatedAnswer]:
        """Return functions with which pilots answer each item at random."""
        return {(self.name, item.name): as_asked for item in self.items}

    def levels(self, language: str) -> dict[str, tuple[str, dict[str, str]]]:
        """Return the wording of each item and of its answers, for the table's sidecar."""
        return {
            item.name: (_words(item.prompt, language), question.levels(language))
            for item, question in zip(self.items, self.questions(), strict=True)
        }


def _words(given: str | dict[str, str], language: str) -> str:
    """Return the text in a language or, if it is missing, in another language."""
    if isinstance(given, str):
        return given
    return given.get(language, next(iter(given.values())))


def unusable(
    questionnaires: tuple[Questionnaire, ...],
    language: str,
    known: Collection[str],
    taken: Collection[str],
) -> Iterator[Fault]:
    """Yield the location and message of each ambiguous name, missing text and unknown language.

    Parameters
    ----------
    questionnaires : tuple of Questionnaire
    language : str
        The study's language.
    known : collection of str
        All available languages.
    taken : collection of str
        Names that tasks and questions about the participant already have.
    """
    names = set(taken)
    for number, each in enumerate(questionnaires):
        place = ("questionnaires", number)
        if each.name in names:
            yield (*place, "name"), {"msg": Message("there is already a '{name}'", name=each.name)}
        names.add(each.name)
        for key, words in (("title", each.title), ("instructions", each.instructions)):
            yield from (
                ((*place, key), {"msg": words_fault})
                for words_fault in _unread(words, language, known)
            )
        unknown: set[tuple[Place, str]] = set()
        for index, question in enumerate(each.questions()):
            if question.name in names:
                words_fault = Message("there is already a '{name}'", name=question.name)
                yield (*place, "items", index, "name"), {"msg": words_fault}
            names.add(question.name)
            own = each.items[index].options is not None
            for key, spoken in question.languages():
                if spoken not in known:
                    among = Message(
                        "expected languages among {languages}", languages=", ".join(known)
                    )
                    unknown.add((_place(place, index, key, own=own), among))
            for found, sentence in question.faults(language):
                where = _place(place, index, str(found[0]), own=own)
                shared = where == (*place, "options")  # reported once, not per item
                unknown.add(
                    (where, sentence.replace(question.name, each.name) if shared else sentence)
                )
        yield from (
            (where, {"msg": words_fault}) for where, words_fault in sorted(unknown, key=str)
        )


def _place(
    place: tuple[str | int, ...], index: int, key: str, *, own: bool
) -> tuple[str | int, ...]:
    """Return the location of an error: the item or, for shared options, the questionnaire."""
    if key == "options" and not own:
        return (*place, "options")
    return (*place, "items", index, key)


def _unread(
    words: str | dict[str, str] | None, language: str, known: Collection[str]
) -> Iterator[str]:
    if isinstance(words, dict):
        if language not in words:
            yield Message("expected words in '{language}'", language=language)
        if not set(words) <= set(known):
            yield Message("expected languages among {languages}", languages=", ".join(known))
