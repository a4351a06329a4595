"""Code verbal reports about slipperiness by word stems."""

from __future__ import annotations

import re
import unicodedata
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from slipscale.faults.frozen_table import FrozenTable
from slipscale.faults.toml_file import read_toml

Meaning = Literal["less_slippery", "more_slippery", "unclear"]
#: Stems must contain at least one letter or digit, because other stems could match every report.
Word = Annotated[str, Field(pattern=r"\w")]
SHIPPED = Path(__file__).parent / "codebook.toml"
OTHER = "other"
#: Separators between statements, as in "less smooth, it sticks more".
CLAUSES = re.compile(r"[,;.!/]+| and | but | et | mais ")


class Category(FrozenTable):
    """A category of verbal reports, with its word stems and what it implies for slipperiness.

    ``more_stems`` are the stems of comparatives, such as "rougher".
    """

    stems: Annotated[tuple[Word, ...], Field(min_length=1)]
    bare: Meaning = "unclear"
    less: Meaning = "unclear"
    more: Meaning = "unclear"
    more_stems: tuple[Word, ...] = ()


class Codebook(FrozenTable):
    """A codebook, as read from a TOML file."""

    title: str
    less: tuple[Word, ...] = ()
    more: tuple[Word, ...] = ()
    less_phrases: tuple[Word, ...] = ()
    only_before: tuple[Word, ...] = ()
    categories: Annotated[dict[str, Category], Field(min_length=1)]

    def code(self, report: str) -> list[str]:
        """Return the categories of a report in the order of the codebook, or "other".

        >>> load_codebook().code("C'est moins glissant, plus rugueux")
        ['slippery', 'rough']
        """
        text = plain(report)
        found = [name for name, entry in self.categories.items() if _has(text, entry.stems)]
        return found or [OTHER]

    def direction(self, report: str, category: str) -> Literal["less", "more", "bare"]:
        """Return whether a report mentions a category with "less", "more" or neither ("bare")."""
        text = plain(report)
        if _has(text, self.less_phrases):
            return "less"
        entry = self.categories[category]
        if _has(text, entry.more_stems):
            return "more"
        # The nearest direction word before the category decides; without one, any direction word
        # after the category.
        place = max(_last(text, stem) for stem in entry.stems)
        before, after = text[: max(place, 0)], text[max(place, 0) :]
        for part, more_words in (
            (before, self.more),
            (after, tuple(word for word in self.more if word not in self.only_before)),
        ):
            less = max((_last(part, word) for word in self.less), default=-1)
            more = max((_last(part, word) for word in more_words), default=-1)
            if max(less, more) >= 0:
                return "less" if less > more else "more"
        return "bare"

    def meaning(self, report: str) -> Meaning:
        """Return whether a report describes less or more slipperiness, otherwise "unclear".

        >>> book = load_codebook()
        >>> [book.meaning(words) for words in ("less smooth, it sticks more", "warm")]
        ['less_slippery', 'unclear']
        """
        meanings: set[Meaning] = set()
        for clause in CLAUSES.split(plain(report)):
            for name in self.code(clause):
                if name != OTHER:
                    entry = self.categories[name]
                    turned: dict[str, Meaning] = {
                        "less": entry.less,
                        "more": entry.more,
                        "bare": entry.bare,
                    }
                    meanings.add(turned[self.direction(clause, name)])
        meanings.discard("unclear")
        return meanings.pop() if len(meanings) == 1 else "unclear"


def plain(text: str) -> str:
    """Normalise text to lower case, plain apostrophes and single spaces, without accents."""
    bare = unicodedata.normalize("NFKD", text.replace("\u2019", "'")).casefold()
    bare = "".join(mark for mark in bare if not unicodedata.combining(mark))
    return re.sub(r"\s+", " ", bare).strip()


def _last(text: str, stem: str) -> int:
    """Return the position of the last word that begins with the stem, or -1 if there is none."""
    found = [match.start() for match in re.finditer(rf"(?<!\w){re.escape(plain(stem))}", text)]
    return found[-1] if found else -1


def _has(text: str, stems: tuple[str, ...]) -> bool:
    return any(_last(text, stem) >= 0 for stem in stems)


def load_codebook(path: Path = SHIPPED) -> Codebook:
    """Read a codebook.

    Raises
    ------
    UserError
        The file cannot be read or is not a valid codebook. The message lists all errors.
    """
    return read_toml(path, Codebook)
