"""Define the columns of data set tables and the keys of sidecars, with types and units.

The columns are used for writing (`slipscale.experiments.dataset.bids`), for reading
(`slipscale.analysis.reading`) and for generating docs/reference/data-set.md. A protocol declares
only the columns specific to its task (see `slipscale.experiments.protocol_parts.base.Protocol`).
The function `columns` adds the columns that all tasks have in common.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

from slipscale.experiments.dataset.measured import MEASURED, SECOND_READBACK, measured_columns
from slipscale.experiments.protocol_parts.base import Protocol
from slipscale.experiments.steps.columns import Column, IntervalRecord, TrialRecord
from slipscale.experiments.study.person_questions import TAKEN
from slipscale.experiments.study.questionnaires import ROW
from slipscale.experiments.study.run_plan import stem
from slipscale.faults import UserError
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity
from slipscale.stimuli.surface import Stimulus

MISSING = "n/a"
# The columns of participants.tsv that Slipscale fills in. The first column identifies the
# participant, as in every table of the analysis.
PARTICIPANT, MODE, COMPLETE = TAKEN
# The column of a participant's sessions.tsv that identifies the session; a questionnaire's table
# also has a column for the run.
SESSION, RUN = ROW
PRACTICE, MAIN = "practice", "main"
PHASES = {PRACTICE: "practice, not to be analysed", MAIN: "the experiment"}
VOIDED, TIMED_OUT, FAULT, PAUSED = "voided", "timed_out", "fault", "paused"
REPRESENTED, RESUMED, DAMAGED = "represented", "resumed", "damaged"
SENSOR = "sensor"
UNCHANGED = "unchanged"
FLAGS: Mapping[str, str] = {
    VOIDED: "voided by the operator; not to be analysed",
    TIMED_OUT: "the time limit expired before an answer was given",
    FAULT: "the apparatus failed during this trial; the surface was presented again",
    PAUSED: "the operator paused the session during this trial",
    REPRESENTED: "the surface was presented and explored again before the answer",
    RESUMED: "the run was interrupted during this trial and resumed",
    SENSOR: "the measurements cannot come from a finger (a wrong column, unit or connection), or "
    "more than a tenth of the readings were unreadable",
    UNCHANGED: "the finger did not trigger the transient while it explored the surface",
    DAMAGED: "a journal record of this trial, or an adjacent one, is damaged; not to be analysed",
}
# Part of a column name that identifies plate readbacks.
READBACK = "readback"
NO_READBACK = "; n/a if the plate reports only the commanded value"
# Prefix of interval columns; the interval number follows.
INTERVAL = "interval"
# Separator between the flags of a trial.
FLAG_SEPARATOR = ";"
# Key of the object with Slipscale's own entries in a run's sidecar.
SIDECAR = "Slipscale"
NOTES: Mapping[str, str] = {
    "study": "name of the study",
    "protocol": "name of the protocol, if the study gives the task its own label",
    "study_hash": "SHA-256 of the study file's text",
    "seed": "random seed for all orders",
    "mode": "participant, or pilot (a test of the study, which yields no data)",
    "language": (
        "language of the text shown to the participant; for languages that the study itself "
        "provides, see `code/`"
    ),
    "texts_hash": "SHA-256 of all text that the participant could read",
    "complete": "whether the run was completed",
    "answered_by": "who answered: person, simulated or scripted; the plate is a separate entry",
    "masking_noise": "on, or absent",
    "headphone_test": "result of the headphone test: passed, failed, not done (with the reason) "
    "or broken off (not completed); also the number of correct tones, the ear in which each noise "
    "was heard, and the operator's decision; omitted if the study has no such test",
    "quantity": "quantity of the levels: name, unit, convention, and the judged attribute; "
    "omitted for the vibration amplitude in µm peak to peak",
    "plate_quantity": "quantity that the plate produces, as in `quantity`; omitted unless the "
    "study varies another parameter of the stimuli",
    "plate_spec": "the plate as specified on the command line",
    "plate": "the plate's own description, including its calibration",
    "contact": "finger position and force sensors, and how textures were produced; n/a if there "
    "were none",
    "software": "versions of all software that could affect the data",
    "started_utc": "start time of the run; n/a for a pilot",
    "resumes": "each time the run was resumed: when, plate, noise, software; n/a for a pilot",
    "voided": "each voided trial and the operator's reason",
    "notes": "the operator's notes during the run, with times; omitted if there are none",
    "damaged": "journal lines that could not be used",
    "journal": "number of records in the journal, and their running hash; n/a for a pilot",
}
# Columns of a run's `_events.tsv` that its table does not have: BIDS stores times there.
EVENTS: Mapping[str, Column] = {
    "onset": Column(
        value=lambda record: record.onset_s,
        description="Time at which the plate had settled, from the beginning of the session",
        units="s",
    ),
    "duration": Column(
        value=lambda record: record.end_s - record.onset_s,
        description="Time from the onset (when the plate had settled) to the end of the trial",
        units="s",
    ),
    "trial_type": Column(
        value=lambda record: record.trial.phase,
        kind="label",
        description="Part of the run",
        levels=PHASES,
    ),
}
TABLE_NAME = re.compile(
    r"sub-(?P<sub>[A-Za-z0-9]+)(_ses-(?P<ses>[A-Za-z0-9]+))?_task-(?P<task>[A-Za-z0-9]+)"
    r"(_run-(?P<run>[0-9]+))?_beh\.tsv"
)


def table_stem(*, participant: str, session: str, task: str, run: str) -> str:
    """Return the common file name of a run's table and sidecar, without the suffix."""
    return f"{stem(participant, session)}_task-{task}_run-{run}_beh"


