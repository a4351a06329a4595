"""Trials of ratio judgements, from a data set."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from slipscale.analysis.reading.labelled_tasks import TaskTrials
from slipscale.analysis.reading.quantity import AMPLITUDE_DECIMALS

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

JUDGED = ("ratio", "comparison_um_pp", "standard_um_pp")


RATIOS = (*COMMON, *JUDGED)


def read_ratios(
    entries: Entries, folder: Path, problems: Problems, counts: dict[str, int]
) -> tuple[pd.DataFrame, list[Source]]:
    """Return the answered main trials of ratio judgements: columns `RATIOS`, ratios above 0."""
    if not entries:
        return empty(RATIOS), []
    frame, sources = main_trials(
        entries, folder, kind="ratio", required=JUDGED, problems=problems, counts=counts
    )
    for name in JUDGED[1:]:
        frame[name] = frame[name].round(AMPLITUDE_DECIMALS)
    frame["ratio"] = above_zero(frame["ratio"], "ratios", problems)
    return answered(frame, RATIOS, "ratio", JUDGED, counts), sources


TRIALS = TaskTrials(
    name="ratios",
    counted="ratio",
    title="ratio",
    belongs=lambda header: header.issuperset(JUDGED),
    read=read_ratios,
    empty=partial(empty, RATIOS),
)
