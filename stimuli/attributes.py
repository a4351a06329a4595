"""Define the attributes of surfaces that participants judge, with their wording per language.

A study selects an ``attribute``, whose adjective, noun and comparatives replace placeholders in the
text shown to participants. For an attribute that is not listed here, the study file provides
these words in ``[attribute_words]``.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import NamedTuple

SLIPPERINESS = "slipperiness"


class AttributeWords(NamedTuple):
    """Wording for an attribute in one language, which replaces placeholders in displayed text.

    Parameters
    ----------
    adjective : str
        Adjective, such as "slippery". In languages with grammatical gender, the adjective
        agrees with "surface" (feminine in French).
    noun : str
        Noun, such as "slipperiness".
    masculine, plural : str
        Other forms of the adjective, if the language has them.
    more, less : str
        Adverbs before the adjective, such as "more" and "less": ``more`` selects the surface with
        the higher level, and ``less`` the surface with the lower level.
    """

    adjective: str
    noun: str
    masculine: str = ""
    plural: str = ""
    more: str = "more"
    less: str = "less"

    @property
    def falling(self) -> AttributeWords:
        """Wording for an attribute that decreases with the level."""
        return self._replace(more=self.less, less=self.more)

    def fill(self, text: str) -> str:
        """Replace the placeholders in a text with the words for this attribute.

        >>> ATTRIBUTES["roughness"]["en"].fill("How <adjective> is this surface?")
        'How rough is this surface?'
        """
        for place, word in zip(self._fields, self, strict=True):
            text = text.replace(f"<{place}>", word or self.adjective)
        return text


_french = partial(AttributeWords, more="plus", less="moins")
ATTRIBUTES: Mapping[str, Mapping[str, AttributeWords]] = {
    SLIPPERINESS: {
        "en": AttributeWords("slippery", SLIPPERINESS),
        "fr": _french("glissante", "glissance", "glissant", "glissantes"),
    },
    "roughness": {
        "en": AttributeWords("rough", "roughness"),
        "fr": _french("rugueuse", "rugosité", "rugueux", "rugueuses"),
    },
    "coarseness": {
        "en": AttributeWords("coarse", "coarseness"),
        "fr": _french("grossière", "grossièreté", "grossier", "grossières"),
    },
    "stickiness": {
        "en": AttributeWords("sticky", "stickiness"),
        "fr": _french("collante", "adhérence", "collant", "collantes"),
    },
    "smoothness": {
        "en": AttributeWords("smooth", "smoothness"),
        "fr": _french("lisse", "douceur", "lisse", "lisses"),
    },
    "intensity": {
        "en": AttributeWords("intense", "intensity"),
        "fr": _french("intense", "intensité", "intense", "intenses"),
    },
    "pleasantness": {
        "en": AttributeWords("pleasant", "pleasantness"),
        "fr": _french("agréable", "agrément", "agréable", "agréables"),
    },
}


def english_adjective(attribute: str) -> str:
    """Return the English adjective for a listed attribute, otherwise a phrase with its noun.

    >>> english_adjective("roughness"), english_adjective("brightness")
    ('rough', 'high in brightness')
    """
    listed = ATTRIBUTES.get(attribute)
    return listed["en"].adjective if listed else f"high in {attribute}"