def columns(
    protocol: Protocol,
    measured: Iterable[str] = (),
    quantity: Quantity = PLATE_AMPLITUDE,
    plate: Quantity | None = None,
    second: Quantity | None = None,
) -> dict[str, Column]:
    """Return all columns of a protocol's table in order, keyed by their names in the file.

    Parameters
    ----------
    protocol : Protocol
    measured : iterable of str
        Keys of `MEASURED` for the quantities that were measured in the run. Each has a column.
    quantity : Quantity
        Quantity in which levels are expressed. This quantity determines the names, units and
        descriptions of the columns.
    plate : Quantity, optional
        Quantity that the plate produces and reads back, if it differs from ``quantity``.
    second : Quantity, optional
        Quantity of a second actuator.

    Raises
    ------
    UserError
        If the protocol declares a column that the tables of all tasks already contain.
    """
    common = _common(protocol, quantity)
    own = {**protocol.design, **protocol.stimulus, **protocol.response}
    if duplicates := sorted(set(own) & {*common, *MEASURED, *EVENTS}):
        raise UserError(
            "{protocol}: column {columns} is in every task's table; expected another name",
            protocol=protocol.named,
            columns=", ".join(duplicates),
        )
    if protocol.interval_columns:
        presented = [name for name in common if name.startswith(INTERVAL)]
        order = [
            *("trial", *protocol.design, "phase", *protocol.stimulus, *presented),
            *(*protocol.response, "response_time"),
        ]
    else:
        order = [
            *("trial", *protocol.design, "phase", "surface", *protocol.stimulus),
            *("level", "level_readback", *protocol.response),
            *("response_time", "exploration_time"),
        ]
    extra = measured_columns(measured)
    order += [*extra, "response_time_source", "rejected_entries", "repeats", "flag"]
    everything = {**common, **own, **extra}
    found = {}
    for name in order:
        of = (plate or quantity) if READBACK in name else quantity
        column = everything[name]
        if second and name.endswith(SECOND_READBACK):
            found[second.named(f"{name}_level")] = _in(column, second)
            continue
        found[name if column.as_stated else of.named(name)] = _in(column, of)
    return found


def _in(column: Column, quantity: Quantity) -> Column:
    """Return a column after filling in the placeholders for the quantity."""
    return replace(
        column,
        description=filled(column.description, quantity),
        units=filled(column.units, quantity),
        levels={label: filled(meaning, quantity) for label, meaning in column.levels.items()},
    )


def filled(text: str, quantity: Quantity = PLATE_AMPLITUDE) -> str:
    """Replace the placeholders in a text with the names and units of a quantity."""
    return text.format(q=quantity) if "{q." in text else text


