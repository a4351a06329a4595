"""Read the tables of a protocol, with the columns that its schema declares."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from slipscale.analysis.reading.delimited import Problems, Source, read_tables
from slipscale.analysis.reading.labelled_tasks import Entries
from slipscale.analysis.reading.trial_tables import IDENTITY, TrialTable


def read_protocol(
    table: TrialTable, entries: Entries, folder: Path, problems: Problems
) -> tuple[pd.DataFrame, list[Source]]:
    """Read the rows of a protocol's tables, with participant, session and run."""
    frame, sources = read_tables(
        [path for path, _ in entries],
        folder,
        required=table.required,
        columns=table.columns,
        problems=problems,
    )
    place = frame["file"].to_numpy()
    labels = (
        [f"sub-{match['sub']}" for _, match in entries],
        [match["ses"] or "" for _, match in entries],
        [match["run"] or "1" for _, match in entries],
    )
    for name, values in zip(IDENTITY, labels, strict=True):
        categories, codes = np.unique(values, return_inverse=True)
        frame[name] = pd.Categorical.from_codes(codes[place], categories=categories.tolist())
    return frame, sources
