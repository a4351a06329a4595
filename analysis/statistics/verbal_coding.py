"""Coding verbal reports by an editable code book, and how well two coders agree."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from analysis.statistics.omnibus import Result, reason
from faults.toml_file import read_toml

if TYPE_CHECKING:
    import pandas as pd

Meaning = Literal["less_slippery", "more_slippery", "unclear"]
#: A stem without a letter would be found in every report.
Word = Annotated[str, Field(pattern=r"\w")]
SHIPPED = Path(__file__).parent / "codebook.toml"
OTHER = "other"
#: What parts one statement from the next: "less smooth, it sticks more".
CLAUSES = re.compile(r"[,;.!/]+| and | but | et | mais ")


class Category(BaseModel):
    """One category: the stems that find it, and what it means for slipperiness.

    ``more_stems`` are comparatives that say "more" in themselves ("rougher").
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    stems: Annotated[tuple[Word, ...], Field(min_length=1)]
    bare: Meaning = "unclear"
    less: Meaning = "unclear"
    more: Meaning = "unclear"
    more_stems: tuple[Word, ...] = ()


class Codebook(BaseModel):
    """A code book, as its TOML file has it."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    title: str
    less: tuple[Word, ...] = ()
    more: tuple[Word, ...] = ()
    less_phrases: tuple[Word, ...] = ()
    only_before: tuple[Word, ...] = ()
    categories: Annotated[dict[str, Category], Field(min_length=1)]

    def code(self, report: str) -> list[str]:
        """Return the categories of a report, in the book's order; "other" where none fits.

        >>> load_codebook().code("C'est moins glissant, plus rugueux")
        ['slippery', 'rough']
        """
        text = plain(report)
        found = [name for name, entry in self.categories.items() if _has(text, entry.stems)]
        return found or [OTHER]

    def direction(self, report: str, category: str) -> Literal["less", "more", "bare"]:
        """Return whether the report says less or more of a category, or only names it."""
        text = plain(report)
        if _has(text, self.less_phrases):
            return "less"
        entry = self.categories[category]
        if _has(text, entry.more_stems):
            return "more"
        # The nearest word of direction before the category decides, else any word after it.
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
        """Return what a report says of slipperiness; contradictory reports are unclear.

        >>> book = load_codebook()
        >>> [book.meaning(words) for words in ("less smooth, it sticks more", "warm")]
        ['less_slippery', 'unclear']
        """
        said: set[Meaning] = set()
        for clause in CLAUSES.split(plain(report)):
            for name in self.code(clause):
                if name != OTHER:
                    entry = self.categories[name]
                    turned: dict[str, Meaning] = {
                        "less": entry.less,
                        "more": entry.more,
                        "bare": entry.bare,
                    }
                    said.add(turned[self.direction(clause, name)])
        said.discard("unclear")
        return said.pop() if len(said) == 1 else "unclear"


def plain(text: str) -> str:
    """Return text in lower case, without accents, apostrophes alike, blanks single."""
    bare = unicodedata.normalize("NFKD", text.replace("\u2019", "'")).casefold()
    bare = "".join(mark for mark in bare if not unicodedata.combining(mark))
    return re.sub(r"\s+", " ", bare).strip()


def _last(text: str, stem: str) -> int:
    """Return where a stem last begins a word, or -1."""
    found = [match.start() for match in re.finditer(rf"(?<!\w){re.escape(plain(stem))}", text)]
    return found[-1] if found else -1


def _has(text: str, stems: tuple[str, ...]) -> bool:
    return any(_last(text, stem) >= 0 for stem in stems)


def load_codebook(path: Path = SHIPPED) -> Codebook:
    """Read a code book.

    Raises
    ------
    UserError
        The file cannot be read or is not a code book; says every fault.
    """
    return read_toml(path, Codebook)


def code_reports(changes: pd.DataFrame, book: Codebook) -> Result:
    """Count categories over reports, with the raw words."""
    felt = changes[(changes["difference_felt"] == 1)]
    words = Counter(str(text) for text in felt["verbal_report"] if str(text))
    if not words:
        return reason("no verbal reports")
    categories: dict[str, dict[str, Any]] = {}
    for text, count in sorted(words.items()):
        for name in book.code(text):
            entry = categories.setdefault(name, {"count": 0, "words": {}})
            entry["count"] += count
            entry["words"][text] = count
    order = [name for name in (*book.categories, OTHER) if name in categories]
    meanings = Counter[str]()
    for text, count in words.items():
        meanings[book.meaning(text)] += count
    return {
        "codebook": book.title,
        "n": sum(words.values()),
        "categories": {name: categories[name] for name in order},
        "meaning": dict(sorted(meanings.items())),
    }


def agreement(codes: pd.DataFrame) -> Result:
    """Return Cohen's kappa of two coders.

    Parameters
    ----------
    codes : DataFrame
        ``verbal_report coder category``: the file ``code/verbal_codes.tsv`` of a data set.
    """
    import numpy as np  # noqa: PLC0415
    from statsmodels.stats.inter_rater import cohens_kappa  # noqa: PLC0415

    codes = codes.dropna(subset=["verbal_report", "coder", "category"])
    coders = sorted(codes["coder"].astype(str).unique())
    if len(coders) != 2:  # noqa: PLR2004
        return reason(f"{len(coders)} coders; agreement is between two")
    wide = codes.assign(coder=codes["coder"].astype(str)).pivot_table(
        index="verbal_report", columns="coder", values="category", aggfunc="first"
    )
    both = wide.dropna()
    names = sorted(set(both.to_numpy().ravel()))
    if len(both) < 2 or len(names) < 2:  # noqa: PLR2004
        return reason("two reports coded by both, with two categories, are needed")
    table = np.zeros((len(names), len(names)))
    for first, second in both.to_numpy():
        table[names.index(first), names.index(second)] += 1
    with np.errstate(invalid="ignore", divide="ignore"):
        # Its test against 0 divides by a standard error that may be 0.
        found = cohens_kappa(table)
    return {
        "coders": coders,
        "reports": len(both),
        "kappa": float(found.kappa),
        "ci95": [float(found.kappa_low), float(found.kappa_upp)],
        "agreed": int(np.trace(table)),
    }
