"""Read a data set from a folder or a table.

Slipscale reads BIDS data sets written by `slipscale.experiments.dataset.bids`, and tidy tables with
``participant_id``, ``level`` and ``estimate``. Rows are never dropped silently: practice,
voided and unanswered trials are counted, and invalid cells are reported with file and line.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import get_args

import pandas as pd

from slipscale.analysis.reading import metadata
from slipscale.analysis.reading.cleaning import (
    ESTIMATION_NUMBERS,
    as_numbers,
    clean_estimates,
    empty_differences,
    empty_estimates,
    in_order,
)
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.reading.delimited import STANDARD_INPUT, Problems, held
from slipscale.analysis.reading.foreign.columns import GROUP
from slipscale.analysis.reading.foreign.files import chosen
from slipscale.analysis.reading.foreign.layouts.answers import is_logarithmic
from slipscale.analysis.reading.foreign.layouts.layout import CHOICES, DIFFERENCES, ESTIMATES
from slipscale.analysis.reading.foreign.table import ForeignTable, read_foreign
from slipscale.analysis.reading.labelled_tasks import (
    Entries,
    Entry,
    TaskTrials,
    kind_of,
    of_one_label,
    read_others,
    with_people,
)
from slipscale.analysis.reading.meaning.keywords import mapping_of
from slipscale.analysis.reading.meaning.mapping import NAME, TableMapping, beside
from slipscale.analysis.reading.own_results import refuse_results
from slipscale.analysis.reading.suspicions import check_levels, notes_on_answers
from slipscale.analysis.reading.table_by_hand import Request, read_table
from slipscale.analysis.reading.trial_tables import BLOCK, ESTIMATION, IDENTITY, factor_columns
from slipscale.analysis.tasks.outside.guard import installed_kinds
from slipscale.analysis.tasks.table import TRIALS
from slipscale.experiments.dataset.journals import journals
from slipscale.experiments.dataset.schema import PARTICIPANT, TABLE_NAME
from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.study.analysis_choices import AnalysisChoices, Normalisation
from slipscale.faults import UserError
from slipscale.faults.folders import visible
from slipscale.faults.message import Message
from slipscale.stimuli.quantity import AMPLITUDE_DECIMALS, PLATE_AMPLITUDE, Quantity

#: Column in which ``estimates.csv`` states the rule, and choice of the analysis.
RULE = "normalisation"


#: A data set folder, a table, several tables or a DataFrame.
Data = str | Path | pd.DataFrame | Sequence[str | Path]
#: Path that stands for a DataFrame.
IN_MEMORY = Path("DataFrame")


def load(
    path: Data,
    mapping: TableMapping | None = None,
    *,
    task: str | None = None,
    **columns: object,
) -> Dataset:
    """Read a data set folder, a table, several tables with the same columns, or a DataFrame.

    Parameters
    ----------
    path : str or Path, sequence of them, or DataFrame
        A data set folder, or tables in text files or files of other programs, or a folder of them.
        ``-`` is standard input.
    mapping : TableMapping, optional
        Meaning of the columns. The default is read from ``analysis.toml`` in the folder or next to
        the table. If ``analysis.toml`` does not exist, the columns must have the names used by
        Slipscale.
    task : str, optional
        Task label, for data sets with several labels for magnitude estimation or descending
        difference. The default is the protocol's own label or, if it is absent, the
        alphabetically first label. A folder that is read with ``mapping`` has no default.
    **columns
        Meaning of the columns, with the names of the options of ``slipscale analyse``, instead of a
        mapping: ``participant="who", stimulus="level:mm", answer="correct", alternatives=2``; see
        `slipscale.analysis.reading.meaning.keywords.mapping_of`.

    Raises
    ------
    UserError
        If there is nothing to analyse, a file cannot be read, a column is missing, or the data set
        mixes pilots with participants.
    """
    if columns:
        mapping = mapping_of(columns)
    contents: dict[Path, bytes] = {}
    if isinstance(path, pd.DataFrame):
        # The index is a column if it has a name, as after grouping.
        contents[IN_MEMORY] = path.to_csv(index=path.index.names != [None]).encode()
        mapping = mapping or TableMapping()
        points = mapping.table.model_copy(update={"decimal": "."})
        mapping, path = mapping.model_copy(update={"table": points}), IN_MEMORY
    places = _places(path)
    if STANDARD_INPUT in places:
        contents[STANDARD_INPUT] = sys.stdin.buffer.read()
    with held(contents):
        return _loaded(places, mapping, task, contents)


def _loaded(
    places: Sequence[Path],
    mapping: TableMapping | None,
    task: str | None,
    contents: Mapping[Path, bytes],
) -> Dataset:
    where = places[0]
    for each in places:
        if each.exists():
            refuse_results(each)
        elif each not in contents:
            raise UserError(
                "{where}: no such file or folder; expected a data set, or a table", where=each
            )
    if where.exists():
        mapping = mapping or beside(where)
    if task is not None and not where.is_dir():
        raise UserError(
            "--task {task}: {where} is a single table; expected a folder (to select rows of a "
            "table, use --only)",
            task=task,
            where=where,
        )
    if mapping is not None and not mapping.of_own:
        return _load_foreign(places, mapping, task)
    if len(places) > 1:
        raise UserError(
            "{where} and {more} more: several tables need options that state what their columns "
            "mean, such as --participant-from-name, --stimulus and --answer",
            where=where,
            more=len(places) - 1,
        )
    if mapping is not None and where.is_dir():
        raise UserError(
            "{where}: decimal, sheet and only are for tables whose columns are named; for a "
            "folder, expected --participant and so on ([columns] in {name}), or none of these",
            where=where,
            name=NAME,
        )
    if where.is_dir():
        return _load_folder(where, task)
    return _load_table(where, mapping or TableMapping())


def _places(path: str | Path | Sequence[str | Path]) -> list[Path]:
    try:
        several = [path] if isinstance(path, str | Path) else list(path)
        return [Path(each) for each in several] or [Path()]
    except TypeError:
        raise UserError(
            "load: {path} has the type {name}; expected a path, or a list of paths",
            path=f"{path!r:.40}",
            name=type(path).__name__,
        ) from None


def _load_folder(folder: Path, task: str | None) -> Dataset:
    problems = Problems()
    faults: list[str] = []
    outside = [kind.trials for kind in installed_kinds(faults) if kind.trials is not None]
    faults.clear()  # packages that cannot be loaded are reported when their results are needed
    paths = visible(folder, "sub-*/**/beh/*_beh.tsv")
    quantity = metadata.one_quantity(paths, folder)
    kinds = (*TRIALS, *outside)
    found: dict[str, dict[str, list[Entry]]] = {kind.name: {} for kind in kinds}
    others: dict[str, list[Entry]] = {}
    for path in paths:
        match = TABLE_NAME.fullmatch(path.name)
        if match and path.relative_to(folder).parts[0] != f"sub-{match['sub']}":
            problems.add(
                f"{path.relative_to(folder)}: is in another participant's folder; it was not read"
            )
        elif match:
            kind = kind_of(match["task"], path, kinds)
            tasks = others if kind is None else found[kind.name]
            tasks.setdefault(match["task"], []).append((path, match))
        else:
            problems.add(
                f"{path.relative_to(folder)}: the name does not follow BIDS, so the file "
                "was not read"
            )
    files = _files(kinds, found, task, folder, problems)
    if not (others or any(found.values())):
        raise UserError(
            Message(
                "{folder}: contains journals but no tables; to create them, run slipscale data "
                "build {folder}",
                folder=folder,
            )
            if journals(folder)
            else Message(
                "{folder}: no data found; expected files like "
                "sub-01/beh/sub-01_task-{task}_run-01_beh.tsv, or one table (CSV or TSV) "
                "with participant_id, amplitude_um_pp, estimate",
                folder=folder,
                task=ESTIMATION.task,
            )
        )
    everyone = [
        entry for tables in (files, others) for entries in tables.values() for entry in entries
    ]
    of_sidecars = Problems()
    details, modes, sources = metadata.sidecars([path for path, _ in everyone], folder, of_sidecars)
    metadata.refuse_mixture(modes, folder)
    counts: dict[str, int] = {}
    read = {}
    for kind in kinds:
        read[kind.name], read_sources = kind.read(files[kind.name], folder, problems, counts)
        sources += read_sources
    other_tasks, read_sources = read_others(others, folder, problems, counts)
    sources += read_sources
    # Problems with rows come first, because only they can leave nothing to analyse.
    problems.sentences += of_sidecars.sentences
    # Tables can differ from journals if rows were edited by hand, or if runs have no tables.
    differences = tuple(map(str, verify(folder))) if journals(folder) else None
    problems.add_many(differences or (), "slipscale data verify lists all")
    problems.add_many(faults, "analyses of other packages")
    tables = _divided(kinds, read, problems, counts)
    participants = metadata.participants(folder, sources, problems)
    choices, frozen, unchanged, text = metadata.choices(folder, sources, details, problems)
    metadata.add_sources(folder, choices, sources)
    return Dataset(
        name=metadata.title(folder),
        estimates=tables.pop("estimates"),
        answers=tables.pop("answers"),
        differences=tables.pop("differences"),
        textures=tables.pop("textures"),
        trials=tables,
        participants=participants,
        mode=modes[0][0] if modes else "unknown",
        counts=counts,
        details=details,
        choices=choices,
        frozen=frozen,
        # A changed study file may define a different rule from the one used in the sessions.
        study_text="" if unchanged is False else text,
        unchanged=unchanged,
        journal_differences=differences,
        problems=tuple(problems.sentences),
        sources=tuple(sources),
        folder=folder,
        others=other_tasks,
        quantity=quantity,
    )


def _files(
    kinds: Sequence[TaskTrials],
    found: Mapping[str, Mapping[str, list[Entry]]],
    wanted: str | None,
    folder: Path,
    problems: Problems,
) -> dict[str, Entries]:
    """Return the table files of each kind of task, sorted by name.

    Raises
    ------
    UserError
        If no magnitude estimation or descending difference has the label ``wanted``.
    """
    labels = sorted(label for kind in kinds if kind.label for label in found[kind.name])
    if wanted is not None and wanted not in labels:
        raise UserError(
            "--task {wanted}: {folder} has no magnitude estimation or descending difference "
            "with that label; expected {expected}",
            wanted=wanted,
            folder=folder,
            expected=" or ".join(labels) or "no --task",
        )
    return {
        kind.name: of_one_label(kind, found[kind.name], wanted, problems)
        if kind.label
        else sorted(entry for entries in found[kind.name].values() for entry in entries)
        for kind in kinds
    }


def _divided(
    kinds: Sequence[TaskTrials],
    read: Mapping[str, pd.DataFrame],
    problems: Problems,
    counts: dict[str, int],
) -> dict[str, pd.DataFrame]:
    """Return the trials of each kind of task, keyed by field name of `Dataset`."""
    tables: dict[str, pd.DataFrame] = {}
    for kind in kinds:
        rows = read[kind.name]
        tables |= kind.divide(rows, problems, counts) if kind.divide else {kind.name: rows}
    return tables


def _load_table(path: Path, mapping: TableMapping) -> Dataset:
    problems = Problems()
    cells = mapping.table
    ours = {PLATE_AMPLITUDE.named(name): name for name in ESTIMATION.required}
    figures = (*ours, *ESTIMATION_NUMBERS)
    words = (*IDENTITY, *ESTIMATION.words, BLOCK, RULE)
    request = Request(
        required=(PARTICIPANT, *ours, *cells.only),
        numbers=figures,
        words=(*words, *(column for column in cells.only if column not in (*figures, *words))),
        identifier=PARTICIPANT,
        decimal=cells.decimal,
        sheet=cells.sheet,
    )
    frame, source = read_table(path, request, problems)
    frame = chosen(frame, cells.only, path).rename(columns=ours)
    _refuse_another_unit(frame, path)
    answers_read = clean_estimates(in_order(frame, problems), [source], problems)
    table = ForeignTable(
        trials={ESTIMATES: answers_read}, participants=pd.DataFrame(), sources=(source,)
    )
    data = _by_hand([path], table, problems, PLATE_AMPLITUDE)
    people = sorted(data.answers[PARTICIPANT].astype(str).unique())
    data = replace(data, participants=pd.DataFrame({PARTICIPANT: people}))
    return _with_choices(data, mapping.analysis, _one_rule(frame, path))


def _one_rule(frame: pd.DataFrame, path: Path) -> dict[str, str]:
    """Return the normalisation rule that a copy of ``estimates.csv`` states, if it does."""
    rules = frame[RULE].dropna().unique().tolist() if RULE in frame else []
    if not rules:
        return {}
    known = get_args(Normalisation)
    if len(rules) > 1 or rules[0] not in known:
        raise UserError(
            "{name}: the column {column} contains {rules}; expected the same rule in every row: "
            "one of {known}",
            name=path.name,
            column=RULE,
            rules=", ".join(map(str, rules)),
            known=", ".join(known),
        )
    return {RULE: str(rules[0])}


def _load_foreign(paths: Sequence[Path], mapping: TableMapping, task: str | None) -> Dataset:
    problems = Problems()
    table = read_foreign(paths, mapping, problems, task)
    axis = {}
    stated = {"axis", "threshold_curve"} & mapping.analysis.model_fields_set
    answered = {CHOICES, DIFFERENCES} & set(table.trials)
    if answered and is_logarithmic(mapping) and not stated:
        axis = {"axis": "linear"}
        problems.add(
            f"{mapping.quantity.name} in {mapping.quantity.unit or 'this unit'} is already a "
            "logarithm, so curves have a linear axis unless --axis states another"
        )
    data = _by_hand(paths, table, problems, mapping.quantity)
    data = _with_choices(data, mapping.analysis, axis)
    group = mapping.columns.group
    if group is None or data.choices.group is not None:
        return data
    return replace(
        data,
        participants=data.participants.rename(columns={GROUP: group}),
        choices=data.choices.model_copy(update={"group": group}),
    )


def _with_choices(
    data: Dataset, choices: AnalysisChoices, stated: Mapping[str, str] | None = None
) -> Dataset:
    """Set the choices of ``analysis.toml``, which precede those that the table states."""
    frozen = choices.model_fields_set
    left = {name: value for name, value in (stated or {}).items() if name not in frozen}
    return replace(data, choices=choices.model_copy(update=left), frozen=tuple(sorted(frozen)))


def _by_hand(
    paths: Sequence[Path], table: ForeignTable, problems: Problems, quantity: Quantity
) -> Dataset:
    counts: dict[str, int] = {}
    path = paths[0]
    level, answer = ESTIMATION.required
    empty = {ESTIMATES: empty_estimates(), DIFFERENCES: empty_differences()}
    read = {kind: table.trials.get(kind, rows) for kind, rows in empty.items()}
    for found in table.trials.values():
        for column in found.columns[found.columns.str.contains(level)]:
            check_levels(found[column], path.name)
    notes = notes_on_answers(read[ESTIMATES], PARTICIPANT, level, answer, path.name)
    problems.add_many(list(notes), "suspicious answers")
    tables = _divided([kind for kind in TRIALS if kind.name in read], read, problems, counts)
    trials = {}
    for kind in TRIALS:
        rows = table.trials.get(kind.name)
        if kind.name not in read and rows is not None and len(rows):
            # Tables made by hand have no friction.
            columns = (*kind.empty().columns, *factor_columns(rows))
            trials[kind.name] = with_people(rows.reindex(columns=list(columns)), columns)
    folder = path if path.is_dir() else None
    return Dataset(
        name=metadata.title(path) if folder else path.stem,
        estimates=tables["estimates"],
        answers=tables["answers"],
        differences=tables["differences"],
        textures=tables["textures"],
        trials=trials,
        participants=table.participants,
        counts=counts,
        problems=tuple(problems.sentences),
        sources=table.sources,
        left_out=table.left_out,
        quantity=quantity,
        folder=folder,
    )


def _refuse_another_unit(frame: pd.DataFrame, path: Path) -> None:
    """Raise `UserError` if amplitudes are too small, for example given in m instead of µm."""
    _, given = as_numbers(frame["level"])
    vanishing = given[(given > 0) & (given.round(AMPLITUDE_DECIMALS) == 0)]
    if len(vanishing):
        raise UserError(
            "{path}: column amplitude_um_pp: {least:g} µm is less than 0.1 nm, the resolution of "
            "amplitudes; expected µm, peak to peak (for another unit, name it, as in "
            "--participant participant_id --stimulus amplitude_um_pp:m --response estimate)",
            path=path,
            least=vanishing.min(),
        )
