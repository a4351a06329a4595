"""The report of data that are not a plate's: their own quantity in place of amplitude.

Every writer of the report speaks of amplitude, µm and slipperiness. For other data the finished
text passes here once, phrase by phrase; names of columns and keys likewise.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import pandas as pd

    from slipscale.analysis.reading.quantity import Quantity

    Json: TypeAlias = "dict[str, Json] | list[Json] | str | float | int | bool | None"

#: A phrase of our writers -> what it says of another quantity; longer phrases go first.
PHRASES: Mapping[str, Callable[[Quantity], str]] = {
    "vibration amplitudes": lambda q: q.levels,
    "vibration amplitude": lambda q: q.name,
    "amplitudes": lambda q: q.levels,
    "amplitude": lambda q: q.name,
    "perceived slipperiness": lambda q: q.judged,
    "slipperiness": lambda q: q.judged,
    "surfaces": lambda _: "stimuli",
    "surface": lambda _: "stimulus",
    "per µm (peak to peak)": lambda q: q.per,
    "per µm": lambda q: q.per,
    "µm (peak to peak)": lambda q: q.unit,
    "µm, peak to peak": lambda q: q.unit,
    "µm peak to peak": lambda q: q.unit,
    "µm, p-p": lambda q: q.unit,
    "µm p-p": lambda q: q.unit,
    "µm": lambda q: q.unit,
    # Yes and no of another laboratory is told against the stimulus, which nobody steps down.
    "do participants feel a step down in amplitude, and what do they say of it?": (
        lambda q: f"how does “yes” depend on {q.name}?"
    ),
    "the descending difference": lambda _: "yes and no",
    "descending difference": lambda _: "yes and no",
    "each step down": lambda _: "each level",
    "steps down": lambda _: "stimuli",
    "step down": lambda _: "stimulus",
    "catch steps": lambda _: "catch trials",
    "catch step": lambda _: "catch trial",
    "steps and on": lambda _: "stimuli and on",
    "steps without a usable answer": lambda _: "trials without a usable answer",
    "where steps are few": lambda _: "where trials are few",
    "the size of the step": lambda q: q.name,
    "sensitivity by step size": lambda _: "sensitivity by level",
    "each step size": lambda _: "each level",
    "for steps of": lambda _: "at",
    "per µm (peak to peak) removed": lambda q: q.per,
}
#: A unit behind a number: of a quantity without unit nothing is left, no blank either.
BEHIND_NUMBER = re.compile(
    r"(?<!per) µm(?: \(peak to peak\)|, peak to peak| peak to peak|, p-p| p-p)?"
)
#: Growth is told against friction too; another quantity has no film.
OF_PLATES_ONLY = "friction"
#: In names of columns and keys.
IN_NAME = re.compile(r"amplitude_um_pp|um_pp|(?<=_)um$|amplitude")
ANY = re.compile(
    "|".join(
        rf"\b{re.escape(phrase)}\b" if phrase[-1].isalnum() else re.escape(phrase)
        for phrase in sorted(PHRASES, key=len, reverse=True)
    ),
    re.IGNORECASE,
)


def in_own_words(text: str, quantity: Quantity) -> str:
    """Return one of our texts as it reads for a quantity; for the plate's amplitude as it is."""
    if quantity.of_plate:
        return text

    def said(found: re.Match[str]) -> str:
        words = PHRASES[found[0].lower()](quantity)
        return words[:1].upper() + words[1:] if found[0][0].isupper() else words

    return ANY.sub(said, text if quantity.unit else BEHIND_NUMBER.sub("", text))


def own_name(name: str, quantity: Quantity) -> str:
    """Return the name of a column or key: ``from_um_pp`` becomes ``from_sound_pressure_uPa``."""
    if quantity.of_plate:
        return name
    return IN_NAME.sub(
        lambda found: "stimulus" if found[0] == "amplitude" else quantity.column, name
    )


def own_columns(table: pd.DataFrame, quantity: Quantity) -> pd.DataFrame:
    """Return a table under its own columns."""
    return table.rename(columns=lambda name: own_name(str(name), quantity))


def own_keys(value: Json, quantity: Quantity) -> Json:
    """Return a JSON value under its own keys, its sentences in its own words."""
    if quantity.of_plate:
        return value
    if isinstance(value, dict):
        return {
            own_name(key, quantity): own_keys(part, quantity)
            for key, part in value.items()
            if key != OF_PLATES_ONLY
        }
    if isinstance(value, list):
        return [own_keys(part, quantity) for part in value]
    if isinstance(value, str):
        return in_own_words(re.sub("um_pp", quantity.unit, value), quantity)
    return value
