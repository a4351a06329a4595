"""Read the data shown on the pages from the laboratory folder, at most once per second."""

from __future__ import annotations

import hashlib
import json
import shutil
import time
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from threading import Lock
from typing import NamedTuple

from slipscale.experiments.dataset.backup import not_backed_up
from slipscale.experiments.journal.journal import FALLBACK
from slipscale.experiments.journal.locks import is_being_written
from slipscale.experiments.journal.plan_and_progress import read_usable
from slipscale.experiments.lab.blind_summary import RunSummary, summary
from slipscale.experiments.lab.console.notices import notices
from slipscale.experiments.lab.defaults import Defaults, here
from slipscale.experiments.lab.roster import Roster, Visit, read_roster
from slipscale.experiments.lab.unblinding import results_may_be_seen, unblinded
from slipscale.experiments.session.mailbox import STATUS, LiveStatus, mailbox_of, read_status
from slipscale.experiments.session.mailbox import beat_ns as beat_ns_of
from slipscale.experiments.study.file import read_study
from slipscale.experiments.study.model import Study
from slipscale.faults import UserError, harmless
from slipscale.faults.message import Message, from_data

FRESH_S = 1.0
SILENT_S = 5  # sessions check for requests 20 times per second, except while a surface settles
RESULTS = Path("derivatives", "slipscale")
TABLE3 = "table3.csv"
PLANNING = Path("planning")  # power results and frozen plans


@dataclass(frozen=True, slots=True, kw_only=True)
class Live:
    """The session that is currently running.

    Parameters
    ----------
    status : LiveStatus or None
        None if the session reports no status, because its mailbox could not be created.
    pilot : bool
        Whether the session is a rehearsal, which is recorded as a pilot.
    left_s : float or None
        Estimated remaining time, based on the session's pace or, before the end of its first trial,
        on earlier runs.
    silent_s : int
        Time in seconds since the session last showed activity; 0 if shorter than `SILENT_S`.
    """

    label: str
    visit: Visit
    status: LiveStatus | None
    summary: RunSummary
    pilot: bool
    left_s: float | None
    silent_s: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """The state of the laboratory folder at one point in time.

    Parameters
    ----------
    problem : str
        Reason why the folder cannot be shown; empty if it can.
    rehearsals : Roster
        The participants in the rehearsal folder.
    seen : bool
        Whether the console may show means and figures.
    unblinded_utc : tuple of str
        Times at which the study was unblinded early.
    results_ns : int or None
        Modification time of the last analysis results; None if there are none.
    notices : tuple of str
        Notices about irregularities; see `slipscale.experiments.lab.console.notices`.
    free_gb : float or None
        Free space on the disk with the data; None if it is unknown.
    without_backup : int or None
        Number of runs that have not been backed up; None if no backup folder is set.
    """

    problem: str = ""
    defaults: Defaults = field(default_factory=Defaults)
    study: Study | None = None
    study_text: str = ""
    roster: Roster | None = None
    rehearsals: Roster | None = None
    live: Live | None = None
    seen: bool = False
    unblinded_utc: tuple[str, ...] = ()
    results_ns: int | None = None
    notices: tuple[str, ...] = ()
    free_gb: float | None = None
    without_backup: int | None = None


class Pulse(NamedTuple):
    """Times of a running session's last status and last record, and whether it is still running."""

    told_ns: int | None = None
    recorded_ns: int | None = None
    there: bool = True


class State:
    """State of the laboratory folder, which is the current working directory of the process."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._read_s = float("-inf")
        self._snapshot = Snapshot()
        self._last = Pulse()
        self._beat: tuple[int | None, float] = (None, 0.0)

    def now(self, *, fresh: bool = False) -> Snapshot:
        """Return a snapshot, at most one second old, with the running session's current state.

        If ``fresh`` is True, the whole snapshot is read again.
        """
        with self._lock:
            pulse = self.pulse()
            if fresh or time.monotonic() - self._read_s > FRESH_S or not pulse.there:
                self._snapshot = take_snapshot()
                self._read_s = time.monotonic()
                pulse = self.pulse()
            elif pulse != self._last and self._snapshot.live:
                self._snapshot = replace(self._snapshot, live=_anew(self._snapshot))
            self._last = pulse
            return self._with_silence()

    def _with_silence(self) -> Snapshot:
        """Return the snapshot after adding the time since the session's last activity."""
        live = self._snapshot.live
        if live is None or live.status is None:
            return self._snapshot
        beat_ns, now_s = beat_ns_of(live.visit.path), time.monotonic()
        if beat_ns != self._beat[0]:
            self._beat = (beat_ns, now_s)
        silent_s = int(now_s - self._beat[1])
        silence_s = silent_s if silent_s >= SILENT_S else 0
        return replace(self._snapshot, live=replace(live, silent_s=silence_s))

    def pulse(self) -> Pulse:
        """Return a value that changes when the running session reports or records something."""
        live = self._snapshot.live
        if live is None or live.status is None:
            return Pulse()
        status_ns = _changed_ns(mailbox_of(live.visit.path) / STATUS)
        return Pulse(status_ns, _changed_ns(live.visit.path), there=status_ns is not None)

    def version(self, *more: object) -> str:
        """Return a digest that changes if anything on a page may have changed."""
        found = self.now()
        return hashlib.sha256(repr((found, more)).encode()).hexdigest()[:16]


