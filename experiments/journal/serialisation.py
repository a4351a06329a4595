"""Convert steps and answers to plain data for the journal, and back.

Data contain the names used in the code. `dialect` converts them to the names in journals, which
contain the quantity and its unit, and back.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache, partial
from typing import Any

from slipscale.experiments.steps import replies, steps, trial
from slipscale.experiments.steps.replies import Adjusted, Answer, Presented, Reply, Voided
from slipscale.experiments.steps.steps import Step
from slipscale.experiments.steps.trial import Trial
from slipscale.hardware.contact.source import QUANTITIES
from slipscale.stimuli import modulation, textures
from slipscale.stimuli.level_names import Names, is_level
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity
from slipscale.stimuli.quantity_table import QuantityTable
from slipscale.stimuli.surface import Stimulus, VirtualSurface
from slipscale.stimuli.textures import Texture, kind_in
from slipscale.stimuli.varied import Varied

ANSWERS: dict[str, Callable[..., Answer]] = {
    "Reply": Reply,
    "Adjusted": Adjusted,
    "Presented": Presented,
    "Voided": Voided,
}
_WHOLE = frozenset({str, int, float, bool, type(None)})
# Texts may be corrected between versions, and a run can still be resumed.
WORDS = ("text", "title", "question")
# Header entries: the quantity of the levels unless it is amplitude in µm, and the quantity that the
# plate produces if the levels are another parameter of the stimuli.
QUANTITY, PLATE_QUANTITY = "quantity", "plate_quantity"
# Entries whose levels are in the quantity that the plate produces.
OF_PLATE = frozenset({"plate", "surface", "texture"})


def step_record(step: Step) -> dict[str, Any]:
    """Return a step's type and fields as plain data, exactly as they are read from a journal.

    A field that did not exist in earlier versions is omitted if it has its default value, so that
    journals from earlier versions can be resumed.
    """
    record: dict[str, Any] = _plain(step)
    for part in (record, *(record.get("lead_in") or ())):
        if part.get("interval", 0) is None:
            del part["interval"]
    if record.get("by") == "participant":
        del record["by"]
    if record.get("played", 0) is None:
        del record["played"]
    if record.get("back") is False:
        del record["back"]
    if record.get("again", 0) is None:
        del record["again"]
    return {"type": type(step).__name__, **record}


def _plain(value: Any) -> Any:
    """Convert a value to JSON types: a dataclass to a dict of its fields, and a tuple to a list."""
    # `asdict` also copies every number and string, which would take half of the time of a simulated
    # run.
    kind = type(value)
    if kind in _WHOLE:
        return value
    if names := _names(kind):  # type: ignore[arg-type]  # mypy: no class is hashable
        return {name: _plain(getattr(value, name)) for name in names if _told(value, name)}
    if isinstance(value, Mapping):
        return {key: _plain(each) for key, each in value.items()}
    return [_plain(each) for each in value] if isinstance(value, tuple | list) else value


def _told(value: Any, name: str) -> bool:
    """Return whether to record a field; a field in ``LATER`` is omitted if it has its default."""
    later = name in getattr(value, "LATER", ())
    return not later or getattr(value, name) != _defaults(type(value))[name]  # type: ignore[arg-type]


@cache
def _defaults(kind: type) -> dict[str, Any]:
    return {each.name: each.default for each in fields(kind)}


@cache
def _names(kind: type) -> tuple[str, ...]:
    """Return the field names of a dataclass, or an empty tuple for other types."""
    return tuple(each.name for each in fields(kind)) if is_dataclass(kind) else ()


def dialect(header: Mapping[str, Any], names: Callable[[Quantity], Names]) -> Callable[[Any], Any]:
    """Return the function that renames the keys of a journal's records.

    Parameters
    ----------
    header : Mapping
        Data of the journal's first record, which state the quantity of the levels and, if they are
        a parameter of the stimuli, the quantity that the plate produces.
    names : callable
        Returns the names of a quantity, `Quantity.in_file` or `Quantity.in_code`.
    """
    levels = _stated(header.get(QUANTITY), PLATE_AMPLITUDE)
    plate = _stated(header.get(PLATE_QUANTITY), levels)
    return partial(_renamed, levels=_of_levels(names(levels)), plate=_of_levels(names(plate)))


def _of_levels(names: Names) -> Names:
    """Return names, except those of times and places, which levels in s or mm resemble."""
    return Names(lambda name: name if name in _no_levels() else names[name])


@cache
def _no_levels() -> frozenset[str]:
    """Return all names of fields in records that are not levels, and have a unit."""
    kinds = (
        each
        for module in (modulation, replies, steps, textures, trial)
        for each in vars(module).values()
        if is_dataclass(each)
    )
    names = {each.name for kind in kinds for each in fields(kind)}
    names |= {"begun_s", "times_s"}.union(*QUANTITIES.values())
    return frozenset(name for name in names if not is_level(name))


def _stated(table: object, default: Quantity) -> Quantity:
    try:
        return QuantityTable.model_validate(table).quantity if table else default
    except ValueError:  # the header is damaged
        return default


def _renamed(data: Any, levels: Names, plate: Names) -> Any:
    """Rename keys; those in `OF_PLATE` and in a `Presented` refer to the plate's quantity."""
    if isinstance(data, dict):
        kind = data.get("type")
        names = plate if kind == Presented.__name__ else levels
        found = {
            names[key]: value
            if key == "question"  # the fields of any kind of question; none of them is a level
            else _renamed(value, plate if key in OF_PLATE else names, plate)
            for key, value in data.items()
        }
        if kind == "Adjust" and isinstance(found.get("name"), str):
            found["name"] = names[found["name"]]  # the name refers to a data set column
        return found
    if isinstance(data, list | tuple) and data and not isinstance(data[0], float | int | str):
        return [_renamed(each, levels, plate) for each in data]
    return data


