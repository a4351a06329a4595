"""Read the runs of a data set from its journals, and report damaged records.

A damaged journal does not affect other runs, and its intact records are still used.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from slipscale.experiments.dataset.lost_header import header_from_tables
from slipscale.experiments.dataset.rows_from_journal import Gathered, gather
from slipscale.experiments.journal.plan_and_progress import is_complete, read_usable
from slipscale.experiments.journal.reading import Damage, has_begun
from slipscale.experiments.journal.record import Record
from slipscale.experiments.study.run_plan import Mode, RunPlan
from slipscale.faults import UserError, harmless
from slipscale.faults.folders import visible
from slipscale.faults.message import Message

#: What programs and people add to the name of a copy: a space and what follows, up to the ending.
COPIED = re.compile(r" .*?(?=(?:\.\w+)?$)")
#: Journals, and the files that a running session keeps beside them.
USED = re.compile(
    r"^sourcedata/sub-[A-Za-z0-9]+/[A-Za-z0-9_-]+_journal\.jsonl(\.lock|\.lock\.new|\.live)?$"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """A problem with a file in a data set.

    Parameters
    ----------
    file : str
        Path in the data set, with forward slashes.
    place : str
        Position in the file, such as "line 3", "row 2" or the name of an entry; empty if the
        problem concerns the whole file.
    what : str
        Description of the problem.
    """

    file: str
    place: str = ""
    what: str

    def __str__(self) -> str:
        """Return a sentence with the file, the position in the file and the problem."""
        return harmless(": ".join(part for part in (self.file, self.place, self.what) if part))


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """A run that was read from a journal in a data set."""

    path: Path
    plan: RunPlan
    records: list[Record]
    damage: tuple[Damage, ...]
    gathered: Gathered

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return is_complete(self.records)


def journals(dataset: Path) -> list[Path]:
    """Return the paths of a data set's journals, sorted."""
    return visible(dataset / "sourcedata", "sub-*/*_journal.jsonl")


def copies(dataset: Path) -> Iterator[Problem]:
    """Yield the files and folders that the data set does not use, such as ``sub-01 (1)``.

    Programs that synchronise folders write such copies, and an answer may be only in the copy. Any
    file that may hold records of a session is named, wherever it is.
    """
    for path in visible(dataset, "**/*.jsonl*"):
        if path.is_file() and not USED.search(path.relative_to(dataset).as_posix()):
            file = path.relative_to(dataset).as_posix()
            if not any(map(COPIED.search, (path.name, path.parent.name))):
                yield Problem(
                    file=file,
                    what=Message(
                        "is not used; a journal has a name such as "
                        "sourcedata/sub-01/sub-01_run-01_journal.jsonl"
                    ),
                )
    for pattern in ("*", "sub-*/**/*", "sourcedata/**/*"):
        for path in visible(dataset, pattern):
            if not COPIED.search(path.name) or COPIED.search(path.parent.name):
                continue
            file = path.relative_to(dataset).as_posix()
            original = path.with_name(COPIED.sub("", path.name))
            what = Message(
                "is not used; it seems to be a copy: compare it with the original, and remove it"
            )
            if path.suffix == ".jsonl" and original.is_file():
                lines, own = (each.read_bytes().count(b"\n") for each in (path, original))
                what = Message(
                    "is not used; it seems to be a copy: compare it with the original, and remove "
                    "it ({lines} records here, {own} in the original)",
                    lines=lines,
                    own=own,
                )
            yield Problem(file=file, what=what)


def mode_of(dataset: Path) -> Mode | None:
    """Return the mode of a data set ("pilot" or "participant"), or None without readable runs.

    Raises
    ------
    UserError
        If the data set contains both pilots and participants.
    """
    modes: set[Mode] = set()
    for path in journals(dataset):
        # Only the first records are read, and damaged records are skipped, so that damage does not
        # delay the next participant.
        try:
            plan, _ = read_usable(path, most=1)
        except UserError:
            continue
        if plan:
            modes.add(plan.mode)
    if len(modes) > 1:
        raise UserError(
            "{dataset}: contains both pilot and participant data, which must not be mixed",
            dataset=dataset,
        )
    return modes.pop() if modes else None


def read_runs(dataset: Path) -> tuple[list[Run], list[Problem]]:
    """Return a data set's runs in the order of their journals, and any damage to the journals.

    Raises
    ------
    UserError
        If the data set contains both pilots and participants.
    """
    mode_of(dataset)
    runs: list[Run] = []
    problems = list(copies(dataset))
    for path in journals(dataset):
        file = path.relative_to(dataset).as_posix()
        try:
            run = _read_run(dataset, path, problems)
        except UserError as error:
            problems.append(
                Problem(file=file, what=Message("no run can be read ({error})", error=error))
            )
            continue
        if run:
            runs.append(run)
            problems += [
                Problem(file=file, place=f"line {damage.line}", what=f"damaged: {damage.reason}")
                for damage in run.damage
            ]
    return runs, problems


def _read_run(dataset: Path, path: Path, problems: list[Problem]) -> Run | None:
    """Return the run in a journal, or None if it has not begun or cannot be identified."""
    if not has_begun(path):
        return None
    plan, reading = read_usable(path)
    file = path.relative_to(dataset).as_posix()
    if plan is None and reading.records and (known := header_from_tables(dataset, path)):
        plan, header = known
        _, reading = read_usable(path, header=header.data)
        # If more than the header is damaged, the record that marks the damage is kept, so that the
        # first trial is flagged.
        whole = len(reading.records) > 1 and reading.records[1].number == 1
        reading.records[: 1 if whole else 0] = [header]
        remark = "the header's content was taken from the run's sidecar"
        problems.append(Problem(file=file, place="line 1", what=remark))
    if plan is None:
        reason = str(reading.damage[0]) if reading.damage else "no header"
        problems.append(
            Problem(
                file=file,
                what=Message(
                    "the first record is damaged ({reason}), so the run cannot be "
                    "identified; the journal is not used",
                    reason=reason,
                )
                if reading.records
                else (
                    "the first record is incomplete: the journal is empty, and the run can be "
                    "started again"
                ),
            )
        )
        return None
    if plan.journal_path(dataset) != path:
        expected = plan.journal_path(dataset).relative_to(dataset).as_posix()
        raise UserError(
            "the journal was written as {expected}; restore that name", expected=expected
        )
    plan.tasks()  # raises an error if the study cannot be read
    return Run(
        path=path,
        plan=plan,
        records=reading.records,
        damage=tuple(reading.damage),
        gathered=gather(reading.records),
    )
