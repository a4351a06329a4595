"""Read several tables; those with the same header are parsed at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from slipscale.analysis.reading.delimited import NUMBERS, Problems, Source
from slipscale.analysis.reading.table_by_hand import (
    Opened,
    Request,
    cells_of,
    converted,
    is_marked,
    open_table,
)
from slipscale.analysis.reading.table_lines import Lines
from slipscale.faults import UserError


def read_together(
    paths: Sequence[Path], request: Request, root: Path, problems: Problems
) -> tuple[dict[int, tuple[pd.DataFrame, Source]], dict[int, UserError]]:
    """Read tables as `slipscale.analysis.reading.table_by_hand.read_table` does.

    Returns
    -------
    read : dict
        Rows and source of each file that can be read, keyed by its index in ``paths``. The column
        ``file`` is the index among these files.
    faults : dict
        Errors of the other files.
    """
    notes = [Problems() for _ in paths]
    opened: dict[int, Opened] = {}
    faults: dict[int, UserError] = {}
    read: dict[int, tuple[pd.DataFrame, Source]] = {}
    for place, path in enumerate(paths):
        try:
            opened[place] = open_table(path, request, notes[place], root)
        except UserError as error:
            faults[place] = error
    parsed = _parsed(opened, request)
    for place, file in opened.items():
        try:
            frame = converted(file, request, notes[place], parsed.get(place))
        except UserError as error:
            faults[place] = error
            continue
        frame["file"] = len(read)
        read[place] = frame, file.source
        problems.sentences += notes[place].sentences
    return read, dict(sorted(faults.items()))


def _parsed(files: Mapping[int, Opened], request: Request) -> dict[int, pd.DataFrame]:
    """Parse text tables with the same header at once; return the cells of each.

    A file is not returned, and has to be parsed separately, if it contains quotation marks or
    numbers with separators, or if the joined table has other cells in columns of numbers.
    """
    alike: dict[tuple[bytes, str], dict[int, Lines]] = {}
    for place, file in files.items() if len(files) > 1 else ():
        lines = file.table
        if isinstance(lines, Lines) and not (file.quoted or request.everything or is_marked(lines)):
            alike.setdefault((lines.header, lines.separator), {})[place] = lines
    found: dict[int, pd.DataFrame] = {}
    for group in alike.values():
        if len(group) == 1:
            continue
        try:
            rows = cells_of([*group.values()], request, files[next(iter(group))].path, marked=False)
        except UserError:
            continue  # the file at fault is found when it is parsed separately
        if any(rows[name].dtype.name not in NUMBERS for name in request.numbers if name in rows):
            continue
        end = 0
        for place, lines in group.items():
            begin, end = end, end + len(lines.places)
            found[place] = rows.iloc[begin:end].reset_index(drop=True)
    return found
