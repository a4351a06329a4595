"""Convert steps and answers to plain data for the journal, and back.

Data contain the names used in the code. `in_file` converts the names of levels to those in
journals, which contain the quantity and its unit, and `in_code` converts them back. Both convert
only declared names: the fields of `STEPS` and `OF_PLATE_KINDS`, and the names in the header.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache, partial
from types import MappingProxyType
from typing import Any, NamedTuple

from slipscale.experiments.steps.replies import Adjusted, Answer, Presented, Reply, Voided
from slipscale.experiments.steps.steps import Adjust, Step
from slipscale.experiments.steps.trial import Trial
from slipscale.hardware.limits import PlateLimits
from slipscale.stimuli.level_names import is_level
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity
from slipscale.stimuli.quantity_table import QuantityTable
from slipscale.stimuli.surface import Stimulus, VirtualSurface
from slipscale.stimuli.textures import KINDS, Texture, kind_in
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
# Header entry: the names of levels in trials, `RunPlan.trial_levels`.
TRIAL_LEVELS = "trial_levels"
# Entries whose levels are in the quantity that the plate produces, and what they can contain.
OF_PLATE = frozenset({"plate", "surface", "texture"})
OF_PLATE_KINDS = (Presented, VirtualSurface, PlateLimits, *KINDS.values())
# Steps and answers whose levels are in the study's quantity.
STEPS = (Adjust, Adjusted)
EMPTY: Mapping[str, str] = MappingProxyType({})


def step_record(step: Step) -> dict[str, Any]:
    """Return a step's type and fields as plain data, exactly as they are read from a journal."""
    return {"type": type(step).__name__, **_plain(step)}


def _plain(value: Any) -> Any:
    """Convert a value to JSON types: a dataclass to a dict of its fields, and a tuple to a list."""
    # `asdict` also copies every number and string, which would take half of the time of a simulated
    # run.
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
    """Return the field names of a dataclass, or an empty tuple for other types."""
    return tuple(each.name for each in fields(kind)) if is_dataclass(kind) else ()


class Scope(NamedTuple):
    """The names of levels that a part of a record can contain, and their new names.

    Other names are never changed, although a time in a study in s may end like a level.
    """

    steps: Mapping[str, str]
    plate: Mapping[str, str]
    trials: Mapping[str, str]


def in_file(header: Mapping[str, Any]) -> Callable[[Any], Any]:
    """Return the function that gives the keys of a journal's records their names in files.

    Parameters
    ----------
    header : Mapping
        Data of the journal's first record, which state the quantity of the levels, the quantity
        that the plate produces if the levels are a parameter of the stimuli, and the names of
        levels in trials.
    """
    return partial(_renamed, scope=_scope(header))


def in_code(header: Mapping[str, Any]) -> Callable[[Any], Any]:
    """Return the function that gives the keys of a journal's records their names in the code."""
    scope = _scope(header)
    return partial(
        _renamed, scope=Scope(*({new: old for old, new in part.items()} for part in scope))
    )


def _scope(header: Mapping[str, Any]) -> Scope:
    """Return the names of levels in files, keyed by name in the code."""
    levels = _stated(header.get(QUANTITY), PLATE_AMPLITUDE)
    plate = _stated(header.get(PLATE_QUANTITY), levels)
    trials = {levels.in_code[name]: name for name in header.get(TRIAL_LEVELS, ())}
    steps = {name: levels.in_file[name] for name in _level_fields(STEPS)}
    of_plate = {name: plate.in_file[name] for name in _level_fields(OF_PLATE_KINDS)}
    return Scope(steps, of_plate, trials)


@cache
def _level_fields(kinds: tuple[type, ...]) -> frozenset[str]:
    """Return the names of the fields that contain levels."""
    return frozenset(name for kind in kinds for name in _names(kind) if is_level(name))


def _stated(table: object, default: Quantity) -> Quantity:
    try:
        return QuantityTable.model_validate(table).quantity if table else default
    except ValueError:  # the header is damaged
        return default


def _renamed(data: Any, scope: Scope, names: Mapping[str, str] = EMPTY) -> Any:
    """Rename the levels in a record; ``names`` are those of the part that contains ``data``."""
    if isinstance(data, dict):
        kind = data.get("type")
        if isinstance(kind, str):
            names = scope.plate if kind == Presented.__name__ else scope.steps
        found = {
            names.get(key, key): value
            if key == "question"  # the fields of any kind of question; none of them is a level
            else _renamed(value, scope, _names_in(key, scope, names))
            for key, value in data.items()
        }
        if kind == Adjust.__name__ and isinstance(found.get("name"), str):
            found["name"] = scope.trials.get(found["name"], found["name"])
        return found
    if isinstance(data, list | tuple) and data and not isinstance(data[0], float | int | str):
        return [_renamed(each, scope, names) for each in data]
    return data


def _names_in(key: str, scope: Scope, names: Mapping[str, str]) -> Mapping[str, str]:
    """Return the names of levels in an entry of a record."""
    if key in OF_PLATE:
        return scope.plate
    return scope.trials if key == "factors" else names


def same_step(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Return whether two records describe the same step, ignoring displayed text."""
    return bool(_without_words(one) == _without_words(other))


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
