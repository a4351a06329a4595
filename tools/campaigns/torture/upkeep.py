"""Kill the commands that change a data set with SIGKILL: build, withdraw, merge and backup.

A withdrawal starts with a data set of three participants with a questionnaire, its backup, a merged
data set, a journal in a fallback folder, and results. Each command is killed before one of its
system calls and then run again. Afterwards, the withdrawal record must be the only trace of a
participant who withdrew, and the rows and journals of all others must be complete.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING
from unittest import mock

from slipscale.experiments.dataset.backup import back_up
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.journals import journals
from slipscale.experiments.dataset.merging import merge
from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.dataset.withdrawal import withdraw
from slipscale.experiments.dataset.withdrawn import RECORD, pending, withdrawn
from slipscale.experiments.journal.journal import FALLBACK
from slipscale.experiments.running.pilot import run_simulated
from slipscale.experiments.study.file import study_text
from tools.campaigns.torture.pilots import Outcome, folder, plans_of, spread
from tools.campaigns.torture.system_calls import NEVER, SIGKILL, Strike, in_a_process

if TYPE_CHECKING:
    from slipscale.experiments.study.run_plan import RunPlan

QUESTIONNAIRE = """
[[questionnaires]]
name = "habits"
description = "Made up"
when = "before"
options = ["1", "2", "3"]
items = [{ name = "h01", prompt = "Do you like to touch?" }]
"""
GONE = "sub-01"


def strike_upkeep(places: int, outcome: Outcome, strike: Strike = SIGKILL) -> None:
    """Strike each command at ``places`` system calls (0: at every call), and run it again."""
    with folder() as root, _at_home(root / "laboratory" / "home"):
        study = root / "biet2007.toml"
        study.write_text(study_text("biet2007") + QUESTIONNAIRE, encoding="utf-8")
        plans = plans_of(str(study), 4)
        for turn, (name, (prepare, act, judge)) in enumerate(COMMANDS.items()):
            place, base = root / "laboratory", root / "base"
            prepare(place, plans)
            place.rename(base)
            shutil.copytree(base, place)
            before = _rows(place)
            calls = in_a_process(root, NEVER, partial(act, place), strike)
            for at in spread(calls or 0, places, turn):
                shutil.rmtree(place)
                shutil.copytree(base, place)
                try:
                    struck = in_a_process(root, at, partial(act, place), strike) is None
                    if struck:
                        act(place)
                    problem = judge(place, before) or ("" if struck else "not struck")
                except Exception as error:  # noqa: BLE001 - any exception is a problem
                    problem = repr(error)
                outcome.judge(f"{strike.name} in {name}", plans[0], f"at call {at}", problem)
            shutil.rmtree(place)
            shutil.rmtree(base)


@contextmanager
def _at_home(home: Path) -> Iterator[None]:
    """Restrict the search for fallback folders to the campaign's folder."""
    with (
        mock.patch.dict(os.environ, {"HOME": str(home)}),
        mock.patch.object(tempfile, "tempdir", str(home)),
    ):
        yield


def _recorded(place: Path, plans: list[RunPlan]) -> Path:
    data = place / "data"
    for plan in plans[:3]:
        run_simulated(data, plan, "mock")
    build_dataset(data)
    return data


def _laboratory(place: Path, plans: list[RunPlan]) -> None:
    data = _recorded(place, plans)
    run_simulated(place / "other", plans[3], "mock")
    (place / "disk").mkdir()
    _back_up(place)
    build_dataset(place / "disk/data")
    merge(data, place / "other", place / "both")
    kept = place / "home" / FALLBACK / "x"
    own = plans[0].journal_path(data)
    (kept / own.relative_to(data)).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(own, kept / own.relative_to(data))
    for each in (data, place / "both"):
        (each / "derivatives/slipscale").mkdir(parents=True)
        (each / "derivatives/slipscale/estimates.csv").write_text(GONE, encoding="utf-8")


