"""Check that each record of a journal has the content required for its kind.

A checksum detects random damage, but a record that another program wrote or edited can contain
anything. Unknown kinds and entries are accepted, because later versions of Slipscale may write
them.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import fields
from functools import cache, lru_cache
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError, model_validator

from slipscale.experiments.journal.reading import DAMAGED, Damage
from slipscale.experiments.journal.record import Record
from slipscale.experiments.journal.serialisation import surface_kind
from slipscale.experiments.steps.replies import Adjusted, Presented, Reply, Voided
from slipscale.experiments.steps.trial import Trial
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.validation import in_words
from slipscale.hardware.contact.source import QUANTITIES

# Maximum session time of a record, about thirty years.
LONGEST_S = 1e9
Number = Annotated[int, Field(ge=0)]
Text = dict[str, Any]


class _Shape(BaseModel):
    model_config = ConfigDict(strict=True, extra="ignore", defer_build=True)


class _Header(_Shape):
    study_name: str
    study_text: str
    participant: str
    session: str
    run: str
    seed: Number
    language: str
    mode: Literal["participant", "pilot"]
    order_version: int
    answered_by: str
    masking_noise: str
    study_hash: str
    texts_hash: str
    trial_levels: list[str]
    plate_spec: str
    plate: Text
    software: Text
    started_utc: str


class _Begin(_Shape):
    step: Number
    what: Text
    kept: Number = 0


class _Done(_Shape):
    step: Number
    answer: Text | None


class _Void(_Shape):
    task: str
    trial: int
    reason: str
    repeated: bool = True


class _Note(_Shape):
    text: str


class _Resume(_Shape):
    plate_spec: str
    plate: Text
    masking_noise: str
    texts_hash: str
    software: Text


class _AskAgain(_Shape):
    what: Text


class _AnsweredAgain(_AskAgain):
    answer: Text


class _Backup(_Shape):
    folder: str


class _Unfinished(_Shape):
    name: str
    trial: int | None
    entry: str
    rejected: list[str]


class _Markers(_Shape):
    outputs: list[str]
    lost: str = ""
    reason: str = ""


class _TakeUp(_Shape):
    virtual: bool = False


class _Contact(_Shape):
    source: Literal["position", "force"]
    trial: int | None
    during: Literal["exploration", "answer"]
    ends: Literal["", "whole", "broken off"]
    begun_s: float
    times_s: list[float]
    values: dict[str, list[float]]
    unreadable: int = 0
    changes_s: list[float] | None = None

    @model_validator(mode="after")
    def _as_long(self) -> Self:
        if tuple(self.values) != QUANTITIES[self.source]:
            raise ValueError(
                Message(
                    "expected the values of {quantities}",
                    quantities=", ".join(QUANTITIES[self.source]),
                )
            )
        if any(len(each) != len(self.times_s) for each in self.values.values()):
            raise ValueError("expected one value for each time")
        return self


class _Stroke(_Shape):
    task: str
    trial: int
    interval: int | None
    speed_mm_s: float | None
    normal_n: float | None
    forward_share: float | None
    outside: list[str]


class _Tracking(_Shape):
    trial: int
    before_hz: float
    frequency_hz: float
    points: list[tuple[float, float]]
    refused: str


class _Step(_Shape):
    type: str
    trial: Text | None


class _LeadIn(_Shape):
    surface: Text


class _InInterval(_Step):
    interval: Annotated[int, Field(ge=1)] | None


class _Present(_InInterval):
    surface: Text
    lead_in: tuple[_LeadIn, Any] | None


class _Ask(_Step):
    name: str
    task: str


class _Adjust(_InInterval):
    name: str
    again: tuple[_LeadIn, Any] | None


# Required data, keyed by kind of record.
RECORDS: dict[str, Any] = {
    "header": _Header,
    "begin": _Begin,
    "done": _Done,
    "void": _Void,
    "note": _Note,
    "resume": _Resume,
    "take_up": _TakeUp,
    "ask_again": _AskAgain,
    "answered_again": _AnsweredAgain,
    "unfinished": _Unfinished,
    "markers": _Markers,
    "backup": _Backup,
    "contact": _Contact,
    "stroke": _Stroke,
    "tracking": _Tracking,
}
# Required record of a step and type of its answer, keyed by type of step.
STEPS: dict[str, tuple[Any, type | None]] = {
    "Instruct": (_Step, Reply),
    "Rest": (_Step, Reply),
    "Explore": (_InInterval, Reply),
    "Ask": (_Ask, Reply),
    "Adjust": (_Adjust, Adjusted),
    "Feedback": (_Step, Reply),
    "Present": (_Present, Presented),
    "Silence": (_InInterval, None),
    "EndTrial": (_Step, Voided),
    "EndBlock": (_Step, Voided),
}


def checked(records: Sequence[Record]) -> tuple[list[Record], list[Damage]]:
    """Return the records of a run after replacing invalid ones, and a list of the damage.

    A record of kind `DAMAGED` replaces each invalid record. A record is invalid if its content does
    not fit its kind, or if it cannot follow the previous records.
    """
    kept: list[Record] = []
    damage: list[Damage] = []
    order = _Order()
    for record in records:
        reason = "" if record.kind == DAMAGED else _misshapen(record) or order.refuses(record)
        if record.kind == DAMAGED:
            order.sure = False
        if reason:
            order.sure = False
            damage.append(Damage(line=record.number + 1, reason=reason))
            data: dict[str, Any] = {}
            kept.append(Record(number=record.number, time_s=record.time_s, kind=DAMAGED, data=data))
        else:
            kept.append(record)
    return kept, damage


class _Order:
    """Checks that each step ends before the next begins; a step may begin repeatedly."""

    def __init__(self) -> None:
        self.sure = True  # whether there was no damage since the last step began
        self._first = True
        self._ended = False
        self._over = 0
        self._open: dict[str, Any] | None = None

    def refuses(self, record: Record) -> str:
        """Process the next record; return the reason why this record is out of order, or ""."""
        first, self._first = self._first, False
        if (record.kind == "header") != (first and record.number == 0):
            return "a run must have exactly one header, as its first record"
        if self._ended:
            return "the record comes after the end of the run"
        if record.kind == "begin":
            return self._begins(record)
        if record.kind == "done":
            return self._is_done(record)
        self._ended = record.kind == "end"
        return ""

    def _begins(self, record: Record) -> str:
        step = record.data["step"]
        if step != self._over and (self.sure or step < self._over):
            return f"step {step} begins where step {self._over} was expected"
        self._over, self._open, self.sure = step, record.data["what"], True
        return ""

    def _is_done(self, record: Record) -> str:
        step = record.data["step"]
        what, self._open = self._open, None
        if what is None or step != self._over or not self.sure:
            return f"step {step} is marked as done but never began"
        self._over += 1
        answer, expected = record.data["answer"], STEPS[what["type"]][1]
        given = None if answer is None else answer["type"]
        if given != (expected.__name__ if expected else None):
            return f"{given} is not a valid answer to {what['type']}"
        return ""


def _misshapen(record: Record) -> str:
    """Describe the error in a record, or return an empty string if the record is valid."""
    if not abs(record.time_s) <= LONGEST_S:
        return f"the record's time is {record.time_s:g} s; expected the time since the run began"
    shape = RECORDS.get(record.kind)
    try:
        if shape:
            _fit(shape, record.data)
        if record.kind in ("begin", "ask_again", "answered_again"):
            _check_step(record.data["what"])
        if record.kind in ("done", "answered_again") and record.data["answer"] is not None:
            _check_answer(record.data["answer"])
        if record.kind == "answered_again":
            _check_reply(record.data)
    except ValidationError as error:
        return f"{record.kind}: {in_words(error)}"
    except UserError as error:
        return f"{record.kind}: {error}"
    return ""


def _check_reply(data: dict[str, Any]) -> None:
    if (data["what"]["type"], data["answer"]["type"]) != ("Ask", "Reply"):
        raise UserError("expected the reply to a question")


def _check_step(what: dict[str, Any]) -> None:
    kind = what.get("type")
    if not isinstance(kind, str) or kind not in STEPS:
        _fit(_Step, what)
        raise UserError("unknown step {what}", what=repr(what["type"][:40]))
    _fit(STEPS[kind][0], what)
    if what["trial"] is not None:
        _fit(Trial, what["trial"])
    if what["type"] == "Present":
        _check_surface(what["surface"])
        for part in (what["lead_in"] or ())[:1]:
            _check_surface(part["surface"])
    if what["type"] == "Adjust" and what["again"] is not None:
        _check_surface(what["again"][0]["surface"])


def _check_surface(surface: dict[str, Any]) -> None:
    _fit(surface_kind(surface), surface)


def _check_answer(answer: dict[str, Any]) -> None:
    kinds = {kind.__name__: kind for kind in (Reply, Adjusted, Presented, Voided)}
    kind = answer.get("type")
    if not isinstance(kind, str) or kind not in kinds:
        raise UserError("unknown type of answer")
    _fit(kinds[kind], {name: v for name, v in answer.items() if name != "type"})


def _fit(shape: Any, data: dict[str, Any]) -> None:
    """Raise an error unless data match a model or a dataclass, which permits no other entries."""
    # Strict validation of JSON accepts lists for tuples.
    _fit_json(shape, json.dumps(data))


@lru_cache(maxsize=4096)  # Records repeat surfaces, and runs are read repeatedly.
def _fit_json(shape: Any, text: str) -> None:
    if not issubclass(shape, _Shape):
        data = json.loads(text)
        if other := set(data) - {f.name for f in fields(shape)}:
            raise UserError(
                "{name} has no {entry}", name=shape.__name__, entry=repr(min(other)[:40])
            )
    _adapter(shape).validate_json(text, strict=True)


@cache
def _adapter(shape: Any) -> TypeAdapter[Any]:
    return TypeAdapter(shape)
