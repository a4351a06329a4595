"""Notices about irregularities in the laboratory folder, which every page shows.

A notice reports something that is not visible in the table of participants. A notice never prevents
a session from starting.
"""

from __future__ import annotations

from datetime import datetime
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.experiments.journal.plan_and_progress import read_usable
from slipscale.faults import UserError
from slipscale.faults.message import Message

if TYPE_CHECKING:
    from slipscale.experiments.lab.defaults import Defaults
    from slipscale.experiments.lab.roster import Roster, Visit
    from slipscale.experiments.study.model import Study

AHEAD_S = 120.0  # tolerated difference between the clocks of two computers
MOST_NAMED = 5


def notices(
    defaults: Defaults, study: Study, text: str, rosters: tuple[Roster, Roster], now: datetime
) -> tuple[str, ...]:
    """Return notices about concurrent sessions, damaged journals, the clock and study changes.

    Parameters
    ----------
    text : str
        Current text of the study file.
    rosters : tuple of Roster
        Participants first, then rehearsals.
    now : datetime
        Current time in UTC.
    """
    begun = [
        (person.label, visit)
        for roster in rosters
        for person in roster.people
        for visit in person.visits
        if visit.state != "free"
    ]
    visits = [
        (person.label, visit)
        for person in rosters[0].people
        for visit in person.visits
        if visit.state != "free"
    ]
    found = (
        _running(begun),
        *(_damaged(label, visit) for label, visit in begun if visit.state == "damaged"),
        _still_to_come(begun, now),
        _edited(visits, defaults.study, study.name, text),
    )
    return tuple(sentence for sentence in found if sentence)


def _running(begun: list[tuple[str, Visit]]) -> str:
    """Return a notice if several sessions are running, each with its own plate and window."""
    names = [f"participant {label} ({v})" for label, v in begun if v.state == "running now"]
    if len(names) < 2:  # noqa: PLR2004
        return ""
    return Message(
        "{count} sessions are running: {names}. These pages show and control the first "
        "session; control the other sessions in their own terminals",
        count=len(names),
        names=", ".join(names),
    )


def _damaged(label: str, visit: Visit) -> str:
    return Message(
        "the journal of participant {label} ({visit}) is damaged{where}: {visit_path}; the "
        "undamaged records are used (for details: slipscale data verify)",
        label=label,
        visit=visit,
        where=_where(visit.path),
        visit_path=visit.path,
    )


def _where(path: Path) -> str:
    try:
        stat = path.stat()
        line = _first_damage(path, stat.st_ino, stat.st_mtime_ns, stat.st_size)
    except (OSError, UserError):
        return ""
    return Message(" at line {line}", line=line) if line else ""


@lru_cache(maxsize=256)
def _first_damage(path: Path, _inode: int, _changed_ns: int, _size: int) -> int | None:
    damage = read_usable(path)[1].damage
    return damage[0].line if damage else None


def _still_to_come(begun: list[tuple[str, Visit]], now: datetime) -> str:
    """Return a notice if the last run began in the future because a clock was or is wrong."""
    last = max(begun, key=lambda each: each[1].started_utc, default=None)
    if last is None or not last[1].started_utc:
        return ""
    label, visit = last
    began = datetime.fromisoformat(visit.started_utc)
    if (began - now).total_seconds() < AHEAD_S:
        return ""
    return Message(
        "the clock of this computer was changed: it shows {now} UTC, but participant {label} "
        "({visit}) began at {began} UTC. Correct the clock before the next session; answers "
        "and response times are not affected",
        now=f"{now:%Y-%m-%d %H:%M}",
        label=label,
        visit=visit,
        began=f"{began:%Y-%m-%d %H:%M}",
    )


def _edited(visits: list[tuple[str, Visit]], file: str, name: str, text: str) -> str:
    """Return a notice if the study file differs from the version in a participant's journal."""
    other = [label for label, visit in visits if _has_another_text(visit.path, name, text)]
    if not other:
        return ""
    people = ", ".join([*dict.fromkeys(other)][:MOST_NAMED])
    more = ", ..." if len(other) > MOST_NAMED else ""
    return Message(
        "{file} has been edited since participants took part ({people}{more}): their "
        "journals keep the earlier version, and later participants get the new version. "
        "Restore the file, or give the changed study another name and another data folder",
        file=file,
        people=people,
        more=more,
    )


def _has_another_text(path: Path, name: str, text: str) -> bool:
    try:
        stat = path.stat()
        ran_with = _study_text(path, stat.st_ino)
    except (OSError, UserError):
        return False
    return ran_with is not None and ran_with[0] == name and ran_with[1] != _plain(text)


@lru_cache(maxsize=4096)
def _study_text(path: Path, _inode: int) -> tuple[str, str] | None:
    plan, _ = read_usable(path, most=1)
    if plan is None:
        raise UserError(
            "{path}: no header", path=path
        )  # not cached: the file may still be incomplete
    return plan.study.name, _plain(plan.study_text)


def _plain(text: str) -> str:
    return text.replace("\r\n", "\n")
