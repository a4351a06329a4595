"""What participants judge of a surface, and its words in the languages of the screens.

A study names its ``attribute``; texts and descriptions have places for the words. For an attribute
that is not listed, the study states the words in ``[attribute_words]``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping

SLIPPERINESS = "slipperiness"


class AttributeWords(NamedTuple):
    """The words of an attribute in a language, as texts place them.

    Parameters
    ----------
    adjective : str
        "slippery"; in languages with genders, of a (feminine) surface.
    noun : str
        "slipperiness".
    masculine, plural : str
        Other forms of the adjective, where the language has them.
    """

    adjective: str
    noun: str
    masculine: str = ""
    plural: str = ""

    def fill(self, text: str) -> str:
        """Return a text with the words in their places.

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
    """Return the adjective of an attribute; of one that is not listed, a phrase with its noun.

    >>> english_adjective("roughness"), english_adjective("brightness")
    ('rough', 'high in brightness')
    """
    listed = ATTRIBUTES.get(attribute)
    return listed["en"].adjective if listed else f"high in {attribute}"
