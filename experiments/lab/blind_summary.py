"""Summarise a run's progress and events from its journal without unblinding the operator."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from slipscale.experiments.dataset.rows_from_journal import gather
from slipscale.experiments.journal.plan_and_progress import elapsed_s, read_usable
from slipscale.experiments.journal.record import Record
from slipscale.experiments.steps.columns import TrialRecord
from slipscale.experiments.steps.questions.base import CONSENT
from slipscale.faults import UserError
from slipscale.hardware.errors import visible_message


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """An event during a run: a fault, a pause, a voided trial, a note or a stop.

    The ``words`` of a fault are its code, and ``detail`` is its message, which is empty if the
    message may contain an amplitude.
    """

    time_s: float
    kind: str
    words: str
    detail: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateReading:
    """Plate readings during one presentation.

    Parameters
    ----------
    used_tolerance : float or None
        Deviation of the measured from the commanded amplitude, as a fraction of the deviation
        allowed by the plate's limits. None if the amplitude was not measured.
    temperature_c : float or None
        The plate's temperature. None if the plate does not report a temperature.
    """

    time_s: float
    used_tolerance: float | None
    temperature_c: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSummary:
    """The current state of a run.

    Parameters
    ----------
    trials : int
        Number of finished trials, including practice and voided trials.
    flags : Mapping
        Number of trials with each flag.
    response_times_s : tuple of float
        Response times of all tasks, in trial order.
    duration_s : float
        Time from the beginning of the run to the last step.
    readings : tuple of PlateReading
        The plate's readings, one per presentation.
    doing : str
        The most recently started step: its type, followed by a colon and the question's name, if
        any.
    consent : {"", "yes", "no"}
        The participant's last answer; empty if the participant was not asked.
    """

    trials: int = 0
    flags: Mapping[str, int] = field(default_factory=dict)
    response_times_s: tuple[float, ...] = ()
    duration_s: float = 0.0
    readings: tuple[PlateReading, ...] = ()
    events: tuple[Event, ...] = ()
    doing: str = ""
    consent: str = ""


# Entry that describes the event, keyed by the kind of record.
EVENTS = {"fault": "code", "void": "reason", "note": "text", "pause": "", "stop": "reason"}


def summary(path: Path) -> RunSummary:
    """Return the summary of a run's journal; an empty summary if the journal cannot be read."""
    try:
        stat = path.stat()
        return _summary(path, stat.st_ino, stat.st_mtime_ns, stat.st_size)
    except (OSError, UserError):
        return RunSummary()


@lru_cache(maxsize=4096)
def _summary(path: Path, _inode: int, _changed_ns: int, _size: int) -> RunSummary:
    _, reading = read_usable(path)
    records = reading.records
    trials = [trial for task in gather(records).trials.values() for trial in task]
    begun = [record for record in records if record.kind == "begin"]
    return RunSummary(
        trials=len(trials),
        flags=Counter(flag for trial in trials for flag in trial.flags),
        response_times_s=tuple(time for trial in trials for time in _response_times(trial)),
        duration_s=elapsed_s(records),
        readings=tuple(_readings(records)),
        events=tuple(
            Event(
                time_s=record.time_s,
                kind=record.kind,
                words=_words(record),
                detail=visible_message(record.data) if record.kind == "fault" else "",
            )
            for record in records
            if record.kind in EVENTS
        ),
        doing=_step(begun[-1]) if begun else "",
        consent=_consent(records),
    )


def _consent(records: list[Record]) -> str:
    """Return the last answer to the consent question, which includes any correction."""
    question, given = "", ""
    for record in records:
        if record.kind in ("begin", "answered_again"):
            question = str(record.data["what"].get("name", ""))
        if question == CONSENT and (answer := record.data.get("answer")):
            given = str(answer.get("value", given))
    return given


def _response_times(trial: TrialRecord) -> list[float]:
    found = [answer.get("response_time_s") for answer in trial.answers.values()]
    return [float(time) for time in found if time is not None][:1]


def _readings(records: list[Record]) -> list[PlateReading]:
    plates = [r.data["plate"] for r in records if r.kind in ("header", "resume")]
    limits = plates[-1].get("limits") or {} if plates else {}
    answers = [(r.time_s, r.data["answer"] or {}) for r in records if r.kind == "done"]
    return [
        PlateReading(
            time_s=time_s,
            used_tolerance=_used_tolerance(answer, limits),
            temperature_c=answer.get("temperature_c"),
        )
        for time_s, answer in answers
        if answer.get("type") == "Presented"
    ]


def _used_tolerance(answer: Mapping[str, Any], limits: Mapping[str, Any]) -> float | None:
    share, least = limits.get("tolerance"), limits.get("deviation_level")
    measured = answer["readback_level"] if answer["readback_kind"] == "measured" else None
    if measured is None or not isinstance(share, float) or not isinstance(least, float):
        return None
    commanded: float = answer["commanded_level"]
    return float(abs(measured - commanded) / max(share * commanded, least))


def _words(record: Record) -> str:
    entry = EVENTS[record.kind]
    return str(record.data.get(entry, "")) if entry else ""


def _step(record: Record) -> str:
    what = record.data["what"]
    return f"{what['type']}:{what.get('name', '')}"
