"""Trials of the visual analogue scale, from a data set."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from slipscale.analysis.reading.cleaning import labels
from slipscale.analysis.reading.labelled_tasks import TaskTrials
from slipscale.analysis.reading.quantity import AMPLITUDE_DECIMALS

if TYPE_CHECKING:
    import re
    from collections.abc import Sequence
    from pathlib import Path

    import pandas as pd

    from slipscale.analysis.reading.delimited import Problems, Source

    Entries = Sequence[tuple[Path, re.Match[str]]]
from slipscale.analysis.reading.magnitude_trials import COMMON, answered, empty, main_trials

#: Columns that make a table one of ratings on a line, of ratios, or of productions.
RATED = ("rating", "amplitude_um_pp", "cursor_start")


LENGTH = 100.0  # of the line


RATINGS = (*COMMON, "surface", "resolution", *RATED)


def read_ratings(
    entries: Entries, folder: Path, problems: Problems, counts: dict[str, int]
) -> tuple[pd.DataFrame, list[Source]]:
    """Return the answered main trials on a line.

    Returns
    -------
    DataFrame, list of Source
        Columns `RATINGS`: ``surface`` is the texture's name, or the amplitude (µm peak to peak);
        a texture has no ``amplitude_um_pp``. Catch trials are marked.
    """
    if not entries:
        return empty(RATINGS), []
    frame, sources = main_trials(
        entries,
        folder,
        kind="rating",
        required=RATED,
        optional=("resolution",),
        words=("texture",),
        problems=problems,
        counts=counts,
    )
    beyond = frame["rating"] > LENGTH
    if beyond.any():
        problems.add(
            f"{int(beyond.sum())} ratings are above {LENGTH:g}, the right end of the line; they "
            "are left out"
        )
    frame["rating"] = frame["rating"].mask(beyond)
    frame["amplitude_um_pp"] = frame["amplitude_um_pp"].round(AMPLITUDE_DECIMALS)
    texture = labels(frame, "texture", "").astype(str)
    plain = frame["amplitude_um_pp"].map("{:g}".format)
    frame["surface"] = texture.where(texture != "", plain)
    frame["amplitude_um_pp"] = frame["amplitude_um_pp"].where(texture == "")
    return answered(frame, RATINGS, "rating", ("rating",), counts), sources


TRIALS = TaskTrials(
    name="ratings",
    counted="rating",
    title="rating",
    belongs=lambda header: header.issuperset(RATED),
    read=read_ratings,
    empty=partial(empty, RATINGS),
)
