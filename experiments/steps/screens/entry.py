"""Answer fields, which collect characters and check whether they form a valid answer.

No entry is clipped, guessed or dropped silently. If an entry is invalid, the answer field returns
the key of a text that explains the error, and the calling screen stores the invalid entry.
"""

from __future__ import annotations

import unicodedata
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Self

from slipscale.experiments.languages.texts import NUMBER_KEYS
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.trial import Value
from slipscale.faults import UserError

#: Character of the Enter key. On-screen keys send these characters, too.
ENTER = "\r"
ERASE, CLEAR = "\b", "\x18"
NUMBER_LENGTH = 20
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


class Entry(ABC):
    """Base class for answer fields, which collect characters until they form an answer.

    Attributes
    ----------
    single_key : bool
        Whether a single key is the whole answer.
    hint : str
        Key of the text that explains how to answer.
    content : str
        The characters collected so far.
    place : int or None
        The index of the item that is selected in a list, if any.
    """

    single_key: ClassVar[bool] = False

    def __init__(self, hint: str) -> None:
        self.hint = hint
        self.content = ""

    @property
    def place(self) -> int | None:
        """The index of the selected item, or None if no item is selected."""
        return None

    def turn(self, notches: int) -> None:  # noqa: B027 - optional
        """Move the selection in a list of options. Other types of answer field ignore this call."""

    @abstractmethod
    def press(self, character: str) -> Verdict:
        """Process one character. The Enter key sends ``ENTER``."""

    def erase(self) -> None:
        """Delete the last character."""
        self.content = self.content[:-1]


class TypedEntry(Entry):
    """A line of text, submitted with the Enter key and limited to a maximum length.

    Parameters
    ----------
    judge : callable
        Parses the line, and returns the answer or the reason why the line is invalid.
    hint : str
        Key of the text that explains what to type.
    max_length : int
        Maximum number of characters.
    """

    def __init__(
        self,
        judge: Callable[[str], Reply | Refused],
        hint: str = "window.enter_number",
        max_length: int = NUMBER_LENGTH,
    ) -> None:
        super().__init__(hint)
        self._judge = judge
        self._max_length = max_length

    def press(self, character: str) -> Verdict:
        """Process one character. Enter submits the line, which is cleared if it is invalid."""
        if character in (ENTER, "\n"):
            empty = not self.content.strip()
            verdict = Refused(self.content, "window.empty") if empty else self._judge(self.content)
            if isinstance(verdict, Refused):
                self.content = ""
            return verdict
        if not (character.isprintable() or unicodedata.category(character) == "Zs"):
            return None  # Tab and similar keys are ignored; a no-break space becomes a space
        if len(self.content) >= self._max_length:
            return Refused("", "window.full")
        self.content += character
        return None


class KeyEntry(Entry):
    """An answer field for questions that are answered with a single key.

    Parameters
    ----------
    answers : Mapping
        Values of the answers, keyed by lower-case character.
    """

    single_key = True

    def __init__(self, answers: Mapping[str, Value], hint: str = "window.choose_key") -> None:
        super().__init__(hint)
        self._answers = answers

    @classmethod
    def numbered(cls, values: Sequence[Value], prompt: str) -> Self:
        """Return an answer field with one number key per value.

        Raises
        ------
        UserError
            If there are more values than number keys.
        """
        if not 1 <= len(values) <= NUMBER_KEYS:
            raise UserError(
                "question '{prompt}' has {count} options, expected 1 to {number_keys}, because "
                "each option requires a number key",
                prompt=prompt,
                count=len(values),
                number_keys=NUMBER_KEYS,
            )
        return cls({str(number): value for number, value in enumerate(values, start=1)})

    @classmethod
    def yes_no(cls, texts: Mapping[str, str]) -> Self:
        """Return an answer field with the keys for yes and no in the participant's language."""
        yes, no = texts["window.yes_key"].casefold(), texts["window.no_key"].casefold()
        return cls({yes: True, no: False}, "window.yes_or_no")

    def press(self, character: str) -> Verdict:
        """Accept a key as the answer, or refuse it if it is not an answer key."""
        key = character.casefold()
        if key not in self._answers:
            key = AZERTY.get(key, key)
        if key in self._answers:
            return Reply(value=self._answers[key])
        keys = ", ".join(self._answers)
        return Refused(character, "window.other_key", {"keys": keys})


class ListEntry(Entry):
    """A list from which an item is chosen by number or arrow keys and submitted with Enter.

    Parameters
    ----------
    values : tuple
        The value of each item.
    """

    def __init__(self, values: tuple[Value, ...]) -> None:
        super().__init__("window.choose_number")
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
