"""Which texts of a study a screen shows, so that a text can be changed where it is seen."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

from slipscale.experiments.languages.screen_room import LETTER_KEY, room_of
from slipscale.experiments.languages.texts import SET_BY_KEYS, Texts, answers
from slipscale.experiments.participants.psychopy_window.layout import faults
from slipscale.experiments.running.screen_check import Seen, distinct_scenes
from slipscale.experiments.steps.screens.scene import Item, Text
from slipscale.experiments.study.run_plan import RunPlan

#: Start of a range of characters that no text contains: each marks the texts of one key.
MARKS = 0xE000


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyedScreen(Seen):
    """A screen, and for each item of its scene the keys of the texts that the item shows."""

    keys: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Marked(RunPlan):
    """A plan in which every answer or other text begins with the mark of its key."""

    def texts(self) -> Texts:
        found = RunPlan.texts(self)
        return {
            key: " | ".join(chr(MARKS + place) + each for each in answers(text))
            if _marked(key)
            else text
            for place, (key, text) in enumerate(sorted(found.items()))
        }


def keyed_screens(plan: RunPlan) -> Iterator[KeyedScreen]:
    """Yield the distinct screens of a run, as `every_screen` does, with the keys of their texts."""
    keys = sorted(plan.texts())
    marked = _Marked(**{each.name: getattr(plan, each.name) for each in fields(plan)})
    seen = set()
    for task, step, scene in distinct_scenes(marked):
        plain, marks = zip(*map(_without_marks, scene), strict=True) if scene else ((), ())
        if plain not in seen:
            seen.add(plain)
            yield KeyedScreen(
                task=task,
                step=step,
                scene=plain,
                faults=tuple(faults(plain, plan.study.screens)),
                keys=tuple(tuple(dict.fromkeys(keys[mark] for mark in each)) for each in marks),
            )


def _marked(key: str) -> bool:
    """Return whether a text is shown as words: letters on keys are also compared with answers."""
    return key not in SET_BY_KEYS and room_of(key) != LETTER_KEY


def _without_marks(item: Item) -> tuple[Item, list[int]]:
    if not isinstance(item, Text):
        return item, []
    marks = [ord(letter) - MARKS for letter in item.content if _is_mark(letter)]
    plain = "".join(letter for letter in item.content if not _is_mark(letter))
    return replace(item, content=plain), marks


def _is_mark(letter: str) -> bool:
    return MARKS <= ord(letter) < MARKS + 0x1900
