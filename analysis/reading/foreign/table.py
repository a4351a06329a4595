"""Convert a table from another laboratory to Slipscale's format.

A mapping defines the meaning of the columns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.reading.cells import listed
from slipscale.analysis.reading.cleaning import tidied
from slipscale.analysis.reading.delimited import Problems, Source
from slipscale.analysis.reading.foreign.columns import GROUP, OURS
from slipscale.analysis.reading.foreign.files import read_rows
from slipscale.analysis.reading.foreign.layouts.layout import Rows
from slipscale.analysis.reading.foreign.layouts.table import layout_of
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reading.meaning.mapping import TableMapping


@dataclass(frozen=True, slots=True, kw_only=True)
class ForeignTable:
    """A table from another laboratory, converted to Slipscale's format.

    Parameters
    ----------
    trials : Mapping
        Trials, keyed by kind (`slipscale.analysis.reading.foreign.layouts.layout`).
    participants : DataFrame
        All participants, with their ``group`` if the table contains groups.
    sources : tuple of Source
        The files.
    left_out : tuple of str
        Names of files that could not be read.
    """

    trials: Mapping[str, pd.DataFrame]
    participants: pd.DataFrame
    sources: tuple[Source, ...]
    left_out: tuple[str, ...] = ()


def read_foreign(
    paths: Sequence[Path], mapping: TableMapping, problems: Problems, task: str | None = None
) -> ForeignTable:
    """Read tables, or the tables of a task in a BIDS folder, using a mapping.

    Raises
    ------
    UserError
        If no table can be read (see `slipscale.analysis.reading.table_by_hand.read_table`), a
        level is below 0, a participant is in two groups, ``only`` matches no rows, or the task must
        be selected.
    """
    layout, named = layout_of(mapping), mapping.columns.named
    frame, sources, left_out = read_rows(paths, mapping, layout, problems, task)
    problems.titles = {OURS[name]: column for name, column in named.items()}
    frame = frame.rename(columns={column: OURS[name] for name, column in named.items()})
    rows = Rows(frame=frame, mapping=mapping, sources=sources, problems=problems)
    frame = layout.reshape(rows)
    return ForeignTable(
        trials=layout.convert(rows.of(frame)),
        participants=_groups(frame, paths[0], problems),
        sources=tuple(sources),
        left_out=left_out,
    )


def _groups(frame: pd.DataFrame, path: Path, problems: Problems) -> pd.DataFrame:
    """Return all participants, with their group if the table has groups.

    Raises
    ------
    UserError
        If a participant is in two groups, probably because the group column contains conditions.
    """
    who = tidied(frame[PARTICIPANT]).astype("str")
    if GROUP not in frame:
        return pd.DataFrame({PARTICIPANT: sorted(who.dropna().unique())})
    pairs = pd.DataFrame({PARTICIPANT: who, GROUP: tidied(frame[GROUP]).astype("str")})
    pairs = pairs.dropna().drop_duplicates().sort_values([PARTICIPANT, GROUP], ignore_index=True)
    twice = pairs[pairs.duplicated(PARTICIPANT, keep=False)]
    if len(twice):
        first = twice.iloc[0][PARTICIPANT]
        both = " and ".join(twice.loc[twice[PARTICIPANT] == first, GROUP][:2])
        column = problems.title(GROUP)
        raise UserError(
            "{path}: participant {first} has {both} in column {column}; expected one group per "
            "participant (to analyse a single condition, use --only {column}=...)",
            path=path,
            first=first,
            both=both,
            column=column,
        )
    sizes = pairs[GROUP].value_counts()
    alone = sorted(sizes.index[sizes == 1])
    if len(alone) == 1:
        problems.add(
            f"Group '{alone[0]}' has only one participant, so its spread cannot be estimated."
        )
    elif alone:
        problems.add(
            f"The spread cannot be estimated in groups of one participant: {listed(alone)}."
        )
    return pairs
