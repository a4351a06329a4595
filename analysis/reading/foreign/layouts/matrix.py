"""Reshape square tables: wins of items against each other, similarities or dissimilarities.

The first column and the header contain the names of the items. In a table of wins, each cell is
the number of times that the row's item was chosen over the column's. Similarities become
dissimilarities by subtraction from the largest one.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from slipscale.analysis.reading.cleaning import as_numbers
from slipscale.analysis.reading.foreign.layouts import pairs
from slipscale.analysis.reading.foreign.layouts.layout import Rows
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError

#: Columns that are no items.
OTHERS = ("file", "line", PARTICIPANT, "session", "run")


def reshape(rows: Rows) -> pd.DataFrame:
    """Return one row per cell with the columns ``first``, ``second`` and ``value``.

    Raises
    ------
    UserError
        If a table is not square, its rows and columns have different names, or a cell is not a
        number.
    """
    columns = [name for name in rows.frame.columns if name not in OTHERS]
    keys = [name for name in rows.frame.columns if name not in columns and name != "line"]
    parts = []
    for _, table in rows.frame.groupby(keys, sort=False, dropna=False):
        labels, items = _named(table, columns, rows)
        cells = table[items].apply(lambda column: as_numbers(column)[1]).to_numpy(float)
        one, other = np.nonzero(~np.isnan(cells) & ~np.eye(len(items), dtype=bool))
        symmetric = np.array_equal(cells, cells.T, equal_nan=True)
        if symmetric and rows.mapping.shape.matrix != "wins":
            one, other = one[one < other], other[one < other]
        part = table.iloc[one][[*keys, "line"]].reset_index(drop=True)
        value = cells[one, other]
        if rows.mapping.shape.matrix == "similarities":
            value = np.nanmax(cells) - value
        parts.append(part.assign(first=labels[one], second=labels[other], value=value))
    return pd.concat(parts, ignore_index=True)


def _named(
    table: pd.DataFrame, columns: list[str], rows: Rows
) -> tuple[np.ndarray[tuple[int], np.dtype[np.object_]], list[str]]:
    """Return the items of the rows, and the columns in the same order."""
    if len(columns) == len(table) and not rows.mapping.shape.header:
        return np.array(columns, object), columns
    first, *items = columns
    labels = table[first].astype(str).str.strip()
    if sorted(labels) != sorted(items):
        raise UserError(
            "{file}: {rows} rows and {columns} columns with different names; expected a square "
            "table whose first column has the names of the other columns (or --no-header, and only "
            "numbers)",
            file=rows.sources[int(table["file"].iloc[0])].name,
            rows=len(table),
            columns=len(items),
        )
    return labels.to_numpy(object), labels.tolist()


def convert(rows: Rows) -> Mapping[str, pd.DataFrame]:
    """Return comparisons of pairs (wins), or their dissimilarities."""
    frame = rows.frame
    if rows.mapping.shape.matrix != "wins":
        return pairs.rated(rows.of(frame.rename(columns={"value": "dissimilarity"})))
    wrong = (frame["value"] < 0) | (frame["value"] % 1 != 0)
    if wrong.any():
        raise UserError(
            "{file}, line {line}: {value:g} wins; expected whole numbers of 0 or more",
            file=rows.sources[int(frame.loc[wrong, "file"].iloc[0])].name,
            line=int(frame.loc[wrong, "line"].iloc[0]),
            value=frame.loc[wrong, "value"].iloc[0],
        )
    each = frame.loc[frame.index.repeat(frame["value"].astype(int))].reset_index(drop=True)
    return pairs.compared(rows, each, ("first", "second"), np.ones(len(each)))
