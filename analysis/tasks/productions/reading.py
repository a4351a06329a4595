"""Trials of magnitude production, from a data set."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from slipscale.analysis.reading.cleaning import labels
from slipscale.analysis.reading.labelled_tasks import TaskTrials

if TYPE_CHECKING:
    import re
    from collections.abc import Sequence
    from pathlib import Path

    import pandas as pd

    from slipscale.analysis.reading.delimited import Problems, Source

    Entries = Sequence[tuple[Path, re.Match[str]]]
from slipscale.analysis.reading.magnitude_trials import (
    COMMON,
    above_zero,
    answered,
    empty,
    main_trials,
)

PRODUCED = ("produced_um_pp", "number", "modulus", "standard_um_pp")


PRODUCTIONS = (*COMMON, "began", "bound", *PRODUCED)


def read_productions(
    entries: Entries, folder: Path, problems: Problems, counts: dict[str, int]
) -> tuple[pd.DataFrame, list[Source]]:
    """Return the answered main trials of production: columns `PRODUCTIONS`, all above 0."""
    if not entries:
        return empty(PRODUCTIONS), []
    frame, sources = main_trials(
        entries,
        folder,
        kind="production",
        required=PRODUCED,
        words=("began", "bound"),
        problems=problems,
        counts=counts,
    )
    for name in ("began", "bound"):
        frame[name] = labels(frame, name, "").astype(str)
    for name, what in (("produced_um_pp", "productions"), ("number", "numbers to be produced")):
        frame[name] = above_zero(frame[name], what, problems)
    return answered(frame, PRODUCTIONS, "production", PRODUCED, counts), sources


TRIALS = TaskTrials(
    name="productions",
    counted="production",
    title="production",
    belongs=lambda header: header.issuperset(PRODUCED),
    read=read_productions,
    empty=partial(empty, PRODUCTIONS),
)
