"""Read Qualtrics CSV and TSV files, which have three headers: names, questions, import IDs.

A file is recognised as Qualtrics if every cell of its third record is an ``ImportId``. Preview
responses are kept; they are marked in ``Status`` or ``DistributionChannel``, and ``--only`` can
omit them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.dialect import decoded
from slipscale.analysis.reading.programs.records import head_of, records, table_of
from slipscale.faults import UserError

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

IMPORT_ID = '{"ImportId":'
HEADERS = 3


def recognises(content: bytes, path: Path) -> bool:
    """Return whether a file was written by Qualtrics."""
    head = head_of(content, path)
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
    """Return one row per response, all cells as text, with columns named by the first header."""
    (_, names), *rows = records(decoded(content, path)[0].decode("utf-8"), path)
    return table_of(names, rows[HEADERS - 1 :])
