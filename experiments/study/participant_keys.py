"""Keys that participants use on a keyboard, a keypad, a response box or a pedal.

All of these devices act as keyboards that send characters. The screen shows which keys to use.
Numbers and choices are always entered with the digit keys and Enter.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from slipscale.experiments.protocol_parts.base import Switch
from slipscale.faults.frozen_table import FrozenTable, setting
from slipscale.faults.message import Message

NAMED = ("space", "enter")
AGAIN = ("r", "a")  # default of `again`: the first of these keys that differs from `go_on`
Key = Annotated[str, Field(strict=True)]


class ParticipantKeys(FrozenTable):
    """The ``[keys]`` table of a study file."""

    go_on: Key = setting(
        "space",
        "Key with which the participant continues: space, enter, or the character that "
        "the key sends.",
    )
    yes: Key = setting(
        "",
        'Character of the key for "yes"; default: the letter in the participant\'s language.',
    )
    no: Key = setting("", 'Character of the key for "no".')
    numbers: Literal["typed", "spoken"] = setting(
        "typed",
        "typed: the participant enters numbers. spoken: the participant speaks them, and the "
        "operator types them in the terminal or the console.",
    )
    touch: Switch = setting(
        False,
        "Whether the participant answers on a touch screen or with a mouse; the screen then "
        "shows buttons for numbers, choices and continuing. A keyboard also works.",
    )
    again: Key = setting(
        "",
        "Character of the key that presents the reference again in a matching task; default: r, "
        "or a if r is the key for continuing.",
    )

    @field_validator("go_on")
    @classmethod
    def _a_key(cls, value: str) -> str:
        if value not in NAMED and not _is_character(value):
            raise ValueError(Message("expected {keys}, or one character", keys=" or ".join(NAMED)))
        return value

    @model_validator(mode="after")
    def _a_key_of_its_own(self) -> Self:
        if self.again and not _is_character(self.again):
            raise ValueError("again: expected one character")
        if self.again.casefold() == self.go_on.casefold():
            raise ValueError("again must not be the same key as go_on")
        return self

    @model_validator(mode="after")
    def _two_keys(self) -> Self:
        if self.yes == self.no == "":
            return self
        characters = all(_is_character(key) for key in (self.yes, self.no))
        if not characters or self.yes.casefold() == self.no.casefold():
            raise ValueError("expected both yes and no, as two different characters")
        return self

    def texts(self) -> dict[str, str]:
        """Return the screen texts that name the keys and, if set, enable the touch buttons."""
        again = self.again or next(key for key in AGAIN if key != self.go_on.casefold())
        named = {"window.go_on_key": self.go_on, "window.again_key": again}
        if self.yes:
            named |= {"window.yes_key": self.yes, "window.no_key": self.no}
        if self.touch:
            named["window.touch"] = "yes"
        return named


def _is_character(key: str) -> bool:
    return len(key) == 1 and key.isprintable() and not key.isspace()
