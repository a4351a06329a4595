"""Verbal reports with which simulated people describe a lower level, by language."""

from __future__ import annotations

from collections.abc import Mapping

from slipscale.stimuli.attributes import ATTRIBUTES, SLIPPERINESS, AttributeWords

# Simulated verbal reports of what has been removed, for slipperiness. The first is from the paper
# ("less slippery", Section IV-B).
VERBAL_REPORTS: Mapping[str, tuple[str, ...]] = {
    "en": (
        "less slippery",
        "it is less slippery",
        "it got rougher",
        "less smooth, it sticks more",
        'the "oily" feeling is gone',
    ),
    "fr": (
        "moins glissant",
        "c'est moins glissant",
        "plus rugueux",
        "moins lisse, ça accroche",
        "l'effet « huileux » a disparu",
    ),
}

# Answers for any other attribute.
OTHER_REPORTS: Mapping[str, tuple[str, ...]] = {
    "en": ("<less> <adjective>", "it is <less> <adjective>", "it got <less> <adjective>"),
    "fr": ("<less> <adjective>", "c'est <less> <masculine>", "elle est <less> <adjective>"),
}


def verbal_reports(language: str, words: AttributeWords | None) -> tuple[str, ...]:
    """Return possible verbal reports of a decrease in level, in words for the study's attribute."""
    if words is None or words in ATTRIBUTES[SLIPPERINESS].values():
        return VERBAL_REPORTS.get(language, VERBAL_REPORTS["en"])
    return tuple(map(words.fill, OTHER_REPORTS.get(language, OTHER_REPORTS["en"])))
