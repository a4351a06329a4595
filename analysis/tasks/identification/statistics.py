"""Compute the information transferred in an identification task.

Information is the mutual information between presented and named surface, in bits (Miller 1956,
Psychological Review 63, 81-97). With an information of I bits, 2^I surfaces could be identified
without error.

Information is overestimated if there are few trials. The first-order Miller-Madow correction
(Miller 1955, in Information Theory in Psychology, 95-100) adds (occupied cells - 1) / (2 n ln 2) to
each entropy. Corrected values are limited to the entropy of the presented surfaces. Individual
values remain biased, by an amount that depends on the unknown confusions, and that does not shrink
with more participants. In simulations, 95 % intervals of their mean contained the true value in
only 13 to 73 % of studies, so the mean has no interval. The report
contains a note if participants have fewer than five trials per cell of the confusion matrix on
average.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log

import numpy as np
import pandas as pd

from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.surface_labels import numbers_first, plain
from slipscale.analysis.reading.task_tables import by_task, task_trials
from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.statistics.mean_over_participants import (
    EstimatedMean,
    estimated_mean,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Inputs, Named, Statistic
from slipscale.experiments.dataset.schema import PARTICIPANT

ITEMS = ("presented", "named")


def _known(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    """Add the column ``right``, which is NaN if a surface or an answer is missing."""
    whole = (frame["presented"] != "") & (frame["named"] != "")
    right = (frame["presented"] == frame["named"]).astype(float)
    return frame.assign(**{name: frame[name].map(plain) for name in ITEMS}).assign(
        right=right.where(whole)
    )


TRIALS = task_trials(
    "identifications",
    "identification",
    marks=ITEMS,
    numeric=(),
    words=ITEMS,
    columns=(*ITEMS, "right"),
    needed=("right",),
    derive=_known,
)


#: With fewer trials per cell, corrected values are still too large (rule of thumb).
TRIALS_PER_CELL = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskIdentification:
    """Results for one task.

    Parameters
    ----------
    task : str
    participants, answers : int
    items : tuple of str
    table : tuple of tuple of int
        Counts of all participants' answers: rows are presented items, columns are named items.
    information_bits, corrected_bits : float
        Information transferred, computed from ``table`` without and with the Miller-Madow
        correction.
    most_bits : float
        Information in the presented items, which is the maximum that can be transferred.
    mean_information_bits : float
        Mean of the corrected values of individual participants.
    share_right : EstimatedMean or NotComputed
        Mean of participants' proportions of correct answers.
    trials_per_cell : float
        Mean number of trials per cell of a participant's confusion matrix.
    """

    task: str
    participants: int
    answers: int
    items: tuple[str, ...]
    table: tuple[tuple[int, ...], ...]
    information_bits: float
    corrected_bits: float
    most_bits: float
    mean_information_bits: float
    share_right: EstimatedMean | NotComputed
    trials_per_cell: float


def entropy_bits(counts: Array) -> tuple[float, float]:
    """Return the entropy of counts, without and with the Miller-Madow correction.

    >>> [round(each, 3) for each in entropy_bits(np.array([5.0, 5.0, 0.0]))]
    [1.0, 1.072]
    """
    shares = counts[counts > 0] / counts.sum()
    plain = float(-(shares * np.log2(shares)).sum())
    return plain, plain + (len(shares) - 1) / (2 * float(counts.sum()) * log(2))


def information_bits(table: Array) -> tuple[float, float]:
    """Compute transferred information from a table of counts, without and with correction.

    >>> [round(each, 3) for each in information_bits(np.diag([50.0, 50.0]))]
    [1.0, 1.0]
    """
    (rows, rows_), (columns, columns_), (joint, joint_) = (
        entropy_bits(each) for each in (table.sum(axis=1), table.sum(axis=0), table.ravel())
    )
    return rows + columns - joint, min(rows_ + columns_ - joint_, rows)


def identifications(inputs: Inputs) -> tuple[TaskIdentification, ...] | NotComputed:
    """Return the information transferred in each task."""
    trials = inputs.data.of(TRIALS)
    if not len(trials):
        return NotComputed("no identifications")
    confidence = inputs.data.choices.confidence
    return tuple(_task(task, rows, confidence) for task, rows in by_task(trials))


def _task(task: str, rows: pd.DataFrame, confidence: float) -> TaskIdentification:
    items = sorted({*rows["presented"], *rows["named"]}, key=numbers_first)

    def counted(own: pd.DataFrame) -> Array:
        table = pd.crosstab(own["presented"], own["named"])
        return table.reindex(index=items, columns=items, fill_value=0).to_numpy(float)

    tables = [counted(own) for _, own in rows.groupby(PARTICIPANT, observed=True)]
    everybody = np.sum(tables, axis=0)
    plain, corrected = information_bits(everybody)
    shares = np.array([np.trace(each) / each.sum() for each in tables])
    return TaskIdentification(
        task=task,
        participants=len(tables),
        answers=len(rows),
        items=tuple(items),
        table=tuple(tuple(map(int, row)) for row in everybody),
        information_bits=plain,
        corrected_bits=corrected,
        most_bits=entropy_bits(everybody.sum(axis=1))[0],
        mean_information_bits=float(np.mean([information_bits(each)[1] for each in tables])),
        share_right=estimated_mean(shares, confidence, (0.0, 1.0)),
        trials_per_cell=len(rows) / len(tables) / len(items) ** 2,
    )


class _Identification(Statistic[tuple[TaskIdentification, ...]]):
    key = "identification"
    meaning = "identification: confusion matrix and information transferred"
    methods = (
        "Information transferred is the mutual information between the presented and the named "
        "stimulus [[miller1956]], with the Miller–Madow bias correction."
    )
    headlines = (Named("*.corrected_bits", "{0}: information transferred, in bits"),)

    compute = staticmethod(identifications)


IDENTIFICATION = _Identification()
