"""Read data from other laboratories: any column names, any quantity, long or wide format.

A mapping defines the meaning of the columns. The rows are converted to Slipscale's own format.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.reading.cells import listed, places
from slipscale.analysis.reading.cleaning import (
    clean_differences,
    clean_estimates,
    empty_differences,
    empty_estimates,
    labels,
    numbers,
    tidied,
    told_apart,
)
from slipscale.analysis.reading.delimited import Problems, Source, read_tables
from slipscale.analysis.reading.table_by_hand import read_table
from slipscale.analysis.reading.trial_tables import BLOCK, ESTIMATION, FACTOR, SERIES
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reading.mapping import TableMapping
    from slipscale.stimuli.quantity import Quantity

STIMULUS, RESPONSE = ESTIMATION.required
REFERENCE, ANSWER = "amplitude_before_um_pp", "difference_felt"
GROUP = "group"
#: Label of the task in a table of answers.
ANSWERS = "answers"
#: Columns in Slipscale's tables, keyed by field name of `mapping.Columns`.
OURS = {
    "participant": PARTICIPANT,
    "stimulus": STIMULUS,
    "response": RESPONSE,
    "answer": ANSWER,
    "yes_count": "yes_count",
    "n": "n",
    "reference": REFERENCE,
    "first": "first",
    "second": "second",
    "dissimilarity": "dissimilarity",
    "group": GROUP,
    "factor": "factor",
    "session": "session",
    "run": "run",
    "block": BLOCK,
    "trial": "trial",
}
NUMBERS = ("stimulus", "response", "reference", "dissimilarity", "trial", "yes_count", "n")
#: Names of tables in a folder, which contain the participant label.
BIDS_TABLE = re.compile(r"sub-(?P<sub>[^_]+)(_ses-(?P<ses>[^_]+))?_.*_(beh|events)\.tsv")
BIDS_LABELS = {"participant": "sub", "session": "ses"}
#: Number of answers at the smallest level, and proportion of "yes" that suggests guessing.
FEWEST_TO_WARN, LIKE_GUESSING = 10, 1 / 3
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


def read_foreign(path: Path, mapping: TableMapping, problems: Problems) -> ForeignTable:
    """Read a table, or the tables in a BIDS folder, using a mapping.

    Raises
    ------
    UserError
        If the table cannot be read (see `slipscale.analysis.reading.table_by_hand.read_table`), a
        level is below 0, a participant is in two groups, or ``only`` matches no rows.
    """
    frame, sources = (_folder if path.is_dir() else _table)(path, mapping, problems)
    frame = _chosen(frame, mapping, path)
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
            pairs=_rated(frame, sources, problems),
            participants=_groups(frame, path, problems),
            sources=tuple(sources),
        )
    frame = _of_trials(frame, mapping, problems, path)
    _check_levels(frame, mapping, sources, problems)
    groups = _groups(frame, path, problems)
    quantity = mapping.quantity
    estimates, differences = empty_estimates(), empty_differences()
    choices = pd.DataFrame()
    if mapping.of_answers:
        steps = _steps(_one_row_per_answer(frame, mapping, sources, problems))
        read = clean_differences(steps, sources, problems, quantity, yes=mapping.answers.yes)
        read = _above_reference(read)
        if method := _method(read, mapping):
            choices = _choices(read, method, quantity)
        else:
            differences = read
            _warn_of_forced_choice(read, problems, quantity)
    else:
        estimates = clean_estimates(frame, sources, problems, quantity, factors=["factor"])
        if mapping.columns.factor:
            ours = FACTOR + "factor"
            estimates = estimates.rename(columns={ours: FACTOR + mapping.columns.factor})
    if mapping.stimulus.in_unit:
        for part, columns in (
            (estimates, (STIMULUS,)),
            (differences, (STIMULUS, REFERENCE)),
            (choices, ("level_um_pp", "standard_um_pp")),
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


def _table(
    path: Path, mapping: TableMapping, problems: Problems
) -> tuple[pd.DataFrame, list[Source]]:
    columns = mapping.columns.model_dump(exclude_none=True)
    figures = [columns[name] for name in NUMBERS if name in columns] + list(mapping.levels)
    words = [column for name, column in columns.items() if name not in NUMBERS]
    words += [column for column in mapping.table.only if column not in (*words, *figures)]
    frame, source = read_table(
        path,
        required=(*words, *figures),
        numbers=figures,
        words=words,
        identifier=mapping.columns.participant,
        problems=problems,
        decimal=mapping.table.decimal,
        sheet=mapping.table.sheet,
    )
    return frame, [source]


def _folder(
    folder: Path, mapping: TableMapping, problems: Problems
) -> tuple[pd.DataFrame, list[Source]]:
    """Read the tables in a BIDS folder, and take participants from file names if necessary."""
    entries = [
        (path, match)
        for path in sorted(folder.glob("sub-*/**/*.tsv"))
        if (match := BIDS_TABLE.fullmatch(path.name))
    ]
    if not entries:
        raise UserError(
            f"{folder}: no data found; expected files like sub-01/beh/sub-01_task-loudness_beh.tsv "
            "or ..._events.tsv"
        )
    columns = mapping.columns.model_dump(exclude_none=True)
    from_names = {
        columns[name]: label
        for name, label in BIDS_LABELS.items()
        if columns.get(name) in (OURS[name], label)
    }
    needed = [c for c in (*columns.values(), *mapping.levels) if c not in from_names]
    needed += [column for column in mapping.table.only if column not in needed]
    frame, sources = read_tables(
        [path for path, _ in entries],
        folder,
        required=needed,
        columns=needed,
        problems=problems,
    )
    for column, label in from_names.items():
        found = pd.Series([match[label] or "" for _, match in entries], dtype="str")
        prefix = f"{label}-" if label == "sub" else ""
        frame[column] = (prefix + found).iloc[frame["file"].to_numpy()].to_numpy()
    for name in ("group", "answer", "block"):
        if name in columns:
            frame[columns[name]] = frame[columns[name]].astype("str")
    return frame, sources


def _chosen(frame: pd.DataFrame, mapping: TableMapping, path: Path) -> pd.DataFrame:
    """Select the rows that match the values in the mapping's ``only``."""
    for column, value in mapping.table.only.items():
        found = frame[column].astype("str").str.strip()
        kept = frame[found == value.strip()]
        if not len(kept):
            values = ", ".join(sorted(found.dropna().unique())[:12]) or "nothing"
            raise UserError(f"{path}: no row has '{value}' in column {column}; found {values}")
        frame = kept.reset_index(drop=True)
    return frame


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


