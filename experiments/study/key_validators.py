"""Validate each key of a study, given the valid keys that precede it.

The functions are pydantic validators, which receive a key's value and the preceding keys, and
return the value.
"""

from __future__ import annotations

from pydantic import ValidationError, ValidationInfo

from slipscale.experiments.languages.texts import ENGLISH, languages
from slipscale.experiments.protocol_parts.base import Options
from slipscale.experiments.protocol_parts.registry import load_protocol, protocol_names
from slipscale.experiments.study.checks_across_keys import (
    impossible,
    named_twice,
    unpresented,
    unreadable,
    unspoken,
)
from slipscale.experiments.study.factors import (
    MOST_CONDITIONS,
    Factor,
    conditions_of,
    second_faults,
    uncrossable,
)
from slipscale.experiments.study.levels import Levels
from slipscale.experiments.study.stroke import Stroke
from slipscale.experiments.study.tables import (
    PlateSettings,
    StatedWords,
    StimulusTable,
    Texture,
)
from slipscale.faults.message import Message
from slipscale.faults.suggestions import expected_one_of
from slipscale.faults.validation import Fault, faults_in, refuse
from slipscale.stimuli.attributes import ATTRIBUTES
from slipscale.stimuli.parameters import field_of
from slipscale.stimuli.textures import PARAMETERS


def valid_attribute_words(
    value: dict[str, StatedWords], info: ValidationInfo
) -> dict[str, StatedWords]:
    """Require wording in the study's language for attributes not built into Slipscale."""
    judged = _levels(info).made.judged
    language = info.data.get("language", ENGLISH)
    if language not in value and language in languages() and judged not in ATTRIBUTES:
        raise ValueError(
            Message(
                "{expected_one_of}, got attribute '{judged}'; or state an adjective and a noun "
                "in [attribute_words.{language}]",
                expected_one_of=expected_one_of(judged, list(ATTRIBUTES)),
                judged=judged,
                language=language,
            )
        )
    return value


def valid_vary(value: str, info: ValidationInfo) -> str:
    """Check that the key names a parameter that can be varied."""
    plate = _levels(info).made
    if value and field_of(value, plate, PARAMETERS) is None:
        raise ValueError(expected_one_of(value, [plate.named(each) for each in PARAMETERS]))
    return value


def valid_stimulus(value: StimulusTable | None, info: ValidationInfo) -> StimulusTable | None:
    """Require the table of fixed parameters if a parameter is varied, and reject it otherwise."""
    vary = info.data.get("vary", "")
    if value is None and vary:
        raise ValueError(
            Message("expected the table [stimulus], because {vary} is varied", vary=vary)
        )
    if value is not None and not vary:
        raise ValueError("expected the key vary, which names the varied parameter")
    if value is not None:
        refuse(value.faults(_levels(info).vary), within=True)
    return value


def valid_plate(value: PlateSettings, info: ValidationInfo) -> PlateSettings:
    """Require the plate's limit unless the default, in µm, fits the plate's quantity."""
    refuse(_levels(info).unstated(("plate",), value))
    return value


def valid_stroke(value: Stroke | None, info: ValidationInfo) -> Stroke | None:
    """Require a stroke that the study's sensors can measure."""
    if value is not None and "plate" in info.data:
        refuse(list(value.faults(info.data["plate"])))
    return value


def valid_levels(value: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
    """Require different levels, all of which the plate can present."""
    faults = list(_levels(info).unpresentable(("levels",), *value))
    if len(set(value)) < len(value):
        faults.append((("levels",), {"msg": "expected different values"}))
    refuse(faults)
    return value


def valid_textures(value: tuple[Texture, ...], info: ValidationInfo) -> tuple[Texture, ...]:
    """Require textures with different names, all of which the plate can present."""
    faults = list(named_twice("textures", [texture.name for texture in value]))
    for number, texture in enumerate(value):
        faults += _levels(info).beyond(("textures", number), texture.surface())
    if value and info.data.get("stimulus"):
        faults.append((("textures",), {"msg": "cannot be combined with vary"}))
    if not value and info.data.get("levels") == ():
        faults.append((("levels",), {"type": "missing", "msg": ""}))
    refuse(faults)
    return value


def valid_factors(value: tuple[Factor, ...], info: ValidationInfo) -> tuple[Factor, ...]:
    """Check that factors have different names and can be combined into conditions."""
    faults = list(named_twice("factors", [factor.name for factor in value]))
    for number, factor in enumerate(value):
        faults += uncrossable(("factors", number), factor, info.data)
    if second := info.data.get("second_plate"):
        faults += second_faults(second, value)
    count = len(conditions_of(value)) if value else 1
    if count > MOST_CONDITIONS:
        message = Message(
            "expected at most {most} combinations, not {count}", most=MOST_CONDITIONS, count=count
        )
        faults.append((("factors",), {"msg": message}))
    refuse(faults)
    return value


def valid_tasks(tables: object, info: ValidationInfo) -> object:
    """Return the options of each task; raise an error if a task is impossible in this study."""
    if not isinstance(tables, list | tuple):
        raise ValueError("expected [[tasks]] tables, each with a protocol")  # noqa: TRY004 - pydantic gathers ValueErrors
    faults: list[Fault] = []
    tasks: list[Options] = []
    for number, table in enumerate(tables):
        place = ("tasks", number)
        try:
            task = _task(table, info)
        except ValidationError as error:
            options = load_protocol(table["protocol"]).options
            found = faults_in(error, options, info.context)
            faults += [((*place, *inner), f) for inner, f in found]
        except ValueError as error:
            faults.append(((*place, "protocol"), {"msg": str(error)}))
        else:
            faults += _levels(info).unstated(place, task)
            faults += impossible(place, task, tasks, info.data)
            tasks.append(task)
    refuse(faults or unpresented(tasks, info.data))
    return tasks


def valid_sessions(value: tuple[str, ...]) -> tuple[str, ...]:
    """Require sessions with different labels."""
    if len({label.casefold() for label in value}) < len(value):
        raise ValueError("expected different values")
    return value


def valid_texts(
    value: dict[str, dict[str, object]], info: ValidationInfo
) -> dict[str, dict[str, object]]:
    """Require valid texts, and questions in the study's language."""
    refuse([*unreadable(value, info.data.get("tasks", ())), *unspoken(value, info.data)])
    return value


def _levels(info: ValidationInfo) -> Levels:
    return Levels.of(info.data)


def _task(table: object, info: ValidationInfo) -> Options:
    """Return the options given in one [[tasks]] table."""
    if isinstance(table, Options):
        return table
    name = table.get("protocol") if isinstance(table, dict) else None
    if name not in protocol_names():
        raise ValueError(
            Message(
                "{expected_one_of}, got {name}",
                expected_one_of=expected_one_of(name, protocol_names()),
                name=repr(name),
            )
        )
    return load_protocol(name).options.model_validate(table, context=info.context)
