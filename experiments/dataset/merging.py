"""Merge two data sets into a new one, for example if a study was run on two computers.

Journals are copied unchanged, and the tables are built from the journals. All contradictions
between the data sets are reported together, before anything is written. The new data set has a
temporary name until it is complete. If a merge is interrupted, there is therefore no incomplete
data set, and the merge can be repeated.
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from slipscale.experiments.dataset.backup import KNOWN, backups
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.files import draft_of, write_file
from slipscale.experiments.dataset.former_tables import with_former
from slipscale.experiments.dataset.hand_exclusions import EVERY
from slipscale.experiments.dataset.journals import Problem, journals, mode_of, read_runs
from slipscale.experiments.dataset.lineage import note_merged, note_source
from slipscale.experiments.dataset.rendering import README
from slipscale.experiments.dataset.withdrawn import RECORD, entries, unfinished, withdrawn
from slipscale.experiments.journal.locks import is_being_written
from slipscale.experiments.journal.plan_and_progress import read_usable
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError
from slipscale.faults.folders import visible
from slipscale.faults.message import Message


@dataclass(frozen=True, slots=True, kw_only=True)
class Merged:
    """The result of a merge.

    Parameters
    ----------
    runs : int
        Number of runs in the new data set.
    notes : tuple of str
        Remarks that do not prevent the merge.
    problems : tuple of Problem
        Damage in the source data sets that was copied to the new data set.
    """

    runs: int
    notes: tuple[str, ...]
    problems: tuple[Problem, ...]


def merge(one: Path, other: Path, out: Path) -> Merged:
    """Merge two data sets into a new data set, without changing the data in the sources.

    Raises
    ------
    UserError
        If a folder is not a data set or is in use by a session, if ``out`` is not empty, or if the
        data sets contradict each other. The message lists all contradictions: a mixture of pilots
        and participants; different studies, study versions or seeds; different runs under the same
        name; a participant with two labels; a withdrawal from only one data set; data that only
        tables contain; and different versions of files written by people.
    """
    sources = (one, other)
    for folder in sources:
        _check_source(folder)
    if any(out.resolve().is_relative_to(source.resolve()) for source in sources):
        raise UserError("--out {out}: is in a source, which stays unchanged; name another", out=out)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UserError("--out {out}: is not an empty folder; name a new folder", out=out)
    chosen = _by_place(one)
    for place, path in _by_place(other).items():
        # For each run, the longer journal is used, because the shorter one was copied before the
        # run continued.
        if place not in chosen or path.stat().st_size > chosen[place].stat().st_size:
            chosen[place] = path
    contradictions = [*_contradictions(one, other), *_own_files(one, other, chosen)]
    if contradictions:
        many = (
            "1 contradiction"
            if len(contradictions) == 1
            else f"{len(contradictions)} contradictions"
        )
        lines = "".join(f"\n  {sentence}" for sentence in contradictions)
        raise UserError(
            "{one} and {other} cannot be merged because of {many}:{lines}",
            one=one,
            other=other,
            many=many,
            lines=lines,
        )
    # The merge is recorded before data are copied, so that a withdrawal also removes the copy.
    for folder in sources:
        note_merged(folder, out)
    try:
        problems = _write(one, other, out, chosen)
    except OSError as error:
        raise UserError(
            "--out {out}: cannot be written ({reason})", out=out, reason=error.strerror
        ) from None
    runs, _ = read_runs(out)
    return Merged(runs=len(runs), notes=tuple(_in_both(one, other)), problems=tuple(problems))


def _write(one: Path, other: Path, out: Path, chosen: dict[Path, Path]) -> list[Problem]:
    """Build the new data set in a temporary folder, rename the folder, and return all problems."""
    draft = draft_of(out)
    if draft.exists():
        shutil.rmtree(draft)
    for place, path in chosen.items():
        (draft / place).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(path, draft / place)
    _write_lists(one, other, draft)
    problems = build_dataset(draft)
    if out.exists():
        out.rmdir()
    draft.rename(out)
    return problems


def _check_source(folder: Path) -> None:
    found = journals(folder)
    if not found:
        raise UserError("{folder}: no journals; expected a data set folder", folder=folder)
    for path in found:
        if is_being_written(path):
            raise UserError("{path}: a session is running; end it first", path=path)
    for sentence in unfinished(folder):
        raise UserError("{folder}: {sentence}", folder=folder, sentence=sentence)


def _by_place(folder: Path) -> dict[Path, Path]:
    return {path.relative_to(folder): path for path in journals(folder)}


def _contradictions(one: Path, other: Path) -> Iterator[str]:
    """Yield the contradictions between two data sets."""
    modes = {folder: mode_of(folder) for folder in (one, other)}
    if None not in modes.values() and modes[one] != modes[other]:
        yield Message(
            "{one} contains {mode} data, but {other} contains {other_mode} data",
            one=one,
            mode=modes[one],
            other=other,
            other_mode=modes[other],
        )
    for folder in (one, other):
        for problem in with_former(folder, read_runs(folder)[0]).problems:
            yield f"{folder}: {problem}"
    ours, others = _by_place(one), _by_place(other)
    for place in sorted(set(ours) & set(others)):
        shorter, longer = sorted((ours[place].read_bytes(), others[place].read_bytes()), key=len)
        if not longer.startswith(shorter):
            yield (
                Message(
                    "{place}: the data sets contain different runs under this name (perhaps of "
                    "two people with the same number)",
                    place=place,
                )
            )
    plans = {folder: list(_plans(folder)) for folder in (one, other)}
    names = [{plan.study.name for plan in plans[folder]} for folder in (one, other)]
    if names[0] and names[1] and not names[0] & names[1]:
        yield (
            Message(
                "{one} contains study {studies}, but {other} contains study {other_studies}",
                one=one,
                studies=_listed(names[0]),
                other=other,
                other_studies=_listed(names[1]),
            )
        )
    for name in sorted(names[0] & names[1]):
        texts = [
            {plan.study_text for plan in plans[folder] if plan.study.name == name}
            for folder in (one, other)
        ]
        if texts[0] != texts[1]:
            yield Message("study '{name}': the study files in the two data sets differ", name=name)
        seeds = {plan.seed for folder in plans for plan in plans[folder] if plan.study.name == name}
        if len(seeds) > 1:
            numbers = ", ".join(map(str, sorted(seeds)))
            yield Message(
                "study '{name}' was run with different seeds: {numbers}", name=name, numbers=numbers
            )
    yield from _people(one, other, {plan.participant for each in plans.values() for plan in each})


def _people(one: Path, other: Path, present: set[str]) -> Iterator[str]:
    plain: dict[str, str] = {}
    for label in sorted(present):
        alike = plain.setdefault(label.casefold().lstrip("0"), label)
        if alike != label:
            yield f"participants {alike} and {label} would be mistaken for the same person"
    for folder, rest in ((one, other), (other, one)):
        participants = {path.parent.name.removeprefix("sub-") for path in journals(rest)}
        for label in sorted(set(withdrawn(folder)) & participants):
            yield (
                f"participant {label} withdrew from {folder}, but {rest} contains their data: "
                f"slipscale data withdraw {rest} --participant {label}"
            )


def _plans(folder: Path) -> Iterator[RunPlan]:
    for path in journals(folder):
        plan, _ = read_usable(path, most=1)
        if plan:
            yield plan


def _own_files(one: Path, other: Path, chosen: dict[Path, Path]) -> Iterator[str]:
    """Add the files that Slipscale did not generate to ``chosen``.

    Yield a message for each of these files that differs between the two data sets.
    """
    code = {
        path.relative_to(f) for f in (one, other) for path in visible(f, "code/*") if path.is_file()
    }
    made = {place for place in code if re.fullmatch(r"study(_[0-9a-f]{8})?\.toml", place.name)}
    decided = {path.relative_to(f) for f in (one, other) for path in visible(f, EVERY.as_posix())}
    for place in (Path(README), *sorted((code - made) | decided)):
        found = [folder / place for folder in (one, other) if (folder / place).is_file()]
        if len({path.read_bytes() for path in found}) > 1:
            yield (
                Message(
                    "{place}: this file differs between the data sets; make the copies the same",
                    place=place,
                )
            )
        elif found:
            chosen[place] = found[0]


def _write_lists(one: Path, other: Path, out: Path) -> None:
    """Write the combined lists of withdrawals and of backups."""
    withdrawn_people: dict[str, object] = {}
    for folder in (one, other):
        withdrawn_people |= {str(entry["participant"]): entry for entry in entries(folder)}
        note_source(out, folder)
    if withdrawn_people:
        write_file(out / RECORD, json.dumps(list(withdrawn_people.values()), indent=2) + "\n")
    if places := [*dict.fromkeys(str(each) for f in (one, other) for each in backups(f))]:
        write_file(out / KNOWN, json.dumps(places) + "\n")


def _in_both(one: Path, other: Path) -> Iterator[str]:
    """Yield a note for each participant with runs in both data sets."""
    labels = [{path.parent.name.removeprefix("sub-") for path in journals(f)} for f in (one, other)]
    own = set(_by_place(one)) ^ set(_by_place(other))
    for label in sorted(labels[0] & labels[1]):
        if any(place.parent.name == f"sub-{label}" for place in own):
            yield (
                f"participant {label} has runs in both data sets; they are treated as the "
                "same person"
            )


def _listed(names: set[str]) -> str:
    return ", ".join(sorted(names))