def same_step(
    one: dict[str, Any], other: dict[str, Any], in_file: Callable[[Any], Any] = dict
) -> bool:
    """Return whether two records describe the same step, ignoring displayed text.

    A trial's factors may have the names in the study file or in the code; ``in_file`` gives both
    the same name.
    """
    return bool(_without_words(in_file(one)) == _without_words(in_file(other)))


def _without_words(record: Any) -> Any:
    if isinstance(record, dict):
        return {k: _without_words(v) for k, v in record.items() if k not in WORDS}
    if isinstance(record, list):
        return [_without_words(value) for value in record]
    return record


def answer_record(answer: Answer) -> dict[str, Any] | None:
    """Return the type and fields of an answer as plain data, or None if there is no answer."""
    return None if answer is None else {"type": type(answer).__name__, **_plain(answer)}


def answer_from(record: dict[str, Any] | None) -> Answer:
    """Return the answer that a record contains."""
    if record is None:
        return None
    fields = {key: _tuples(value) for key, value in record.items()}
    return ANSWERS[str(fields.pop("type"))](**fields)


def _tuples(value: Any) -> Any:
    return tuple(_tuples(each) for each in value) if isinstance(value, list) else value


def surface_from(record: dict[str, Any]) -> Stimulus:
    """Return the surface that a record describes."""
    fields = record
    if surface_kind(fields) is Varied:
        return Varied(vary=fields["vary"], texture=texture_from(fields["texture"]))
    return texture_from(fields) if kind_in(fields) else VirtualSurface(**fields)


def texture_from(fields: Mapping[str, Any]) -> Texture:
    """Return the texture that a record's fields describe; raise `KeyError` if there is none."""
    kind = kind_in(fields)
    if kind is None:
        raise KeyError("texture")
    return kind(**fields)


def surface_kind(fields: Mapping[str, Any]) -> type[Varied | Texture | VirtualSurface]:
    """Return the type of surface that a record describes."""
    return Varied if "vary" in fields else kind_in(fields) or VirtualSurface


def trial_from(record: dict[str, Any]) -> Trial:
    """Return the trial that a record describes."""
    return Trial(**record)
