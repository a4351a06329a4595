"""Convert a table from another laboratory to Slipscale's format.

A mapping defines the meaning of the columns.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.reading.cells import listed
from slipscale.analysis.reading.cleaning import (
    clean_estimates,
    empty_differences,
    empty_estimates,
    in_order,
    labels,
    numbers,
    tidied,
    told_apart,
)
from slipscale.analysis.reading.delimited import Problems, Source
from slipscale.analysis.reading.foreign.answers import read_answers, read_pairs
from slipscale.analysis.reading.foreign.columns import (
    ANSWER,
    GROUP,
    OURS,
    REFERENCE,
    RESPONSE,
    STIMULUS,
)
from slipscale.analysis.reading.foreign.files import read_rows
from slipscale.analysis.reading.table_lines import listed_lines
from slipscale.analysis.reading.trial_tables import FACTOR
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reading.mapping import TableMapping

LOGARITHMIC = re.compile(r"\bdb|decibel|\blog", re.IGNORECASE)


@dataclass(frozen=True, slots=True, kw_only=True)
class ForeignTable:
    """A table from another laboratory, converted to Slipscale's format.

    Parameters
    ----------
    estimates, differences : DataFrame
        See `slipscale.analysis.reading.cleaning`.
    choices : DataFrame
        Forced-choice trials, or comparisons with stimuli above and below a reference; see
        `slipscale.analysis.tasks.thresholds.reading`. Only one of ``estimates``, ``differences``,
        ``choices`` and ``pairs`` contains rows.
    pairs : DataFrame
        Ratings of pairs; see `slipscale.analysis.tasks.similarity.reading`.
    participants : DataFrame
        All participants, with their ``group`` if the table contains groups.
    sources : tuple of Source
        The files.
    """

    estimates: pd.DataFrame
    differences: pd.DataFrame
    choices: pd.DataFrame
    participants: pd.DataFrame
    sources: tuple[Source, ...]
    pairs: pd.DataFrame = field(default_factory=pd.DataFrame)


def read_foreign(
    path: Path, mapping: TableMapping, problems: Problems, task: str | None = None
) -> ForeignTable:
    """Read a table, or the tables of a task in a BIDS folder, using a mapping.

    Raises
    ------
    UserError
        If the table cannot be read (see `slipscale.analysis.reading.table_by_hand.read_table`), a
        level is below 0, a participant is in two groups, ``only`` matches no rows, or the task must
        be selected.
    """
    frame, sources = read_rows(path, mapping, problems, task)
    if mapping.levels:
        frame = _long(frame, mapping)
    named = {name: column for name, column in mapping.columns.model_dump().items() if column}
    frame = frame.rename(columns={column: OURS[name] for name, column in named.items()})
    problems.titles = {OURS[name]: column for name, column in named.items()}
    if mapping.of_pairs:
        return ForeignTable(
            estimates=empty_estimates(),
            differences=empty_differences(),
            choices=pd.DataFrame(),
            pairs=read_pairs(frame, sources, problems),
            participants=_groups(frame, path, problems),
            sources=tuple(sources),
        )
    frame = _of_trials(frame, mapping, problems, path)
    for name in (PARTICIPANT, "factor"):
        frame = _without_blanks(frame, name, sources, problems)
    frame = in_order(frame, problems)
    _check_levels(frame, mapping, sources, problems)
    groups = _groups(frame, path, problems)
    quantity = mapping.quantity
    estimates, differences = empty_estimates(), empty_differences()
    choices = pd.DataFrame()
    if mapping.of_answers:
        differences, choices = read_answers(frame, mapping, sources, problems)
    else:
        estimates = clean_estimates(frame, sources, problems, quantity, factors=["factor"])
    named = {FACTOR + "factor": f"{FACTOR}{mapping.columns.factor}"}
    estimates, choices = estimates.rename(columns=named), choices.rename(columns=named)
    if mapping.stimulus.in_unit:
        for part, columns in (
            (estimates, (STIMULUS,)),
            (differences, (STIMULUS, REFERENCE)),
            (choices, ("track_level", "standard_level")),
        ):
            for name in columns if len(part) else ():
                part[name] = told_apart(part[name] * mapping.stimulus.factor, quantity)
    return ForeignTable(
        estimates=estimates,
        differences=differences,
        choices=choices,
        participants=groups,
        sources=tuple(sources),
    )


def _long(frame: pd.DataFrame, mapping: TableMapping) -> pd.DataFrame:
    """Convert a wide table to one row per response.

    A wide table has one row per participant and one column per level.
    """
    kept = [name for name in frame.columns if name not in mapping.levels]
    parts = []
    for column, level in mapping.levels.items():
        part = frame[kept].copy()
        part[STIMULUS], part[RESPONSE] = level, frame[column]
        parts.append(part)
    # If one column is text, all are read as text, so that cells are parsed in the same way.
    texts = any(not pd.api.types.is_numeric_dtype(part[RESPONSE]) for part in parts)
    if texts:
        parts = [part.astype({RESPONSE: "str"}) for part in parts]
    return pd.concat(parts, ignore_index=True).sort_values(
        ["file", "line"], kind="stable", ignore_index=True
    )


def _of_trials(
    frame: pd.DataFrame, mapping: TableMapping, problems: Problems, path: Path
) -> pd.DataFrame:
    """Omit rows with neither stimulus nor response, which PsychoPy writes for every routine."""
    response = "n" if mapping.columns.n else ANSWER if mapping.of_answers else RESPONSE
    blank = frame[STIMULUS].isna() & frame[response].isna()
    if blank.any():
        problems.add(
            f"{path.name}: {int(blank.sum())} rows with neither stimulus nor response were skipped"
        )
    return frame[~blank].reset_index(drop=True)


def _without_blanks(
    frame: pd.DataFrame, name: str, sources: Sequence[Source], problems: Problems
) -> pd.DataFrame:
    """Omit the rows without a label in a column, and report their lines."""
    blank = labels(frame, name, "").astype(str) == ""
    if name not in frame or not blank.any():
        return frame
    for file, rows in frame[blank].groupby("file"):
        problems.add(
            f"{sources[int(str(file))].name}, {listed_lines(rows['line'].tolist())}: omitted, "
            f"because there is no {problems.title(name)}"
        )
    return frame[~blank].reset_index(drop=True)


def _check_levels(
    frame: pd.DataFrame, mapping: TableMapping, sources: Sequence[Source], problems: Problems
) -> None:
    levels = numbers(frame, STIMULUS, sources, Problems(titles=problems.titles))
    name = mapping.quantity.name
    if (levels < 0).any():
        raise UserError(
            f"{sources[0].name}, column {problems.title(STIMULUS)}: {name} of "
            f"{levels.min():g} {mapping.stimulus.unit}".rstrip()
            + "; expected 0 or more, because the quantity must have a true zero and not be a "
            "logarithm or a difference"
            + ("; add the standard to both columns" if mapping.columns.reference else "")
        )
    if LOGARITHMIC.search(f"{mapping.stimulus.unit} {name}"):
        problems.add(
            f"{name} in {mapping.stimulus.unit or 'this unit'} is already a logarithm, so "
            "exponents and growth functions do not refer to the underlying quantity; convert the "
            "levels first."
        )


def _groups(frame: pd.DataFrame, path: Path, problems: Problems) -> pd.DataFrame:
    """Return all participants, with their group if the table has groups.

    Raises
    ------
    UserError
        If a participant is in two groups, probably because the group column contains conditions.
    """
    who = tidied(frame[PARTICIPANT]).astype("str")
    if GROUP not in frame:
        return pd.DataFrame({PARTICIPANT: sorted(who.dropna().unique())})
    pairs = pd.DataFrame({PARTICIPANT: who, GROUP: tidied(frame[GROUP]).astype("str")})
    pairs = pairs.dropna().drop_duplicates().sort_values([PARTICIPANT, GROUP], ignore_index=True)
    twice = pairs[pairs.duplicated(PARTICIPANT, keep=False)]
    if len(twice):
        first = twice.iloc[0][PARTICIPANT]
        both = " and ".join(twice.loc[twice[PARTICIPANT] == first, GROUP][:2])
        column = problems.title(GROUP)
        raise UserError(
            "{path}: participant {first} has {both} in column {column}; expected one group per "
            "participant (to analyse a single condition, use --only {column}=...)",
            path=path,
            first=first,
            both=both,
            column=column,
        )
    sizes = pairs[GROUP].value_counts()
    alone = sorted(sizes.index[sizes == 1])
    if len(alone) == 1:
        problems.add(
            f"Group '{alone[0]}' has only one participant, so its spread cannot be estimated."
        )
    elif alone:
        problems.add(
            f"The spread cannot be estimated in groups of one participant: {listed(alone)}."
        )
    return pairs