def take_snapshot() -> Snapshot:
    """Read the current folder. Problems are stored in the snapshot and never raised."""
    defaults = Defaults()
    try:
        defaults = here()
        if defaults.file is None:
            return Snapshot(
                problem=Message(
                    "{folder}: slipscale.toml is missing; set the folder up on the Settings "
                    "page, or restore the file",
                    folder=Path.cwd(),
                )
            )
        study, text = read_study(defaults.study)
        roster = read_roster(defaults.data, study, text)
        rehearsals = read_roster(defaults.out(pilot=True), study, text)
        return Snapshot(
            defaults=defaults,
            study=study,
            study_text=text,
            roster=roster,
            rehearsals=rehearsals,
            live=_anew(Snapshot(study=study, roster=roster, rehearsals=rehearsals)),
            seen=results_may_be_seen(defaults.data, roster),
            unblinded_utc=tuple(unblinded(defaults.data)),
            results_ns=_changed_ns(defaults.data / RESULTS / TABLE3),
            notices=notices(defaults, study, text, (roster, rehearsals), datetime.now(UTC)),
            free_gb=_free_gb(defaults.data),
            without_backup=len(not_backed_up(defaults.data, defaults.backup))
            if defaults.backup
            else None,
        )
    except UserError as error:
        return Snapshot(problem=harmless(str(error)), defaults=defaults)
    except FileNotFoundError:
        return Snapshot(problem="The laboratory folder is missing. Is its disk connected?")


def _anew(found: Snapshot) -> Live | None:
    """Return the current state of the running session."""
    for roster, pilot in ((found.roster, False), (found.rehearsals, True)):
        if roster and (live := _live(roster, pilot=pilot)):
            return live
    return next(_elsewhere(found), None) if found.study else None


def _elsewhere(found: Snapshot) -> Iterator[Live]:
    """Yield running sessions of this study whose journals are in the fallback folder."""
    boxes = (Path.home() / FALLBACK).glob("*/sourcedata/*/*_journal.jsonl.live")
    for path in (box.with_suffix("") for box in boxes):
        if not is_being_written(path):
            continue
        plan, _ = read_usable(path, most=1)
        if plan is None or found.study is None or plan.study.name != found.study.name:
            continue
        status = read_status(path)
        visit = Visit(session=plan.session, run=plan.run, path=path, state="running now")
        yield Live(
            label=plan.participant,
            visit=visit,
            status=status,
            summary=summary(path),
            pilot=plan.mode == "pilot",
            left_s=status.time_left_s if status else None,
        )


def _live(roster: Roster, *, pilot: bool) -> Live | None:
    visit = roster.running
    if visit is None:
        return None
    person = next(person for person in roster.people if visit in person.visits)
    status = read_status(visit.path)
    return Live(
        label=person.label,
        visit=visit,
        status=status,
        summary=summary(visit.path),
        pilot=pilot,
        left_s=_left_s(roster, status),
    )


def _left_s(roster: Roster, status: LiveStatus | None) -> float | None:
    if status is None:
        return None
    if status.time_left_s is not None:
        return status.time_left_s
    known = usual_duration_s(roster)
    return max(known - status.elapsed_s, 0.0) if known else None


def usual_duration_s(roster: Roster) -> float | None:
    """Return the mean duration of complete runs; None if there are none."""
    visits = [visit for person in roster.people for visit in person.visits]
    took = [summary(visit.path).duration_s for visit in visits if visit.state == "complete"]
    return sum(took) / len(took) if took else None


def _free_gb(data: Path) -> float | None:
    """Return the free space in GB on the disk of the data folder, which may not exist yet."""
    try:
        return round(shutil.disk_usage(data if data.is_dir() else Path()).free / 1e9, 1)
    except OSError:
        return None


def _changed_ns(path: Path) -> int | None:
    return changed_ns(path) or None


def changed_ns(path: Path) -> int:
    """Return the modification time of a file; 0 if the file does not exist."""
    try:
        return path.stat().st_mtime_ns
    except OSError:
        return 0


def ended_runs(found: Snapshot) -> frozenset[tuple[Path, int]]:
    """Return the participants' complete runs, with the modification times of their journals."""
    people = found.roster.people if found.roster else ()
    paths = [v.path for person in people for v in person.visits if v.state == "complete"]
    return frozenset((path, changed_ns(path)) for path in paths)


def pilots(defaults: Defaults) -> list[Path]:
    """Return the folders of simulated pilots, newest first."""
    found = [path for path in defaults.pilots.glob("[0-9]*") if path.name.isdigit()]
    return sorted(found, key=lambda path: int(path.name), reverse=True)


def export_folder(data: Path) -> Path:
    """Return the folder for the console's exports; a withdrawal removes it with the results."""
    return data / RESULTS / "export"


def frozen_plans() -> list[Path]:
    """Return the frozen plans in the folder, newest first."""
    return sorted(PLANNING.glob("plan-[0-9]*.zip"), reverse=True)


def digest_of(plan: Path) -> str:
    """Return the SHA-256 that identifies a frozen plan, as on its page; empty if unreadable."""
    try:
        with zipfile.ZipFile(plan) as bundle:
            return str(json.loads(bundle.read("manifest.json"))["digest"])
    except (OSError, ValueError, LookupError, TypeError, zipfile.BadZipFile):
        return ""


def rows_of_table3(dataset: Path) -> list[list[str]]:
    """Return the rows of Table III in the last analysis, header first; empty if there are none."""
    try:
        lines = (dataset / RESULTS / TABLE3).read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
    return [line.split(",") for line in lines]


def findings(text: str) -> list[dict[str, object]] | None:
    """Return the list of findings in a job's JSON output; None if the output is not a list."""
    try:
        found = json.loads(text)
        if not isinstance(found, list):
            return None
        return [
            {k: harmless(from_data(v)) if isinstance(v, dict) else v for k, v in each.items()}
            for each in found
        ]
    except (ValueError, TypeError, AttributeError):
        return None