def _one_row_per_answer(
    frame: pd.DataFrame, mapping: TableMapping, sources: Sequence[Source], problems: Problems
) -> pd.DataFrame:
    """Expand counts of yes answers to one row per answer; leave other tables unchanged.

    Raises
    ------
    UserError
        If a count is not a whole number from 0 to n.
    """
    if not mapping.columns.yes_count:
        return frame
    yes, n = (numbers(frame, name, sources, problems) for name in ("yes_count", "n"))
    wrong = ~((yes >= 0) & (yes <= n) & (yes % 1 == 0) & (n % 1 == 0))
    if wrong.any():
        at = int(wrong.to_numpy().argmax())
        raise UserError(
            f"{places(frame.iloc[[at]], sources)[0]}: {problems.title('yes_count')} is "
            f"{frame['yes_count'].iloc[at]} and {problems.title('n')} {frame['n'].iloc[at]}; "
            "expected whole numbers, with 0 to n yes answers"
        )
    times = np.stack([yes, n - yes], axis=1).astype(int).ravel()
    rows = frame.loc[frame.index.repeat(2)].assign(**{ANSWER: ["yes", "no"] * len(frame)})
    return rows.iloc[np.repeat(np.arange(len(rows)), times)].reset_index(drop=True)


def _method(steps: pd.DataFrame, mapping: TableMapping) -> str:
    """Return the method for fitting answers, or "" if all stimuli are on one side of the reference.

    If stimuli are both below and above the reference, the trials are comparisons with a standard.
    If only the size of the difference were used, "more" answers below and above the reference would
    cancel out.
    """
    if mapping.answers.alternatives:
        return {2: "two_interval", 3: "three_interval"}[mapping.answers.alternatives]
    change = steps[REFERENCE] - steps[STIMULUS]
    both_sides = mapping.columns.reference and (change < 0).any() and (change > 0).any()
    return "comparison" if both_sides else ""


