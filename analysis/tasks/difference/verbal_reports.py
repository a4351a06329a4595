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
        Title of the codebook.
    n : int
        Number of reports.
    categories : Mapping
        Number of reports in each category, and number of uses of each wording, in the order of the
        codebook. A report may belong to several categories.
    meaning : Mapping
        Number of reports that describe less slipperiness, more slipperiness or neither clearly.
    """

    codebook: str
    n: int
    categories: Mapping[str, CategoryCount]
    meaning: Mapping[Meaning, int]


def code_reports(changes: pd.DataFrame, book: Codebook) -> VerbalReports | NotComputed:
    """Count the reports in each category, and the uses of each wording.

    Parameters
    ----------
    changes : DataFrame
        One row per step with a change in amplitude, with the columns ``difference_felt`` and
        ``verbal_report``.
    book : Codebook
        Codebook for the reports.
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
