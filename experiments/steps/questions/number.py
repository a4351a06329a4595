"""Question answered with a number."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from decimal import Decimal
from functools import partial
from typing import ClassVar

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.questions.base import Question, is_number
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.screens import touch
from slipscale.experiments.steps.screens.entry import Entry, Refused, TypedEntry
from slipscale.experiments.steps.screens.scene import Scene
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.trial import Value

NUMBER = re.compile(r"[+-]?([0-9]+([.,][0-9]*)?|[.,][0-9]+)")
# Depending on the country, "1,000" means one or one thousand. "1.000" is accepted as one, because a
# point is a decimal mark in English and never separates thousands in French.
THOUSANDS = re.compile(r"[+-]?[1-9][0-9]{0,2}(,[0-9]{3})+")


@dataclass(frozen=True, slots=True, kw_only=True)
class NumberQuestion(Question):
    """Question answered with a number (0 or more, decimals allowed) on the participant's own scale.

    ``positive`` also excludes 0, for example for the top of a scale.
    """

    EXPECTED: ClassVar = "a number of 0 or more"
    SPOKEN: ClassVar = True
    positive: bool = False

    def fits(self, value: object) -> bool:
        """Return whether a value is a finite number of 0 or more."""
        return is_number(value)

    def rehearsed(self, place: float, /) -> Value:
        """Return a number from 1 to 2."""
        return 1.0 + place

    def entry(self, _texts: Texts, /) -> Entry:
        """Return an answer field for a number."""
        return TypedEntry(partial(judge_number, positive=self.positive))

    def body(self, entry: Entry, texts: Texts, /) -> Scene:
        """Return the answer field."""
        return touch.number(entry.content, texts)

    def simulated(self, person: SimulatedPerson, _name: str, /) -> Value:
        """Return a magnitude estimate of the last surface."""
        return person.estimate()


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