def _withdraw(place: Path) -> None:
    data = place / "data"
    if "01" not in withdrawn(data) or pending(data):
        withdraw(data, "01")


def _nobody_left(place: Path, before: dict[Path, set[str]]) -> str:
    """Describe a remaining trace of the participant who withdrew, or a loss of other data."""
    for path in sorted(place.rglob("*")):
        named = GONE in path.name or (path.is_file() and GONE.encode() in path.read_bytes())
        if named:
            return f"{path.relative_to(place)} names {GONE}"
    notes = [place / name / RECORD for name in ("data", "both")]
    if not all(note.is_file() for note in notes) or pending(place / "data"):
        return "the withdrawal is not on the list, or not finished"
    for name in ("data", "both", "disk/data"):
        if problems := verify(place / name):
            return str(problems[0])
    return _lost(place, {path: {r for r in rows if GONE not in r} for path, rows in before.items()})


def _cut(place: Path, plans: list[RunPlan]) -> None:
    data = _recorded(place, plans)
    run_simulated(data, plans[3], "mock")
    cut, emptied = (plan.journal_path(data) for plan in plans[:2])
    cut.write_bytes(b"".join(cut.read_bytes().splitlines(keepends=True)[:20]))
    emptied.write_bytes(b"")


def _build(place: Path) -> None:
    build_dataset(place / "data")


def _none_lost(place: Path, before: dict[Path, set[str]]) -> str:
    people = (place / "data/participants.tsv").read_text(encoding="utf-8")
    return _lost(place, before) or ("" if "sub-04" in people else "sub-04 is not in the tables")


def _two(place: Path, plans: list[RunPlan]) -> None:
    _recorded(place, plans)
    run_simulated(place / "other", plans[3], "mock")
    build_dataset(place / "other")


def _merge(place: Path) -> None:
    if not (place / "both").exists():
        merge(place / "data", place / "other", place / "both")


def _all_in_both(place: Path, before: dict[Path, set[str]]) -> str:
    merged = _rows(place / "both")
    for path, rows in before.items():
        name = Path(*path.parts[1:])
        if not rows <= merged.get(name, set()):
            return f"both/{name}: rows are missing"
    if problems := verify(place / "both"):
        return str(problems[0])
    return _lost(place, before)


def _alone(place: Path, plans: list[RunPlan]) -> None:
    _recorded(place, plans)
    (place / "disk").mkdir()


def _back_up(place: Path) -> None:
    for path in journals(place / "data"):
        back_up(place / "data", path, place / "disk")


def _same_journals(place: Path, before: dict[Path, set[str]]) -> str:
    for path in journals(place / "data"):
        copy = place / "disk" / path.relative_to(place)
        if copy.read_bytes() != path.read_bytes():
            return f"{copy.name} differs"
    return _lost(place, before)


def _rows(place: Path) -> dict[Path, set[str]]:
    """Return the rows of all tables below a folder.

    The last column of participants.tsv (whether all runs are complete) is omitted, because it may
    change.
    """
    found = {}
    for path in place.rglob("*.tsv"):
        rows = path.read_text(encoding="utf-8").splitlines()
        if path.name == "participants.tsv":
            rows = [row.rpartition("\t")[0] for row in rows]
        found[path.relative_to(place)] = set(rows)
    return found


def _lost(place: Path, before: dict[Path, set[str]]) -> str:
    now = _rows(place)
    for path, rows in before.items():
        theirs = GONE in path.as_posix() and not (place / path).exists()
        if not theirs and (missing := rows - now.get(path, set())):
            return f"{path}: lost {min(missing)!r}"
    return ""


COMMANDS: dict[
    str,
    tuple[
        Callable[[Path, list[RunPlan]], None],
        Callable[[Path], None],
        Callable[[Path, dict[Path, set[str]]], str],
    ],
] = {
    "withdraw": (_laboratory, _withdraw, _nobody_left),
    "build": (_cut, _build, _none_lost),
    "merge": (_two, _merge, _all_in_both),
    "backup": (_alone, _back_up, _same_journals),
}
