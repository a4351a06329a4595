"""Read the columns that a mapping names, from a table or from the tables in a BIDS folder."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.reading.delimited import Problems, Source, read_tables
from slipscale.analysis.reading.foreign.columns import NUMBERS, OURS
from slipscale.analysis.reading.table_by_hand import read_table
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reading.mapping import TableMapping

#: Names of tables in a folder, which contain the participant label.
BIDS_TABLE = re.compile(r"sub-(?P<sub>[^_]+)(_ses-(?P<ses>[^_]+))?_.*_(beh|events)\.tsv")
BIDS_LABELS = {"participant": "sub", "session": "ses"}


def read_rows(
    path: Path, mapping: TableMapping, problems: Problems
) -> tuple[pd.DataFrame, list[Source]]:
    """Read the rows that ``only`` selects; return them with the columns in the mapping."""
    frame, sources = (_folder if path.is_dir() else _table)(path, mapping, problems)
    return _chosen(frame, mapping, path), sources


def _table(
    path: Path, mapping: TableMapping, problems: Problems
) -> tuple[pd.DataFrame, list[Source]]:
    columns = mapping.columns.model_dump(exclude_none=True)
    figures = [columns[name] for name in NUMBERS if name in columns] + list(mapping.levels)
    words = [column for name, column in columns.items() if name not in NUMBERS]
    words += [column for column in mapping.table.only if column not in (*words, *figures)]
    frame, source = read_table(
        path,
        required=(*words, *figures),
        numbers=figures,
        words=words,
        identifier=mapping.columns.participant,
        problems=problems,
        decimal=mapping.table.decimal,
        sheet=mapping.table.sheet,
    )
    return frame, [source]


def _folder(
    folder: Path, mapping: TableMapping, problems: Problems
) -> tuple[pd.DataFrame, list[Source]]:
    """Read the tables in a BIDS folder, and take participants from file names if necessary."""
    entries = [
        (path, match)
        for path in sorted(folder.glob("sub-*/**/*.tsv"))
        if (match := BIDS_TABLE.fullmatch(path.name))
    ]
    if not entries:
        raise UserError(
            f"{folder}: no data found; expected files like sub-01/beh/sub-01_task-loudness_beh.tsv "
            "or ..._events.tsv"
        )
    columns = mapping.columns.model_dump(exclude_none=True)
    from_names = {
        columns[name]: label
        for name, label in BIDS_LABELS.items()
        if columns.get(name) in (OURS[name], label)
    }
    needed = [c for c in (*columns.values(), *mapping.levels) if c not in from_names]
    needed += [column for column in mapping.table.only if column not in needed]
    frame, sources = read_tables(
        [path for path, _ in entries],
        folder,
        required=needed,
        columns=needed,
        problems=problems,
    )
    for column, label in from_names.items():
        found = pd.Series([match[label] or "" for _, match in entries], dtype="str")
        prefix = f"{label}-" if label == "sub" else ""
        frame[column] = (prefix + found).iloc[frame["file"].to_numpy()].to_numpy()
    for name in ("group", "answer", "block"):
        if name in columns:
            frame[columns[name]] = frame[columns[name]].astype("str")
    return frame, sources


def _chosen(frame: pd.DataFrame, mapping: TableMapping, path: Path) -> pd.DataFrame:
    """Select the rows that match the values in the mapping's ``only``."""
    for column, value in mapping.table.only.items():
        found = frame[column].astype("str").str.strip()
        kept = frame[found == value.strip()]
        if not len(kept):
            values = ", ".join(sorted(found.dropna().unique())[:12]) or "nothing"
            raise UserError(f"{path}: no row has '{value}' in column {column}; found {values}")
        frame = kept.reset_index(drop=True)
    return frame
