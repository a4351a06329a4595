"""Check that the keys of a study are consistent with each other.

Each check yields errors with their locations in the file. A check receives only valid keys, and is
skipped if a required key is invalid.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from slipscale.experiments.languages.texts import CODE, languages, text_faults
from slipscale.experiments.protocol_parts.base import Options, protocol_texts
from slipscale.experiments.protocol_parts.registry import load_protocol
from slipscale.experiments.study.headphone_test import HEADPHONES
from slipscale.experiments.study.levels import Levels
from slipscale.experiments.study.person_questions import unanswerable
from slipscale.experiments.study.questionnaires import unusable
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.toml_lines import Place
from slipscale.faults.validation import Fault


def named_twice(table: str, names: list[str]) -> Iterator[Fault]:
    """Yield an error for each repeated name in a table."""
    for number, name in enumerate(names):
        if name in names[:number]:
            yield (
                (table, number, "name"),
                {"msg": Message("there is already a '{name}'", name=name)},
            )


def impossible(
    place: Place, task: Options, before: list[Options], data: Mapping[str, Any]
) -> Iterator[Fault]:
    """Yield an error for each reason why a task is impossible in this study."""
    protocol, own = load_protocol(task.protocol), Levels.of(data)
    labels = [load_protocol(other.protocol).for_task(other).task for other in before]
    if (label := protocol.for_task(task).task) in labels:
        # Tasks with the same label would share a table, with the same trial numbers.
        message = Message("there is already a '{label}': set another label", label=label)
        yield (*place, "label" if task.label else "protocol"), {"msg": message}
    for key in protocol.amplitudes:
        given = getattr(task, key, None) or ()
        each = given if isinstance(given, tuple) else (given,)
        if own.vary and protocol.possible_levels:
            continue  # some of these options are differences between levels
        yield from own.unpresentable((*place, key), *each)
    try:
        texts = protocol_texts(protocol, data.get("language", "en"))
    except UserError as error:
        yield (*place, "protocol"), {"msg": str(error)}
        return
    if protocol.texts and protocol.instructions not in texts:
        message = Message(
            "the protocol has no text for its instructions '{key}'", key=protocol.instructions
        )
        yield (*place, "protocol"), {"msg": message}
    columns = {*protocol.design, *protocol.stimulus, *protocol.response}
    shared = columns & {factor.name for factor in data.get("factors", ())}
    yield from (
        (
            place,
            {
                "msg": (
                    Message("the protocol's column '{name}' has the name of a factor", name=name)
                )
            },
        )
        for name in shared
    )
    levels, textures = data.get("levels"), data.get("textures")
    if levels is None or textures is None:
        return
    context = own.context(levels, tuple(texture.surface() for texture in textures), label)
    try:
        if protocol.check:
            protocol.check(task, context)
        possible = protocol.possible_levels(task, context) if protocol.possible_levels else ()
        yield from own.unpresentable(place, *sorted(set(possible)))
        if not protocol.trials(task, context):
            yield (
                place,
                {
                    "msg": Message(
                        "the task has no trials with these {levels}", levels=own.quantity.levels
                    )
                },
            )
    except UserError as error:
        yield place, {"msg": str(error)}


def unpresented(tasks: list[Options], data: Mapping[str, Any]) -> Iterator[Fault]:
    """Yield an error if a study has textures that no task presents."""
    presented = any(load_protocol(task.protocol).textures for task in tasks)
    if data.get("textures") and not presented:
        yield (
            ("textures", 0),
            {
                "msg": (
                    "no task presents textures; add a task that does, such as magnitude_estimation"
                )
            },
        )


def unreadable(texts: dict[str, dict[str, Any]], tasks: tuple[Options, ...]) -> Iterator[Fault]:
    """Yield the errors in the texts that a study defines."""
    protocols = [load_protocol(task.protocol) for task in tasks]
    for language, own in texts.items():
        place = ("texts", language)
        if not CODE.fullmatch(language):
            yield place, {"msg": "expected a language code, such as de or pt-BR"}
            continue
        if language in languages():
            brought = {k: t for each in protocols for k, t in each.texts.get(language, {}).items()}
        else:
            brought = {k: t for p in protocols for k, t in protocol_texts(p, language).items()}
        for key, sentence in text_faults(language, own, brought):
            yield (*place, *key.split(".")), {"msg": sentence}


def unspoken(texts: dict[str, dict[str, Any]], data: Mapping[str, Any]) -> Iterator[Fault]:
    """Yield errors for an unknown language, ambiguous names and untranslated questions."""
    known = [*languages(), *sorted(set(texts) - set(languages()))]
    language, questions = data.get("language"), data.get("about_you", ())
    yield from named_twice("about_you", [question.name for question in questions])
    if language is not None and language not in known:
        fault = {
            "msg": Message("expected one of {known}", known=", ".join(known)),
            "input": language,
        }
        yield ("language",), fault
    elif language is not None:
        yield from unanswerable(questions, language, known)
        tasks = [load_protocol(t.protocol).for_task(t).task for t in data.get("tasks", ())]
        if data.get("headphone_test") and HEADPHONES in tasks:
            fault = {
                "msg": (
                    Message(
                        "expected another label: '{label}' is used by the headphone test",
                        label=HEADPHONES,
                    )
                )
            }
            yield ("tasks", tasks.index(HEADPHONES), "label"), fault
        taken = [HEADPHONES, *tasks, *(question.name for question in questions)]
        yield from unusable(data.get("questionnaires", ()), language, known, taken)
