"""Count verbal reports by code-book category."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.difference.verbal_coding import OTHER, Codebook, Meaning

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, slots=True, kw_only=True)
class CategoryCount:
    """Number of reports in a category, and number of uses of each wording."""

    count: int
    words: Mapping[str, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class VerbalReports:
    """Verbal reports on steps in which participants felt a difference, coded by category.

    Parameters
    ----------
    codebook : str
        Title of the code book.
    n : int
        Number of reports.
    categories : Mapping
        Counts of reports and of wordings by category, in the order of the code book. A report may
        belong to several categories.
    meaning : Mapping
        Number of reports with each meaning for slipperiness.
    """

    codebook: str
    n: int
    categories: Mapping[str, CategoryCount]
    meaning: Mapping[Meaning, int]


def code_reports(changes: pd.DataFrame, book: Codebook) -> VerbalReports | NotComputed:
    """Count reports and wordings in each category.

    Parameters
    ----------
    changes : DataFrame
        One row per step with a change in amplitude, with the columns ``difference_felt`` and
        ``verbal_report``.
    book : Codebook
        Code book for the reports.
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
