"""Answer fields, which collect characters and check whether they form a valid answer.

No entry is clipped, guessed or dropped silently. If an entry is invalid, the answer field returns
the key of a text that explains the error, and the calling screen stores the invalid entry.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Protocol, TypeGuard

from slipscale.experiments.languages.texts import NUMBER_KEYS
from slipscale.experiments.steps.questions import (
    ChoiceQuestion,
    ComparisonQuestion,
    NumberQuestion,
    Question,
    TextQuestion,
    WholeNumberQuestion,
    YesNoQuestion,
)
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.trial import Value
from slipscale.faults import UserError

# Codes that on-screen keys send in addition to characters.
ENTER, ERASE, CLEAR = "\r", "\b", "\x18"
NUMBER_LENGTH = 20
NUMBER = re.compile(r"[+-]?([0-9]+([.,][0-9]*)?|[.,][0-9]+)")
# Depending on the country, "1,000" means one or one thousand. "1.000" is accepted as one, because a
# point is a decimal mark in English and never separates thousands in French.
THOUSANDS = re.compile(r"[+-]?[1-9][0-9]{0,2}(,[0-9]{3})+")
# Characters of the unshifted digit row of a French keyboard; the key marked 2 enters 2.
AZERTY = dict(zip("&é\"'(-è_ç", "123456789", strict=True))


@dataclass(frozen=True, slots=True)
class Refused:
    """The reason why an entry is invalid.

    Parameters
    ----------
    entry : str
        The entry exactly as typed.
    reason : str
        The key of the text that explains the refusal, for example "window.not_a_number".
    blanks : Mapping
        Values for the placeholders in this explanation.
    """

    entry: str
    reason: str
    blanks: Mapping[str, str] = field(default_factory=dict)


Verdict = Reply | Refused | None


def judge_number(entry: str, *, positive: bool = False) -> Reply | Refused:
    """Parse a finite number as people type it, with a decimal point or comma and no exponent.

    Parameters
    ----------
    entry : str
        The text to parse.
    positive : bool
        Whether to refuse 0.

    Examples
    --------
    >>> judge_number("12,5").value
    12.5
    >>> judge_number("1,000").reason
    'window.thousands'
    >>> judge_number("-3").reason
    'window.too_small'
    """
    text = entry.strip()
    if not text:
        return Refused(entry, "window.empty")
    if THOUSANDS.fullmatch(text):
        return Refused(entry, "window.thousands", {"entry": text})
    if not NUMBER.fullmatch(text):
        return Refused(entry, "window.not_a_number", {"entry": text})
    value = float(text.replace(",", ".")) + 0.0  # no negative zero
    refusals = {
        "window.too_large": not math.isfinite(value),
        "window.too_small": value < 0,
        # A float has about 16 digits, so a longer number would be stored with a different value.
        "window.too_many_digits": math.isfinite(value)
        and Decimal(repr(value)) != Decimal(text.replace(",", ".")),
        "window.not_positive": positive and value == 0,
    }
    for reason, applies in refusals.items():
        if applies:
            return Refused(entry, reason, {"entry": text})
    return Reply(value=value)


def judge_whole_number(entry: str, *, minimum: int, maximum: int) -> Reply | Refused:
    """Parse a whole number, and check that it is between two inclusive bounds.

    >>> judge_whole_number(" 34 ", minimum=18, maximum=99).value
    34.0
    >>> judge_whole_number("34,5", minimum=18, maximum=99).reason
    'window.out_of_bounds'
    """
    text = entry.strip()
    if not text:
        return Refused(entry, "window.empty")
    # Only ASCII digits are allowed; a number with more digits than the maximum is too large.
    whole = bool(re.fullmatch("[0-9]+", text)) and len(text.lstrip("0")) <= len(str(maximum))
    if whole and minimum <= int(text) <= maximum:
        return Reply(value=float(text))
    blanks = {"entry": text, "minimum": str(minimum), "maximum": str(maximum)}
    return Refused(entry, "window.out_of_bounds", blanks)


class Entry(Protocol):
    """Common interface for answer fields, which collect characters until they form an answer."""

    content: str

    def turn(self, notches: int) -> None:
        """Move the selection in a list of options. Other types of answer field ignore this call."""

    def press(self, character: str) -> Verdict:
        """Process one character. The Enter key sends ``ENTER``."""

    def erase(self) -> None:
        """Delete the last character."""


class TypedEntry:
    """A line of text, submitted with the Enter key and limited to a maximum length.

    Parameters
    ----------
    question : NumberQuestion, WholeNumberQuestion or TextQuestion
        The question to answer.
    """

    def __init__(self, question: NumberQuestion | WholeNumberQuestion | TextQuestion) -> None:
        self.content = ""
        self._question = question
        self._max_length = (
            question.max_length if isinstance(question, TextQuestion) else NUMBER_LENGTH
        )

    def press(self, character: str) -> Verdict:
        """Process one character. Enter submits the line, which is cleared if it is invalid."""
        if character in (ENTER, "\n"):
            verdict = self._judge()
            if isinstance(verdict, Refused):
                self.content = ""
            return verdict
        if not (character.isprintable() or unicodedata.category(character) == "Zs"):
            return None  # Tab and similar keys are ignored; a no-break space becomes a space
        if len(self.content) >= self._max_length:
            return Refused("", "window.full")
        self.content += character
        return None

    def erase(self) -> None:
        """Delete the last character."""
        self.content = self.content[:-1]

    def turn(self, notches: int) -> None:
        """Do nothing, because a line of text has no selection to move."""

    def _judge(self) -> Reply | Refused:
        if isinstance(self._question, NumberQuestion):
            return judge_number(self.content, positive=self._question.positive)
        if isinstance(self._question, WholeNumberQuestion):
            return judge_whole_number(
                self.content, minimum=self._question.minimum, maximum=self._question.maximum
            )
        if not self.content.strip():
            return Refused(self.content, "window.empty")
        return Reply(value=self.content)


class KeyEntry:
    """An answer field for questions that are answered with a single key.

    Parameters
    ----------
    answers : Mapping
        Values of the answers, keyed by lower-case character.
    """

    def __init__(self, answers: Mapping[str, Value]) -> None:
        self.content = ""
        self._answers = answers

    def press(self, character: str) -> Verdict:
        """Accept a key as the answer, or refuse it if it is not an answer key."""
        key = character.casefold()
        if key not in self._answers:
            key = AZERTY.get(key, key)
        if key in self._answers:
            return Reply(value=self._answers[key])
        keys = ", ".join(self._answers)
        return Refused(character, "window.other_key", {"keys": keys})

    def erase(self) -> None:
        """Do nothing, because single-key answers are not edited."""

    def turn(self, notches: int) -> None:
        """Do nothing, because a single-key answer has no selection to move."""


class ListEntry:
    """A list from which an item is chosen by number or arrow keys and submitted with Enter.

    Parameters
    ----------
    values : tuple
        The value of each item.
    """

    def __init__(self, values: tuple[Value, ...]) -> None:
        self.content = ""
        self._values = values

    @property
    def place(self) -> int | None:
        """The index of the selected item, or None if no item is selected."""
        number = int(self.content) if self.content else 0
        return number - 1 if 1 <= number <= len(self._values) else None

    def press(self, character: str) -> Verdict:
        """Process a digit, or submit the selection if the key is Enter."""
        if character == CLEAR:
            self.content = ""
        elif character in (ENTER, "\n"):
            return self._judge()
        else:
            digit = AZERTY.get(character, character)
            # Only ASCII digits are allowed, and at most as many as in the largest item number.
            if digit not in "0123456789" or len(self.content) >= len(str(len(self._values))):
                return self._refused(self.content + character)
            self.content += digit
        return None

    def erase(self) -> None:
        """Delete the last digit."""
        self.content = self.content[:-1]

    def turn(self, notches: int) -> None:
        """Move the selection up or down, without wrapping around."""
        last = len(self._values) - 1
        here = self.place
        if here is None:
            here = -1 if notches < 0 else last + 1
        self.content = str(min(max(here - notches, 0), last) + 1)

    def _judge(self) -> Reply | Refused:
        if self.place is not None:
            return Reply(value=self._values[self.place])
        if not self.content:
            return Refused("", "window.empty")
        entry, self.content = self.content, ""
        return self._refused(entry)

    def _refused(self, entry: str) -> Refused:
        blanks = {"entry": entry, "minimum": "1", "maximum": str(len(self._values))}
        return Refused(entry, "window.out_of_bounds", blanks)


def entry_for(question: Question, texts: Mapping[str, str]) -> Entry:
    """Return an empty answer field for a question.

    Parameters
    ----------
    question : Question
        The question to answer.
    texts : Mapping
        The texts in the participant's language, which define the keys for yes and no.

    Raises
    ------
    UserError
        If a comparison question has more surfaces than there are number keys.
    """
    if isinstance(question, YesNoQuestion):
        return KeyEntry(yes_no_keys(texts))
    if is_long(question):
        return ListEntry(tuple(code for code, _ in question.options))
    if isinstance(question, ChoiceQuestion | ComparisonQuestion):
        return KeyEntry(choice_keys(question))
    if isinstance(question, NumberQuestion | WholeNumberQuestion | TextQuestion):
        return TypedEntry(question)
    raise TypeError(f"no answer field for {type(question).__name__}")


def is_long(question: Question) -> TypeGuard[ChoiceQuestion]:
    """Return whether a choice has more options than number keys, so that it needs a list."""
    return isinstance(question, ChoiceQuestion) and len(question.options) > NUMBER_KEYS


def yes_no_keys(texts: Mapping[str, str]) -> dict[str, Value]:
    """Return the keys for yes and no in the participant's language, with their values."""
    yes, no = texts["window.yes_key"].casefold(), texts["window.no_key"].casefold()
    return {yes: True, no: False}


def choice_keys(question: ChoiceQuestion | ComparisonQuestion) -> dict[str, Value]:
    """Return a dictionary from number key to value: the option's code or the number itself."""
    count = len(question.options)
    if not 1 <= count <= NUMBER_KEYS:
        raise UserError(
            "question '{prompt}' has {count} options, expected 1 to {number_keys}, because each "
            "option requires a number key",
            prompt=question.prompt,
            count=count,
            number_keys=NUMBER_KEYS,
        )
    numbers = range(1, count + 1)
    if isinstance(question, ComparisonQuestion):
        return {str(number): float(number) for number in numbers}
    codes = (code for code, _ in question.options)
    return {str(number): code for number, code in zip(numbers, codes, strict=True)}
