"""Define a layout: how the rows of a table become one row per answer, and then trials."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.reading.delimited import Problems, Source
    from slipscale.analysis.reading.meaning.mapping import TableMapping

#: Kinds of trials (see `slipscale.analysis.reading.labelled_tasks.TaskTrials`).
ESTIMATES, DIFFERENCES, CHOICES = "estimates", "differences", "forced_choices"
PAIRS, COMPARISONS = "dissimilarities", "comparisons"


@dataclass(frozen=True, slots=True, kw_only=True)
class Rows:
    """Rows of a table, with the meaning of its columns.

    Parameters
    ----------
    frame : DataFrame
        Rows with the columns ``file`` (index into ``sources``), ``line`` and ``participant_id``.
        After reshaping, columns have the names in `slipscale.analysis.reading.foreign.columns`.
    mapping : TableMapping
    sources : sequence of Source
    problems : Problems
        Collects the notes.
    """

    frame: pd.DataFrame
    mapping: TableMapping
    sources: Sequence[Source]
    problems: Problems

    def of(self, frame: pd.DataFrame) -> Rows:
        """Return these rows with another frame."""
        return replace(self, frame=frame)


def unchanged(rows: Rows) -> pd.DataFrame:
    """Return the rows of a table with one answer per row."""
    return rows.frame


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """How the rows of a layout become trials.

    Parameters
    ----------
    everything : bool
        Whether all columns of the file are read, because the file names the items or the people.
    reshape : callable
        Function that returns one row per answer, or per count of answers.
    convert : callable
        Function that returns the trials, keyed by kind.
    """

    everything: bool = False
    reshape: Callable[[Rows], pd.DataFrame] = unchanged
    convert: Callable[[Rows], Mapping[str, pd.DataFrame]]
