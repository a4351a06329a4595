"""Read a data set's metadata: sidecars, participants, frozen study choices and title."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd
from pydantic import ValidationError

from slipscale.analysis.reading.cleaning import tidied
from slipscale.analysis.reading.delimited import (
    Problems,
    Source,
    digest,
    faults_of,
    quantity_of,
    read_bytes,
    read_source,
    read_tables,
)
from slipscale.analysis.reading.table_lines import listed_lines
from slipscale.experiments.dataset.schema import NOTES, PARTICIPANT, SIDECAR
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.faults import UserError
from slipscale.faults.toml_file import toml_table
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

#: Sidecar entries to report; see `slipscale.experiments.dataset.schema.NOTES`.
TOLD = ("study", "study_hash", "seed", "language", "plate")
WHOSE, VERSIONS = "mode", "software"
if unknown := {*TOLD, WHOSE, VERSIONS} - set(NOTES):
    raise LookupError(f"sidecars contain no {', '.join(sorted(unknown))}")


def sidecars(
    tables: Sequence[Path], folder: Path, problems: Problems
) -> tuple[dict[str, tuple[str, ...]], list[tuple[str, Path]], list[Source]]:
    """Read all sidecars; return their entries, the mode of each file, and the sources."""
    found: dict[str, set[str]] = {}
    modes: list[tuple[str, Path]] = []
    sources: list[Source] = []
    absent: list[str] = []
    for table in tables:
        path = table.with_suffix(".json")
        if not path.is_file():
            absent.append(
                f"{path.relative_to(folder)}: this sidecar does not exist, so the study "
                "and seed are unknown"
            )
            continue
        content, source = read_source(path, folder)
        sources.append(source)
        try:
            own = json.loads(content).get(SIDECAR, {})
            versions = dict(own.get(VERSIONS) or {})
        except (ValueError, TypeError, AttributeError, RecursionError) as error:
            raise UserError(
                "{path}: the file is not a sidecar; expected a JSON object with an object "
                "'{sidecar}' that contains an object '{versions}' ({error})",
                path=path,
                sidecar=SIDECAR,
                versions=VERSIONS,
                error=error,
            ) from error
        if mode := own.get(WHOSE):
            modes.append((str(mode), path))
        for key in TOLD:
            if own.get(key) is not None:
                found.setdefault(key, set()).add(_in_words(own[key]))
        for name, version in versions.items():
            found.setdefault("software", set()).add(f"{name} {version}")
    problems.add_many(absent, "sidecars")
    return {key: tuple(sorted(values)) for key, values in found.items()}, modes, sources


def _in_words(value: object) -> str:
    """Format a sidecar entry; a plate is described by manufacturer, model and serial number."""
    if isinstance(value, dict):
        identity = value.get("identity")
        known = identity if isinstance(identity, dict) else {}
        named = [known.get(key) for key in ("manufacturer", "model", "serial")]
        return " ".join(str(part) for part in named if part) or str(value.get("backend", "plate"))
    return str(value)


def refuse_mixture(modes: Sequence[tuple[str, Path]], folder: Path) -> None:
    """Raise a `UserError` if pilot records are mixed with participant records."""
    first: dict[str, Path] = {}
    for mode, path in modes:
        first.setdefault(mode, path)
    if len(first) > 1:
        examples = "; ".join(
            f"'{mode}' in {path.relative_to(folder)}" for mode, path in sorted(first.items())
        )
        raise UserError(
            "{folder}: pilot and participant records are mixed ({examples}); expected only one "
            "kind; move the pilot's files to a separate folder",
            folder=folder,
            examples=examples,
        )


def one_quantity(tables: Sequence[Path], folder: Path) -> Quantity:
    """Return the quantity shared by all tables; raise UserError if their quantities differ."""
    found = {quantity_of(table): table for table in tables}
    if len(found) > 1:
        (one, first), (other, second) = list(found.items())[:2]
        raise UserError(
            "{folder}: {first} is in {first_unit} and {second} in {second_unit}; expected data "
            "in one quantity; analyse each quantity separately",
            folder=folder,
            first=first.name,
            first_unit=one.unit_in_full,
            second=second.name,
            second_unit=other.unit_in_full,
        )
    return next(iter(found), PLATE_AMPLITUDE)


def participants(folder: Path, sources: list[Source], problems: Problems) -> pd.DataFrame:
    """Read ``participants.tsv`` without unnamed rows; empty if the file does not exist."""
    path = folder / "participants.tsv"
    if not path.is_file():
        return pd.DataFrame({PARTICIPANT: pd.Series(dtype=str)})
    frame, read = read_tables([path], folder, required=(PARTICIPANT,), problems=problems)
    sources += read
    frame[PARTICIPANT] = tidied(frame[PARTICIPANT]).astype("str")
    unnamed = frame[PARTICIPANT].isna()
    if unnamed.any():
        lines = listed_lines(frame.loc[unnamed, "line"].tolist())
        problems.add(f"{path.name}, {lines}: omitted, because there is no participant_id")
    return frame[~unnamed].drop(columns=["file", "line"]).reset_index(drop=True)


def choices(
    folder: Path,
    sources: list[Source],
    details: Mapping[str, tuple[str, ...]],
    problems: Problems,
) -> tuple[AnalysisChoices, tuple[str, ...], bool | None, str]:
    """Read the study file and its analysis choices.

    Returns
    -------
    choices : AnalysisChoices
        The defaults if there is no study file.
    keys : tuple of str
        Keys of the analysis choices that the study file sets.
    unchanged : bool or None
        Whether the sessions used this study file; None if this is unknown.
    text : str
        Content of the study file.
    """
    path = folder / "code" / "study.toml"
    if not path.is_file():
        return AnalysisChoices(), (), None, ""
    content, source = read_source(path, folder)
    sources.append(source)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise UserError("{path}: expected a TOML file ({error})", path=path, error=error) from error
    given = toml_table(text, str(path)).get("analysis", {})
    try:
        choices = AnalysisChoices.model_validate(given)
    except ValidationError as error:
        raise UserError(
            "{path}: {faults}", path=path, faults=faults_of(error, text, ("analysis",))
        ) from error
    table = given if isinstance(given, dict) else {}
    ran_with = details.get("study_hash", ())
    # Sessions hash the text, but editors and version control may change line endings.
    unchanged = digest(content.replace(b"\r\n", b"\n")) in ran_with if ran_with else None
    if unchanged is False:
        problems.add(
            "code/study.toml is not the study file of the sessions (no sidecar contains its "
            "SHA-256), so the analysis choices may have been made after the data were seen"
        )
    if len(ran_with) > 1:
        problems.add(
            f"The sessions used {len(ran_with)} different study files; the analysis choices are "
            "those in code/study.toml"
        )
    return choices, tuple(sorted(table)), unchanged, text


def add_sources(folder: Path, choices: AnalysisChoices, sources: list[Source]) -> None:
    """Add the data set's description, codebook and coded answers to ``sources``, if they exist."""
    names = ("dataset_description.json", "code/verbal_codes.tsv", choices.codebook)
    sources += [
        Source(name, digest(read_bytes(folder / name)))
        for name in names
        if name and (folder / name).is_file()
    ]


def title(folder: Path) -> str:
    """Return the name of the data set, by default the folder name."""
    path = folder / "dataset_description.json"
    try:
        return str(json.loads(path.read_text(encoding="utf-8"))["Name"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return folder.resolve().name
