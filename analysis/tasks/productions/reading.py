"""Read magnitude-production trials from a data set: amplitudes and numbers above 0."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.task_tables import above_zero, task_trials

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.reading.delimited import Problems

PRODUCED = ("produced_um_pp", "number", "modulus", "standard_um_pp")
POSITIVE = {"produced_um_pp": "productions", "number": "numbers to be produced"}


def _productions(frame: pd.DataFrame, problems: Problems) -> pd.DataFrame:
    return frame.assign(
        **{name: above_zero(frame[name], what, problems) for name, what in POSITIVE.items()}
    )


TRIALS = task_trials(
    "productions",
    "production",
    marks=PRODUCED,
    numeric=PRODUCED,
    words=("began", "bound"),
    columns=("began", "bound", *PRODUCED),
    needed=PRODUCED,
    derive=_productions,
)
