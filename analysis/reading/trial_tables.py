"""Declare the columns that the analysis reads from each task's table.

All column names for reading are declared in this module. Importing this module fails if a name is
not in the schema, so that renamed columns are noticed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from slipscale.experiments.dataset.measured import COEFFICIENT, MEASURED
from slipscale.experiments.dataset.schema import (
    DAMAGED,
    FLAG_SEPARATOR,
    PARTICIPANT,
    PRACTICE,
    VOIDED,
    columns,
)
from slipscale.experiments.protocol_parts.base import Protocol
from slipscale.experiments.protocols import descending_difference, magnitude_estimation
from slipscale.experiments.steps.columns import Column
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

#: Columns that identify a run. Participant, session and run are read from file names in a data set,
#: and from columns in other tables.
IDENTITY = (PARTICIPANT, "session", "run")
#: Prefix for the columns of study factors in the analysis.
FACTOR = "factor: "
#: Columns that identify the block or series. Trial numbers may restart in each block or series.
BLOCK, SERIES = "block", "series"


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialTable:
    """Columns that the analysis reads from a task's table.

    Parameters
    ----------
    task : str
        Task label in file names.
    required : tuple of str
        Columns that the analysis requires.
    numbers : tuple of str
        Other numeric columns, which may be absent or empty.
    words : tuple of str
        Other columns of labels or text, which may be absent or empty.
    """

    task: str
    required: tuple[str, ...]
    numbers: tuple[str, ...]
    words: tuple[str, ...]

    @property
    def columns(self) -> tuple[str, ...]:
        """All columns that the analysis reads. Other columns in the files are ignored."""
        return (*IDENTITY, *self.required, *self.numbers, *self.words)


def trial_table(
    protocol: Protocol, *, required: tuple[str, ...], optional: tuple[str, ...]
) -> TrialTable:
    """Declare the columns to read from a protocol's table.

    Raises
    ------
    LookupError
        If the schema declares no such column.
    """
    in_names = PLATE_AMPLITUDE.in_code
    declared = {in_names[name]: column for name, column in columns(protocol, MEASURED).items()}
    unknown = [name for name in (*required, *optional) if name not in declared]
    if unknown:
        raise LookupError(
            f"the analysis reads {', '.join(unknown)} of task {protocol.task}, which its schema "
            f"does not declare; it declares {', '.join(declared)}"
        )
    return TrialTable(
        task=protocol.task,
        required=required,
        numbers=tuple(name for name in optional if declared[name].kind == "number"),
        words=tuple(name for name in optional if declared[name].kind != "number"),
    )


def free_text(declared: Mapping[str, Column]) -> tuple[str, ...]:
    """Return the columns that contain free text."""
    return tuple(name for name, column in declared.items() if column.kind == "text")


ESTIMATION = trial_table(
    magnitude_estimation.PROTOCOL,
    required=("level", "estimate"),
    optional=(
        *("trial", BLOCK, "response_time", "scale_top", "modulus"),
        COEFFICIENT,
        *("phase", "flag", "texture"),
    ),
)
DIFFERENCE = trial_table(
    descending_difference.PROTOCOL,
    required=("level_before", "level", "difference_felt"),
    optional=(
        *("trial", SERIES, "step", "confidence", "response_time"),
        *("phase", "flag", "catch", "verbal_report"),
    ),
)
#: Columns of the amplitudes before and after a step.
STEP_AMPLITUDES = DIFFERENCE.required[:2]
#: Columns of names and words, in which 01 is not 1 and "NA" may be a name or an answer.
FREE_TEXT = (
    *IDENTITY,
    *free_text(columns(magnitude_estimation.PROTOCOL)),
    *free_text(columns(descending_difference.PROTOCOL)),
)


def set_aside(frame: pd.DataFrame) -> tuple[pd.Series[bool], pd.Series[bool]]:
    """Return masks of the practice trials, and of the main trials that were voided or damaged."""
    practice = frame["phase"].astype(str) == PRACTICE
    return practice, has_flag(frame, VOIDED, DAMAGED) & ~practice


def has_flag(frame: pd.DataFrame, *codes: str) -> pd.Series[bool]:
    """Return which rows have at least one of the given flags."""
    flags = frame["flag"].astype("category")
    hits = [
        bool(set(codes) & set(str(name).split(FLAG_SEPARATOR))) for name in flags.cat.categories
    ]
    lookup = np.array([*hits, False])
    return pd.Series(lookup[flags.cat.codes], index=frame.index)


def factor_columns(trials: pd.DataFrame) -> list[str]:
    """Return the columns with the levels of factors."""
    return [name for name in map(str, trials.columns) if name.startswith(FACTOR)]
