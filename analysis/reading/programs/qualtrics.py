"""Read Qualtrics CSV and TSV files, which have three header lines.

The headers contain names, questions and import IDs. A file is recognised by its third record, in
which each cell is an ``ImportId``. Preview responses are not omitted; to omit them, use ``--only``
with ``Status`` or ``DistributionChannel``.
"""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from slipscale.analysis.reading.dialect import decoded
from slipscale.analysis.reading.programs.records import records, table_of
from slipscale.faults import UserError

IMPORT_ID = '{"ImportId":'
HEADERS = 3


def recognises(head: str, path: Path) -> bool:
    """Return whether a file with this beginning was written by Qualtrics."""
    if "ImportId" not in head:
        return False
    try:
        found = records(head.rpartition("\n")[0] or head, path)
    except UserError:
        return False
    return len(found) >= HEADERS and all(
        cell.replace(" ", "").startswith(IMPORT_ID) for cell in found[HEADERS - 1][1]
    )


def read(content: bytes, path: Path) -> pd.DataFrame:
    """Read one row per response, with all cells as text and column names from the first line."""
    (_, names), *rows = records(decoded(content, path)[0].decode("utf-8"), path)
    return table_of(names, rows[HEADERS - 1 :])
