"""Answer fields of a number and of a long list, with on-screen keys for touch or mouse."""

from __future__ import annotations

from collections.abc import Mapping

from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.screens.entry import CLEAR, ENTER, ERASE
from slipscale.experiments.steps.screens.scene import Area, Arrow, Box, Scene, Text
from slipscale.experiments.steps.screens.screen_texts import by_touch

# Rows from top to bottom, as on a keypad.
DIGITS = ("789", "456", "123")
CAP, PITCH = 0.098, 0.108
ROWS_SHOWN = 8
TOP, ROW = 0.19, 0.054


def number(content: str, texts: Mapping[str, str]) -> Scene:
    """Return the answer field of a number, with on-screen keys if the participant uses them."""
    if by_touch(texts):
        return _number_pad(content, texts)
    roomy = 11  # digits that fit the field at full size
    size = scene.DIGITS * min(1.0, roomy / max(len(content), 1))
    return (
        Box(x=0, y=0.02, width=1.0, height=0.2, colour="field"),
        Text(content=content, y=0.02, size=size, width=2.0, caret=True),
    )


def _number_pad(content: str, texts: Mapping[str, str]) -> Scene:
    """Return the answer field, and touch keys for digits, decimal mark, delete and Enter."""
    left, top = -0.27, 0.005
    keys = [
        (label, left + column * PITCH, top - row * PITCH)
        for row, labels in enumerate((*DIGITS, ("0", texts["window.decimal"])))
        for column, label in enumerate(labels)
    ]
    wide = left + 4.05 * PITCH
    return (
        Box(x=0, y=0.12, width=0.8, height=0.115, colour="field"),
        Text(content=content, y=0.12, size=0.085 * min(1.0, 15 / max(len(content), 1)),
             width=2.0, caret=True),
        *(item for label, x, y in keys for item in _cap(label, x, y)),
        *scene.button(texts["window.key_delete"], ERASE, x=wide, y=top - PITCH / 2,
                      width=0.25, height=CAP + PITCH),
        *scene.button(texts["window.key_enter"], ENTER, x=wide, y=top - 2.5 * PITCH,
                      width=0.25, height=CAP + PITCH),
    )  # fmt: skip


def _cap(label: str, x: float, y: float) -> Scene:
    return (
        *scene.key_cap(label, x=x, y=y, size=CAP),
        Area(x=x, y=y, width=PITCH, height=PITCH, presses=label),
    )


def scrolled(
    words: tuple[str, ...], place: int | None, content: str, texts: Mapping[str, str]
) -> Scene:
    """Return the visible rows of a long list of answers, scrolled to the item at ``place``."""
    last = max(len(words) - ROWS_SHOWN, 0)
    first = min(max((place or 0) - ROWS_SHOWN // 2, 0), last)
    seen = range(first, min(first + ROWS_SHOWN, len(words)))
    rows = [
        item
        for row, number in enumerate(seen)
        for item in _row(number, words[number], TOP - row * ROW, chosen=number == place)
    ]
    ends = (
        *(_arrow(TOP, up=True) if first else ()),
        *(_arrow(TOP - (ROWS_SHOWN - 1) * ROW, up=False) if first < last else ()),
    )
    typed = Text(content=content, x=0.53, y=0.0, size=0.07, width=0.2, caret=True)
    enter = scene.button(texts["window.key_enter"], ENTER, x=0.53, y=-0.1, width=0.2, height=0.075)
    return (*rows, *ends, Box(x=0.53, y=0.0, width=0.2, height=0.09, colour="field"), typed, *enter)


def _row(number: int, words: str, y: float, *, chosen: bool) -> Scene:
    """Return one row of the list of answers. Touching the row selects its answer."""
    left, width = -0.62, 1.0
    ground = (Box(x=left + width / 2, y=y, width=width, height=ROW, colour="accent"),)
    colour: scene.Colour = "ground" if chosen else "text"
    return (
        *(ground if chosen else ()),
        Text(content=str(number + 1), x=left + 0.06, y=y, size=0.036, width=0.1, colour=colour,
             bold=True),
        Text(content=words, x=left + 0.12 + 0.43, y=y, size=0.036, width=0.86, align="left",
             height=ROW, colour=colour),
        Area(x=left + width / 2, y=y, width=width, height=ROW, presses=f"{CLEAR}{number + 1}"),
    )  # fmt: skip


def _arrow(y: float, *, up: bool) -> Scene:
    presses = scene.UP if up else scene.DOWN
    return (
        Arrow(x=0.53, y=y, size=0.05, up=up, colour="accent"),
        Area(x=0.53, y=y, width=0.2, height=0.08, presses=presses),
    )
