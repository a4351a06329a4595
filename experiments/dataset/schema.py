"""The columns of a task's table: what each holds and what it means."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING, Any

from experiments.protocols.base import Column

if TYPE_CHECKING:
    from experiments.protocols.base import Protocol, TrialRecord
    from experiments.protocols.steps import Value

MISSING = "n/a"
# The column that says whose row it is, in participants.tsv and in every table of the analysis.
PARTICIPANT = "participant_id"
# Times are kept to the microsecond: the key events' own clocks are not better.
DIGITS = 6

FLAGS = {
    "voided": "voided by the operator; not to be analysed",
    "timed_out": "the time limit ran out before an answer",
    "fault": "the rig failed in this trial; the surface was presented again",
    "paused": "the operator paused in this trial",
    "represented": "the surface was presented and explored again before the answer",
    "resumed": "the run was interrupted in this trial and taken up again",
}


def _main_answer(record: TrialRecord, protocol: Protocol, field: str) -> Any:
    return record.answers.get(protocol.answer, {}).get(field)


def columns(protocol: Protocol) -> dict[str, Column]:
    """Return all columns of a protocol's table, in order."""
    own = protocol.columns
    before = [name for name in own if name in ("block", "series", "step")]
    after = [name for name in own if name not in before]
    amplitude_first = [name for name in after if name.startswith("amplitude")]
    texture = [name for name in after if name == "texture"]
    answers = [name for name in after if name not in (*amplitude_first, *texture)]
    modulated = ("; of a texture the largest", "; of a texture its mean") if texture else ("", "")
    common = {
        "trial": Column(
            value=lambda record: record.trial.number,
            description="Number of the trial in order of presentation, from 1",
        ),
        "phase": Column(
            value=lambda record: record.trial.phase,
            description="Part of the run",
            levels={"practice": "practice, not to be analysed", "main": "the experiment"},
        ),
        "surface": Column(
            value=lambda record: record.surface.label if record.surface else None,
            description="Code of the virtual surface, S1, S2, ... in the order of the study file"
            + ("; T1, T2, ... for textures" if texture else ""),
        ),
        "amplitude_um_pp": Column(
            value=lambda record: record.surface.amplitude_um_pp if record.surface else None,
            description=f"Vibration amplitude commanded, peak to peak{modulated[0]}",
            units="um",
        ),
        "amplitude_readback_um_pp": Column(
            value=lambda record: record.readback_um_pp,
            description="Vibration amplitude read back from the plate once settled, peak to peak"
            + modulated[1],
            units="um",
        ),
        "response_time": Column(
            value=lambda record: _main_answer(record, protocol, "response_time_s"),
            description=f"From the question to the key that completed '{protocol.answer}'",
            units="s",
        ),
        "onset": Column(
            value=lambda record: record.onset_s,
            description="When the surface had settled, from the beginning of the session",
            units="s",
        ),
        "duration": Column(
            value=lambda record: record.end_s - record.onset_s,
            description="From the settled surface to the end of the trial",
            units="s",
        ),
        "exploration_time": Column(
            value=lambda record: record.exploration_time_s,
            description="How long the surface was stroked before the question",
            units="s",
        ),
        "response_time_source": Column(
            value=lambda record: _main_answer(record, protocol, "time_source"),
            description="Where the response time was taken",
            levels={
                "ptb": "the key event's own time stamp",
                "window": "when the window was told of the key",
                "simulated": "drawn by a simulated participant",
                "scripted": "set by a script",
            },
        ),
        "rejected_entries": Column(
            value=lambda record: (
                "; ".join(_main_answer(record, protocol, "rejected") or ()) or None
            ),
            description="Entries that were no answer and were asked again, separated by '; '",
        ),
        "repeats": Column(
            value=lambda record: record.trial.repeats,
            description="Number of the voided or timed-out trial that this one repeats",
        ),
        "flag": Column(
            value=lambda record: ";".join(record.flags) or None,
            description="What happened in the trial, separated by ';': "
            + ", ".join(f"{flag} ({meaning})" for flag, meaning in FLAGS.items()),
        ),
    }
    order = [
        *("trial", *before, "phase", "surface", *texture, *amplitude_first),
        *("amplitude_um_pp", "amplitude_readback_um_pp", *answers),
        *("response_time", "onset", "duration", "exploration_time"),
        *("response_time_source", "rejected_entries", "repeats", "flag"),
    ]
    everything = {**common, **own}
    return {name: everything[name] for name in order}


def cell(value: Value) -> str:
    r"""Return a value as it stands in a table.

    >>> cell(None), cell(2.0), cell(12.345678901), cell("a\tb")
    ('n/a', '2', '12.345679', 'a b')
    """
    if value is None:
        return MISSING
    if isinstance(value, float):
        return f"{round(value, DIGITS):.{DIGITS}f}".rstrip("0").rstrip(".")
    return " ".join(str(value).split()) or MISSING


def table(header: list[str], rows: list[list[str]]) -> str:
    """Return a TSV with proper quoting: a report with quotes in it stays in its cell."""
    text = io.StringIO()
    writer = csv.writer(text, delimiter="\t", lineterminator="\n")
    writer.writerows([header, *rows])
    return text.getvalue()


def sidecar(described: dict[str, Column]) -> dict[str, Any]:
    """Return column descriptions as BIDS has them."""
    return {
        name: {"Description": column.description}
        | ({"Units": column.units} if column.units else {})
        | ({"Levels": dict(column.levels)} if column.levels else {})
        for name, column in described.items()
    }