def _interval_columns(number: int) -> dict[str, Column]:
    """Return the columns for one interval of a trial."""

    def of(record: TrialRecord) -> IntervalRecord | None:
        return record.intervals.get(number)

    def surface(record: TrialRecord) -> Stimulus | None:
        interval = of(record)
        return interval.surface if interval else None

    def field(name: str) -> Callable[[TrialRecord], Any]:
        return lambda record: getattr(of(record), name, None)

    which = f"of interval {number}"
    return {
        f"{INTERVAL}{number}_surface": Column(
            value=lambda record: getattr(surface(record), "label", None),
            kind="label",
            description=f"Code of the surface {which}",
        ),
        f"{INTERVAL}{number}_level": Column(
            value=lambda record: getattr(surface(record), "level", None),
            description=f"{{q.in_full_title}} commanded {which}{{q.behind}}",
            units="{q.bids}",
        ),
        f"{INTERVAL}{number}_readback_level": Column(
            value=field("readback_level"),
            description=f"{{q.in_full_title}} read back {which} once settled{{q.behind}}"
            + NO_READBACK,
            units="{q.bids}",
        ),
        f"{INTERVAL}{number}_onset": Column(
            value=field("onset_s"),
            description=(
                f"Time at which the surface {which} had settled, from the beginning of the session"
            ),
            units="s",
        ),
        f"{INTERVAL}{number}_exploration_time": Column(
            value=field("exploration_time_s"),
            description=f"Duration for which the surface {which} was stroked",
            units="s",
        ),
    }


def _common(protocol: Protocol, quantity: Quantity) -> dict[str, Column]:
    """Return the columns that are contained in the tables of all tasks."""
    modulated = ("; for a texture, the largest", "; for a texture, its mean")
    largest, mean = modulated if protocol.textures else ("", "")

    def answered(record: TrialRecord, field: str) -> Any:
        return record.answers.get(protocol.answer, {}).get(field)

    intervals = {
        name: column
        for number in range(1, protocol.interval_columns + 1)
        for name, column in _interval_columns(number).items()
    }
    return intervals | {
        "trial": Column(
            value=lambda record: record.trial.number,
            description="Trial number in order of presentation, from 1",
        ),
        "phase": Column(
            value=lambda record: record.trial.phase,
            kind="label",
            description="Part of the run",
            levels=PHASES,
        ),
        "surface": Column(
            value=lambda record: record.surface.label if record.surface else None,
            kind="label",
            description="Code of the virtual surface, S1, S2, ... in the order of the study file"
            + ("; T1, T2, ... for textures" if protocol.textures else ""),
        ),
        "level": Column(
            value=lambda record: record.surface.level if record.surface else None,
            description="{q.in_full_title} commanded{q.behind}" + largest,
            units="{q.bids}",
        ),
        "level_readback": Column(
            value=lambda record: record.readback_level,
            description="{q.in_full_title} read back from the plate once settled{q.behind}"
            + mean
            + NO_READBACK,
            units="{q.bids}",
        ),
        "response_time": Column(
            value=lambda record: answered(record, "response_time_s"),
            description="Time from the question to the key press that completed "
            f"the answer in column '{quantity.named(protocol.answer)}'",
            units="s",
        ),
        "exploration_time": Column(
            value=lambda record: record.exploration_time_s,
            description="Duration for which the surface was stroked before the question",
            units="s",
        ),
        "response_time_source": Column(
            value=lambda record: answered(record, "time_source"),
            kind="label",
            description="Source of the response time",
            levels={
                "ptb": "the key event's own time stamp",
                "window": "the time at which the window was notified of the key press",
                "operator": "the time at which the operator submitted the participant's spoken "
                "answer: the response time includes the time taken to listen and type",
                "simulated": "generated by a simulated participant",
                "scripted": "set by a script",
            },
        ),
        "rejected_entries": Column(
            value=lambda record: "; ".join(answered(record, "rejected") or ()) or None,
            kind="text",
            description=(
                "Rejected entries, separated by '; '; the question was asked again after each entry"
            ),
        ),
        "repeats": Column(
            value=lambda record: record.trial.repeats,
            description="Number of the voided or timed-out trial that this trial repeats",
        ),
        "flag": Column(
            value=lambda record: FLAG_SEPARATOR.join(record.flags) or None,
            kind="label",
            description=f"Events in the trial, separated by '{FLAG_SEPARATOR}': "
            + ", ".join(f"{flag} ({meaning})" for flag, meaning in FLAGS.items()),
        ),
    }
