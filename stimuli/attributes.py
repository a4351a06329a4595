"""The attributes of surfaces that participants judge, with words in the screens' languages.

A study names its ``attribute``; texts and descriptions have placeholders for the words. For an
attribute that is not listed, the study defines the words in ``[attribute_words]``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping

SLIPPERINESS = "slipperiness"


class AttributeWords(NamedTuple):
    """The words of an attribute in one language, for placeholders in texts.

    Parameters
    ----------
    adjective : str
        "slippery"; in languages with genders, agreeing with "surface" (feminine).
    noun : str
        "slipperiness".
    masculine, plural : str
        Other forms of the adjective, if the language has them.
    """

    adjective: str
    noun: str
    masculine: str = ""
    plural: str = ""

    def fill(self, text: str) -> str:
        """Return a text with its placeholders replaced by the words.

        >>> ATTRIBUTES["roughness"]["en"].fill("How <adjective> is this surface?")
        'How rough is this surface?'
        """
        for place, word in zip(self._fields, self, strict=True):
            text = text.replace(f"<{place}>", word or self.adjective)
        return text


ATTRIBUTES: Mapping[str, Mapping[str, AttributeWords]] = {
    SLIPPERINESS: {
        "en": AttributeWords("slippery", SLIPPERINESS),
        "fr": AttributeWords("glissante", "glissance", "glissant", "glissantes"),
    },
    "roughness": {
        "en": AttributeWords("rough", "roughness"),
        "fr": AttributeWords("rugueuse", "rugosité", "rugueux", "rugueuses"),
    },
    "coarseness": {
        "en": AttributeWords("coarse", "coarseness"),
        "fr": AttributeWords("grossière", "grossièreté", "grossier", "grossières"),
    },
    "stickiness": {
        "en": AttributeWords("sticky", "stickiness"),
        "fr": AttributeWords("collante", "adhérence", "collant", "collantes"),
    },
    "smoothness": {
        "en": AttributeWords("smooth", "smoothness"),
        "fr": AttributeWords("lisse", "douceur", "lisse", "lisses"),
    },
    "intensity": {
        "en": AttributeWords("intense", "intensity"),
        "fr": AttributeWords("intense", "intensité", "intense", "intenses"),
    },
    "pleasantness": {
        "en": AttributeWords("pleasant", "pleasantness"),
        "fr": AttributeWords("agréable", "agrément", "agréable", "agréables"),
    },
}


def english_adjective(attribute: str) -> str:
    """Return an attribute's adjective; for one that is not listed, a phrase with its noun.

    >>> english_adjective("roughness"), english_adjective("brightness")
    ('rough', 'high in brightness')
    """
    listed = ATTRIBUTES.get(attribute)
    return listed["en"].adjective if listed else f"high in {attribute}"
