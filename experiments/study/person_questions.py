"""Questions about the participant, answered with a choice or a whole number within bounds.

The data contain the code of an answer; participants read the answer in their language.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Annotated, Self

from pydantic import Field, field_validator, model_validator

from slipscale.experiments.languages.texts import FEWEST_ANSWERS, MOST_OPTIONS, shipped_texts
from slipscale.experiments.protocol_parts.base import Label, Words
from slipscale.experiments.steps.questions.base import CONSENT
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.questions.whole_number import WholeNumberQuestion
from slipscale.experiments.steps.steps import Ask
from slipscale.faults import UserError
from slipscale.faults.frozen_table import FrozenTable, setting
from slipscale.faults.message import Message
from slipscale.faults.toml_lines import Place
from slipscale.faults.validation import Fault

# Columns of participants.tsv that Slipscale fills in.
TAKEN = ("participant_id", "mode", "complete")

Whole = Annotated[int, Field(strict=True, ge=0, le=1_000_000)]
Translated = Annotated[dict[str, Words], Field(min_length=1)]


def distinct(
    value: tuple[str, ...] | dict[str, dict[str, str]] | None,
) -> tuple[str, ...] | dict[str, dict[str, str]] | None:
    """Return the options. Raises `ValueError` if a language lacks an option or repeats one."""
    if isinstance(value, dict):
        spoken = {language for words in value.values() for language in words}
        lists = [[words.get(each) for words in value.values()] for each in sorted(spoken)]
        if any(None in words for words in lists):
            raise ValueError("expected words for every code in the same languages")
    else:
        lists = [list(value or ())]
    if any(len(set(words)) < len(words) for words in lists):
        raise ValueError("expected different options")
    return value


class PersonQuestion(FrozenTable):
    """A question about the participant; it must not ask for the participant's name.

    Either ``options`` or, for a whole number, ``minimum`` and ``maximum`` are required.
    """

    name: Label = Field(
        description="Column of participants.tsv that stores the answer: letters, digits and _."
    )
    options: (
        Annotated[tuple[Words, ...], Field(min_length=FEWEST_ANSWERS, max_length=MOST_OPTIONS)]
        | Annotated[
            dict[Words, Translated], Field(min_length=FEWEST_ANSWERS, max_length=MOST_OPTIONS)
        ]
        | None
    ) = setting(
        None,
        "Possible answers, all different. Each of up to nine options has a number key; longer "
        "lists scroll, and are answered with numbers, arrow keys or a mouse. A table "
        "gives the wording in each language for each code that is stored in the data. A list gives "
        "wordings that are shown in every language and also stored in the data.",
    )
    minimum: Whole | None = setting(
        None,
        "Smallest whole number that can be typed, if the question has no options.",
        unit="unit of the question",
    )
    maximum: Whole | None = setting(
        None, "Largest whole number that can be typed.", unit="unit of the question"
    )
    prompt: str | Translated = setting(
        "",
        "Text of the question, or a table with the text in each language; default: the shipped "
        "text `about_you.<name>`.",
    )

    _distinct = field_validator("options")(distinct)

    @field_validator("name")
    @classmethod
    def _free(cls, value: str) -> str:
        if value in (*TAKEN, CONSENT):
            raise ValueError("expected another name: a column with this name already exists")
        return value

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        bounds = (self.minimum, self.maximum)
        if (self.options is None) == (bounds == (None, None)):
            raise ValueError("expected either options, or minimum and maximum")
        if self.options is None and None in bounds:
            raise ValueError("expected both minimum and maximum")
        if self.minimum is not None and self.maximum is not None and self.minimum >= self.maximum:
            raise ValueError("expected a minimum below the maximum")
        return self

    def languages(self) -> Iterator[tuple[str, str]]:
        """Yield a (key, language code) pair for each translation."""
        for words in self.options.values() if isinstance(self.options, dict) else ():
            yield from (("options", language) for language in words)
        if isinstance(self.prompt, dict):
            yield from (("prompt", language) for language in self.prompt)

    def faults(self, language: str) -> Iterator[tuple[Place, str]]:
        """Yield a key and an error message for each text that is missing in a language."""
        if isinstance(self.options, dict) and language not in next(iter(self.options.values())):
            yield (
                ("options",),
                Message(
                    "'{name}' has no words for its options in '{language}'",
                    name=self.name,
                    language=language,
                ),
            )
        shipped = f"about_you.{self.name}" in shipped_texts(language)
        if isinstance(self.prompt, dict):
            if language not in self.prompt:
                yield (
                    ("prompt",),
                    Message(
                        "'{name}' has no prompt in '{language}'", name=self.name, language=language
                    ),
                )
        elif not self.prompt and not shipped:
            yield ("prompt",), Message("'{name}' needs its own prompt", name=self.name)

    def ask(self, language: str, texts: Mapping[str, str]) -> Ask:
        """Return the step that asks the question in a language.

        Raises
        ------
        UserError
            If the question is not available in the language.
        """
        if faults := [f"about_you: {sentence}" for _, sentence in self.faults(language)]:
            raise UserError("; ".join(faults))
        prompt = self.prompt[language] if isinstance(self.prompt, dict) else self.prompt
        prompt = prompt or texts[f"about_you.{self.name}"]
        if self.minimum is not None and self.maximum is not None:
            number = WholeNumberQuestion(prompt=prompt, minimum=self.minimum, maximum=self.maximum)
            return Ask(name=self.name, question=number)
        if isinstance(self.options, dict):
            options = tuple((code, words[language]) for code, words in self.options.items())
        else:
            options = tuple((words, words) for words in self.options or ())
        return Ask(name=self.name, question=ChoiceQuestion(prompt=prompt, options=options))

    def levels(self, language: str) -> dict[str, str]:
        """Return the label for each answer code; empty for a question that asks for a number.

        If a label is not available in the language, it is returned in another language.
        """
        if isinstance(self.options, dict):
            return {
                code: words.get(language, next(iter(words.values())))
                for code, words in self.options.items()
            }
        return {words: words for words in self.options or ()}


def unanswerable(
    questions: tuple[PersonQuestion, ...], language: str, known: Collection[str]
) -> Iterator[Fault]:
    """Yield the location and a message for each question that cannot be asked in a language.

    ``known`` contains the available languages. Translations into other languages are also reported.
    """
    for number, question in enumerate(questions):
        for key in {key for key, each in question.languages() if each not in known}:
            message = Message("expected languages among {languages}", languages=", ".join(known))
            yield ("about_you", number, key), {"msg": message}
        for place, sentence in question.faults(language):
            yield ("about_you", number, *place), {"msg": sentence}
