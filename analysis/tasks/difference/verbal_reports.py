"""Verbal reports counted under the categories of a code book."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.difference.verbal_coding import OTHER

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd

    from slipscale.analysis.tasks.difference.verbal_coding import Codebook, Meaning


@dataclass(frozen=True, slots=True, kw_only=True)
class CategoryCount:
    """How many reports a category has, and how often each was given in these words."""

    count: int
    words: Mapping[str, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class VerbalReports:
    """Reports of steps on which a difference was felt.

    Parameters
    ----------
    codebook : str
        Title of the code book.
    n : int
        Reports.
    categories : Mapping
        Category -> count and words, in the book's order; a report may have several.
    meaning : Mapping
        What the reports say of slipperiness -> how many.
    """

    codebook: str
    n: int
    categories: Mapping[str, CategoryCount]
    meaning: Mapping[Meaning, int]


def code_reports(changes: pd.DataFrame, book: Codebook) -> VerbalReports | NotComputed:
    """Count categories over reports, with the raw words.

    Parameters
    ----------
    changes : DataFrame
        ``difference_felt verbal_report``, one row a step on which the amplitude changed.
    book : Codebook
        Codes the reports.
    """
    felt = changes[(changes["difference_felt"] == 1)]
    words = Counter(str(text) for text in felt["verbal_report"] if str(text))
    if not words:
        return NotComputed("no verbal reports")
    coded: dict[str, dict[str, int]] = {}
    meanings: Counter[Meaning] = Counter()
    for text, count in sorted(words.items()):
        for name in book.code(text):
            coded.setdefault(name, {})[text] = count
        meanings[book.meaning(text)] += count
    return VerbalReports(
        codebook=book.title,
        n=words.total(),
        categories={
            name: CategoryCount(count=sum(coded[name].values()), words=coded[name])
            for name in (*book.categories, OTHER)
            if name in coded
        },
        meaning=dict(sorted(meanings.items())),
    )