def _choices(steps: pd.DataFrame, method: str, quantity: Quantity) -> pd.DataFrame:
    """Convert answers to forced-choice trials or comparisons with a standard."""
    # The columns are swapped here, because `_above_reference` has exchanged them.
    level, standard = steps[REFERENCE], steps[STIMULUS]
    if method != "comparison":
        level = told_apart((level - standard).abs(), quantity)
    answered = steps["difference_felt"].notna() & level.notna()
    return steps.assign(
        task=ANSWERS,
        method=method,
        catch=False,
        track=np.nan,
        standard_um_pp=standard,
        level_um_pp=level,
        correct=steps["difference_felt"] == 1,
        response_time=np.nan,
    )[answered].reset_index(drop=True)


def _warn_of_forced_choice(steps: pd.DataFrame, problems: Problems, quantity: Quantity) -> None:
    """Warn if many "yes" answers at the smallest difference suggest a forced-choice task."""
    size = (steps[REFERENCE] - steps[STIMULUS]).abs()
    smallest = size[size > 0].min()
    answers = steps.loc[(size == smallest), "difference_felt"].dropna()
    if len(answers) >= FEWEST_TO_WARN and answers.mean() >= LIKE_GUESSING and not (size == 0).any():
        problems.add(
            f"At the smallest {quantity.name}, {smallest:g}, {answers.mean():.0%} of the answers "
            "are yes. If participants chose between alternatives in every trial, add "
            "--alternatives 2, so that guessing is not mistaken for sensitivity."
        )


def _rated(frame: pd.DataFrame, sources: Sequence[Source], problems: Problems) -> pd.DataFrame:
    """Convert the table to ratings of pairs of named items."""
    rated = frame.assign(
        **{name: labels(frame, name, "").astype(str) for name in ("first", "second")},
        **{name: labels(frame, name, missing) for name, missing in (("session", ""), ("run", "1"))},
        **{PARTICIPANT: tidied(frame[PARTICIPANT])},
        dissimilarity=numbers(frame, "dissimilarity", sources, problems, minimum=0.0),
        task="similarity",
        trial=range(1, len(frame) + 1),
        catch=False,
        sorted=False,
    )
    whole = rated["dissimilarity"].notna() & (rated["first"] != "") & (rated["second"] != "")
    if not whole.all():
        problems.add(f"{int((~whole).sum())} ratings without a number or an item are omitted")
    return rated[whole].reset_index(drop=True)


def _steps(frame: pd.DataFrame) -> pd.DataFrame:
    """Return yes/no answers as steps from a reference to the stimulus (default reference: 0)."""
    found = frame.copy()
    if REFERENCE not in found:
        found[REFERENCE] = 0.0
    found[PARTICIPANT] = tidied(found[PARTICIPANT])
    for name, missing in (("session", ""), ("run", "1")):
        found[name] = labels(found, name, missing)
    return found.rename(columns={BLOCK: SERIES})


def _above_reference(steps: pd.DataFrame) -> pd.DataFrame:
    """Exchange stimulus and reference, so that the step size is the stimulus minus the reference.

    In Slipscale's own tables, the step size is the decrease in amplitude.
    """
    return steps.rename(columns={REFERENCE: STIMULUS, STIMULUS: REFERENCE})


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
            f"{path}: participant {first} has {both} in column {column}; expected one group per "
            f"participant (to analyse a single condition, use --only {column}=...)"
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
