"""A data set, read: which trials will be analysed, and what was left out and why.

Two shapes come in: a BIDS data set as `slipscale.experiments.dataset.bids` writes it, or one tidy
table with ``participant_id``, ``amplitude_um_pp`` and ``estimate``. Rows are never dropped in
silence: practice, voided and unanswered trials are counted, wrong cells are named by file and line.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.reading import metadata
from slipscale.analysis.reading.cleaning import (
    ESTIMATION_NUMBERS,
    as_numbers,
    clean_differences,
    clean_estimates,
    empty_differences,
    empty_estimates,
)
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.reading.delimited import Problems, Source, read_tables
from slipscale.analysis.reading.foreign import ForeignTable, read_foreign
from slipscale.analysis.reading.labelled_tasks import header_of, read_others
from slipscale.analysis.reading.mapping import beside
from slipscale.analysis.reading.quantity import AMPLITUDE_DECIMALS, PLATE_AMPLITUDE
from slipscale.analysis.reading.repeatable_tasks import KNOWN_BY, of_one_task, protocol_of
from slipscale.analysis.reading.table_by_hand import read_table
from slipscale.analysis.reading.trial_tables import (
    BLOCK,
    DIFFERENCE,
    ESTIMATION,
    IDENTITY,
    STEP_AMPLITUDES,
)
from slipscale.analysis.tasks.table import TRIALS
from slipscale.experiments.dataset.journals import journals
from slipscale.experiments.dataset.schema import (
    DAMAGED,
    FAULT,
    FLAG_SEPARATOR,
    PARTICIPANT,
    PRACTICE,
    REPRESENTED,
    TABLE_NAME,
    TIMED_OUT,
    VOIDED,
)
from slipscale.experiments.dataset.verification import verify
from slipscale.faults import UserError

if TYPE_CHECKING:
    import re
    from collections.abc import Mapping, Sequence

    from slipscale.analysis.reading.labelled_tasks import Entries, TaskTrials
    from slipscale.analysis.reading.mapping import TableMapping
    from slipscale.analysis.reading.quantity import Quantity
    from slipscale.analysis.reading.trial_tables import TrialTable


def kind_of(header: frozenset[str]) -> TaskTrials | None:
    """Return the kind of a task that a study may give a label of its own, by its columns."""
    return next((kind for kind in TRIALS if kind.belongs(header)), None)


def load(
    path: str | Path, mapping: TableMapping | None = None, *, task: str | None = None
) -> Dataset:
    """Read a data set's folder or a table.

    Parameters
    ----------
    path : str or Path
        A data set's folder, or a table: text, Excel or SPSS.
    mapping : TableMapping, optional
        What the columns mean; default: what ``analysis.toml`` in the folder, or beside the table,
        says, else the names of our own tables.
    task : str, optional
        The label of a task, where a data set holds magnitude estimation or descending difference
        under several; default: the one without a label of its own, else the first by name.

    Raises
    ------
    UserError
        There is nothing to analyse there, a file cannot be read, a column is missing, or pilot
        and participant records are mixed.
    """
    try:
        where = Path(path)
    except TypeError:
        raise UserError(
            f"load: {path!r:.40} has the type {type(path).__name__}; expected a path"
        ) from None
    if where.exists():
        mapping = mapping or beside(where)
    if mapping is not None and where.exists():
        return _load_foreign(where, mapping)
    if where.is_dir():
        return _load_folder(where, task)
    if where.is_file():
        return _load_table(where)
    raise UserError(f"{where}: no such file or folder; expected a data set")


def _load_folder(folder: Path, task: str | None) -> Dataset:
    repeatable: dict[str, dict[str, list[tuple[Path, re.Match[str]]]]] = {
        own: {} for own in KNOWN_BY
    }
    labelled: dict[str, list[tuple[Path, re.Match[str]]]] = {kind.name: [] for kind in TRIALS}
    others: dict[str, list[tuple[Path, re.Match[str]]]] = {}
    problems = Problems()
    for path in sorted(folder.glob("sub-*/**/beh/*_beh.tsv")):
        match = TABLE_NAME.fullmatch(path.name)
        if match and path.relative_to(folder).parts[0] != f"sub-{match['sub']}":
            problems.add(f"{path.relative_to(folder)}: in another participant's folder; not read")
        elif match and (own := protocol_of(match["task"], path)) is not None:
            repeatable[own].setdefault(match["task"], []).append((path, match))
        elif match and (kind := kind_of(header_of(path))) is not None:
            labelled[kind.name].append((path, match))
        elif match:
            others.setdefault(match["task"], []).append((path, match))
        else:
            problems.add(f"{path.relative_to(folder)}: not a name of the BIDS form; not read")
    files = of_one_task(repeatable, task, folder, problems)
    found = any(repeatable.values()) or any(labelled.values()) or others
    if not found and journals(folder):
        raise UserError(
            f"{folder}: holds journals and no tables; slipscale data build {folder} makes them"
        )
    if not found:
        raise UserError(
            f"{folder}: no data found; expected files like "
            f"sub-01/beh/sub-01_task-{ESTIMATION.task}_run-01_beh.tsv, or one table (CSV or TSV) "
            "with participant_id, amplitude_um_pp, estimate"
        )
    everyone = [
        entry
        for tables in (files, labelled, others)
        for entries in tables.values()
        for entry in entries
    ]
    details, modes, sources = metadata.sidecars([path for path, _ in everyone], folder, problems)
    metadata.refuse_mixture(modes, folder)
    counts: dict[str, int] = {}
    read = {}
    for table in (ESTIMATION, DIFFERENCE):
        frame, read_sources = _read_task(table, files[table.task], folder, problems)
        sources += read_sources
        read[table.task] = frame
    tasks, read_sources = _read_labelled(labelled, folder, problems, counts)
    sources += read_sources
    other_tasks, read_sources = read_others(others, folder, problems, counts)
    sources += read_sources
    # What the journals say and the tables do not: rows edited by hand, runs without tables.
    differences = [str(problem) for problem in verify(folder)] if journals(folder) else []
    problems.add_many(differences, "slipscale data verify tells all")
    main = _keep_main_trials(read[ESTIMATION.task], counts)
    answers, textures = _part_textures(main, counts, problems)
    participants = metadata.participants(folder, sources, problems)
    choices, frozen, unchanged = metadata.choices(folder, sources, details, problems)
    metadata.add_sources(folder, choices, sources)
    return Dataset(
        name=metadata.title(folder),
        estimates=_answered(answers, counts),
        answers=answers,
        differences=_keep_steps(read[DIFFERENCE.task], counts),
        trials=tasks,
        participants=participants,
        mode=modes[0][0] if modes else "unknown",
        counts=counts,
        details=details,
        choices=choices,
        frozen=frozen,
        unchanged=unchanged,
        problems=tuple(problems.sentences),
        sources=tuple(sources),
        folder=folder,
        textures=textures,
        others=other_tasks,
    )


def _read_labelled(
    labelled: Mapping[str, Entries], folder: Path, problems: Problems, counts: dict[str, int]
) -> tuple[dict[str, pd.DataFrame], list[Source]]:
    """Return the trials of each kind of task."""
    tasks: dict[str, pd.DataFrame] = {}
    sources: list[Source] = []
    for kind in TRIALS:
        tasks[kind.name], read_sources = kind.read(labelled[kind.name], folder, problems, counts)
        sources += read_sources
    return tasks, sources


def _load_table(path: Path) -> Dataset:
    problems = Problems()
    frame, source = read_table(
        path,
        required=(PARTICIPANT, *ESTIMATION.required),
        numbers=(*ESTIMATION.required, *ESTIMATION_NUMBERS),
        words=(*IDENTITY, *ESTIMATION.words, BLOCK),
        identifier=PARTICIPANT,
        problems=problems,
    )
    _refuse_another_unit(frame, path)
    answers_read = clean_estimates(frame, [source], problems)
    table = ForeignTable(
        estimates=answers_read,
        differences=empty_differences(),
        participants=pd.DataFrame(),
        sources=(source,),
    )
    data = _by_hand(path, table, problems, PLATE_AMPLITUDE)
    people = sorted(data.answers[PARTICIPANT].astype(str).unique())
    return replace(data, participants=pd.DataFrame({PARTICIPANT: people}))


def _load_foreign(path: Path, mapping: TableMapping) -> Dataset:
    problems = Problems()
    data = _by_hand(path, read_foreign(path, mapping, problems), problems, mapping.quantity)
    choices = mapping.analysis
    return replace(data, choices=choices, frozen=tuple(sorted(choices.model_fields_set)))


def _by_hand(path: Path, table: ForeignTable, problems: Problems, quantity: Quantity) -> Dataset:
    counts: dict[str, int] = {}
    main = _keep_main_trials(table.estimates, counts)
    answers, textures = _part_textures(main, counts, problems)
    return Dataset(
        name=metadata.title(path) if path.is_dir() else path.stem,
        estimates=_answered(answers, counts),
        answers=answers,
        differences=_keep_steps(table.differences, counts),
        participants=table.participants,
        counts=counts,
        problems=tuple(problems.sentences),
        sources=table.sources,
        textures=textures,
        quantity=quantity,
        folder=path if path.is_dir() else None,
    )


def _refuse_another_unit(frame: pd.DataFrame, path: Path) -> None:
    """Raise a `UserError` where an amplitude above 0 would count as none: metres, not µm."""
    _, given = as_numbers(frame["amplitude_um_pp"])
    vanishing = given[(given > 0) & (given.round(AMPLITUDE_DECIMALS) == 0)]
    if len(vanishing):
        raise UserError(
            f"{path}: column amplitude_um_pp: {vanishing.min():g} µm is less than the 0.1 nm that "
            "amplitudes are told apart to; expected µm, peak to peak (another unit: name it, as in "
            "--participant participant_id --stimulus amplitude_um_pp:m --response estimate)"
        )


def _read_task(
    table: TrialTable,
    entries: Sequence[tuple[Path, re.Match[str]]],
    folder: Path,
    problems: Problems,
) -> tuple[pd.DataFrame, list[Source]]:
    estimation = table is ESTIMATION
    if not entries:
        return (empty_estimates() if estimation else empty_differences()), []
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
    if estimation:
        return clean_estimates(frame, sources, problems), sources
    return clean_differences(frame, sources, problems), sources


def _has_flag(frame: pd.DataFrame, *codes: str) -> pd.Series[bool]:
    """Tell which rows carry one of the codes; each distinct flag cell is looked at once."""
    flags = frame["flag"].astype("category")
    hits = [
        bool(set(codes) & set(str(name).split(FLAG_SEPARATOR))) for name in flags.cat.categories
    ]
    lookup = np.array([*hits, False])
    return pd.Series(lookup[flags.cat.codes], index=frame.index)


def _keep_main_trials(frame: pd.DataFrame, counts: dict[str, int]) -> pd.DataFrame:
    """Return main trials that were not voided or damaged, marked by what happened in them."""
    counts["estimation_rows"] = len(frame)
    practice = frame["phase"].astype(str) == PRACTICE if len(frame) else np.array([], bool)
    counts["practice"] = int(np.sum(practice))
    main = frame[~practice]
    voided = _has_flag(main, VOIDED, DAMAGED)
    counts["voided"] = int(voided.sum())
    main = main[~voided].reset_index(drop=True)
    main["timed_out"] = _has_flag(main, TIMED_OUT)
    main["faulty"] = _has_flag(main, FAULT, REPRESENTED)
    counts["timed_out"] = int(main["timed_out"].sum())
    counts["faulty"] = int(main["faulty"].sum())
    return main


def _part_textures(
    main: pd.DataFrame, counts: dict[str, int], problems: Problems
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the trials of plain surfaces, and the answered ones of textures.

    A texture's amplitude is its largest: among plain surfaces of that amplitude it would pass
    for one of them.
    """
    modulated = main["texture"].astype(str) != ""
    textures = main[modulated & main["estimate"].notna()].reset_index(drop=True)
    runs = [main[name] for name in IDENTITY]
    # The plain surface in the row above is then not the surface felt before.
    main["after_texture"] = modulated.groupby(runs, observed=True).shift(fill_value=False)
    counts["textures"] = int(modulated.sum())
    if counts["textures"]:
        names = ", ".join(sorted(main.loc[modulated, "texture"].astype(str).unique()))
        problems.add(
            f"{counts['textures']} trials of textures ({names}) are left out of all that is said "
            "of amplitudes: a texture has no one amplitude. They have a table of their own."
        )
    return main[~modulated].drop(columns="texture").reset_index(drop=True), textures


def _answered(main: pd.DataFrame, counts: dict[str, int]) -> pd.DataFrame:
    answered = main["estimate"].notna() & main["amplitude_um_pp"].notna()
    counts["unanswered"] = int((~answered).sum())
    kept = main[answered].reset_index(drop=True)
    kept[PARTICIPANT] = kept[PARTICIPANT].cat.remove_unused_categories()
    counts["analysed"] = len(kept)
    return kept


def _keep_steps(frame: pd.DataFrame, counts: dict[str, int]) -> pd.DataFrame:
    counts["difference_rows"] = len(frame)
    if not len(frame):
        return frame
    practice = frame["phase"].astype(str) == PRACTICE
    voided = _has_flag(frame, VOIDED, DAMAGED) & ~practice
    counts["difference_practice"] = int(practice.sum())
    counts["difference_voided"] = int(voided.sum())
    kept = frame[~practice & ~voided]
    answered = kept[["difference_felt", *STEP_AMPLITUDES]].notna().all(axis=1)
    counts["difference_unanswered"] = int((~answered).sum())
    kept = kept[answered].reset_index(drop=True)
    counts["difference_analysed"] = len(kept)
    return kept
