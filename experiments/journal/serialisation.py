"""Steps and answers as the journal's plain data, and back.

What is read may have the names of a journal in µm (`slipscale.stimuli.quantity.in_um`) or the
code's; what is made has the code's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from slipscale.experiments.protocols.steps import Adjusted, Answer, Presented, Reply, Trial, Voided
from slipscale.stimuli.quantity import in_code, in_um, renamed
from slipscale.stimuli.surface import VirtualSurface
from slipscale.stimuli.texture import Grating

if TYPE_CHECKING:
    from collections.abc import Callable

    from slipscale.experiments.protocols.steps import Step
    from slipscale.stimuli.surface import Surface

ANSWERS: dict[str, Callable[..., Answer]] = {
    "Reply": Reply,
    "Adjusted": Adjusted,
    "Presented": Presented,
    "Voided": Voided,
}
_WHOLE = frozenset({str, int, float, bool, type(None)})
# Texts may be corrected between versions; a run can still be resumed.
WORDS = ("text", "title", "question")
# What the header of a journal states whose levels are not in µm: its records have our own names.
QUANTITY = "quantity"


def step_record(step: Step) -> dict[str, Any]:
    """Return a step as plain data, with its type, as it reads back from a journal.

    A step outside intervals does not name one, a question without a sound, whose answer the
    participant enters, does not say so, nor does an `Adjust` what cannot be felt again: their
    records are those of the versions without these, whose journals are gone on with.
    """
    record: dict[str, Any] = _plain(step)
    for part in (record, *(record.get("lead_in") or ())):
        if part.get("interval", 0) is None:
            del part["interval"]
    if record.get("by") == "participant":
        del record["by"]
    if record.get("played", 0) is None:
        del record["played"]
    if record.get("again", 0) is None:
        del record["again"]
    return {"type": type(step).__name__, **record}


def _plain(value: Any) -> Any:
    """Return a value as JSON reads it back: a class as its fields, a tuple as a list."""
    # `asdict` copies every number and text too: half of the time of a simulated run.
    kind = type(value)
    if kind in _WHOLE:
        return value
    if names := _names(kind):  # type: ignore[arg-type]  # mypy: no class is hashable
        return {name: _plain(getattr(value, name)) for name in names}
    if isinstance(value, Mapping):
        return {key: _plain(each) for key, each in value.items()}
    return [_plain(each) for each in value] if isinstance(value, tuple | list) else value


@cache
def _names(kind: type) -> tuple[str, ...]:
    """Return the names of a dataclass's fields; none of another type."""
    return tuple(each.name for each in fields(kind)) if is_dataclass(kind) else ()


def same_step(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Return whether two step records are one step, but for its words."""
    return bool(_without_words(in_own_names(one)) == _without_words(in_own_names(other)))


def in_own_names(record: dict[str, Any]) -> dict[str, Any]:
    """Return a step's or answer's record with the names that the code has."""
    found: dict[str, Any] = renamed(record, in_code)
    if found.get("type") == "Adjust":
        found["name"] = in_code(found["name"])  # it is a column of the data set
    return found


def _without_words(record: Any) -> Any:
    if isinstance(record, dict):
        return {k: _without_words(v) for k, v in record.items() if k not in WORDS}
    if isinstance(record, list):
        return [_without_words(value) for value in record]
    return record


def answer_record(answer: Answer) -> dict[str, Any] | None:
    """Return an answer as plain data, with its type; None stays None."""
    return None if answer is None else {"type": type(answer).__name__, **_plain(answer)}


def in_um_names(data: dict[str, Any]) -> dict[str, Any]:
    """Return a record's data with the names of a journal in µm; the inverse of `in_own_names`."""
    found: dict[str, Any] = renamed(data, in_um)
    for step in (found, *(each for each in found.values() if isinstance(each, dict))):
        if step.get("type") == "Adjust":
            step["name"] = in_um(step["name"])
    return found


def answer_from(record: dict[str, Any] | None) -> Answer:
    """Return the answer that a record holds."""
    if record is None:
        return None
    fields = {key: _tuples(value) for key, value in in_own_names(record).items()}
    return ANSWERS[str(fields.pop("type"))](**fields)


def _tuples(value: Any) -> Any:
    return tuple(_tuples(each) for each in value) if isinstance(value, list) else value


def surface_from(record: dict[str, Any]) -> Surface:
    """Return the surface that a record holds: a texture is known by its period."""
    fields = in_own_names(record)
    return Grating(**fields) if "spatial_period_mm" in fields else VirtualSurface(**fields)


def trial_from(record: dict[str, Any]) -> Trial:
    """Return the trial that a record holds."""
    return Trial(**in_own_names(record))
