"""What a screen shows, as plain data: texts, key caps and bars, laid out for reading at 1 m.

Lengths are fractions of the screen's height, the origin is its centre and y points up. On a 24
inch monitor (0.30 m high) the smallest letters are 10 mm high from ascender to descender: their
x-height of 5 mm is seen at 1 m under 17 minutes of arc, three times what normal sight needs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Colour = Literal["ground", "field", "text", "quiet", "accent"]

TITLE, BODY, HINT, DIGITS = 0.062, 0.042, 0.034, 0.13
WIDTH = 1.3  # of a text's lines; the narrowest monitors (5:4) are 1.25 wide, see `display`


@dataclass(frozen=True, slots=True, kw_only=True)
class Text:
    """Letters: ``size`` from ascender to descender, centred on ``x``; ``y`` is ``anchor``'s.

    ``caret`` draws a caret after the last letter.
    """

    content: str
    y: float
    size: float = BODY
    x: float = 0.0
    colour: Colour = "text"
    bold: bool = False
    anchor: Literal["top", "center", "bottom"] = "center"
    align: Literal["left", "center"] = "center"
    width: float = WIDTH
    height: float | None = None  # letters shrink until the text is no higher than this
    caret: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A rectangle, filled; ``x``, ``y`` is its centre."""

    x: float
    y: float
    width: float
    height: float
    colour: Colour


Scene = tuple[Text | Box, ...]


def bar(fraction: float, *, y: float, width: float = 0.8, height: float = 0.018) -> Scene:
    """Return a horizontal bar of which ``fraction`` (0 to 1) is filled from the left."""
    filled = width * min(max(fraction, 0.0), 1.0)
    track = Box(x=0, y=y, width=width, height=height, colour="field")
    if not filled:
        return (track,)
    left = -width / 2
    return (track, Box(x=left + filled / 2, y=y, width=filled, height=height, colour="accent"))


def key_cap(label: str, meaning: str, *, x: float, y: float) -> Scene:
    """Return a key as it is drawn on a keyboard, with what it stands for below it."""
    size = 0.14
    return (
        Box(x=x, y=y, width=size + 0.01, height=size + 0.01, colour="accent"),
        Box(x=x, y=y, width=size, height=size, colour="field"),
        Text(content=label.upper(), x=x, y=y, size=TITLE, bold=True, width=size),
        Text(content=meaning, x=x, y=y - size / 2 - 0.05, size=BODY, width=0.4),
    )


def hint(content: str) -> Text:
    """Return the line at the foot of a screen that says which key goes on."""
    return Text(content=content, y=-0.4, size=HINT, colour="quiet")


def notice(content: str) -> Text:
    """Return the line that explains why an entry was not taken."""
    return Text(content=content, y=-0.3, size=HINT, colour="accent")


def pilot_banner(content: str) -> Scene:
    """Return the strip at the top of every screen of a pilot run."""
    height = 0.055
    y = 0.5 - height / 2
    return (
        Box(x=0, y=y, width=4.0, height=height, colour="accent"),
        Text(content=content, y=y, size=0.03, colour="ground", bold=True),
    )


def message(content: str) -> Scene:
    """Return a screen with one sentence and nothing to do."""
    return (Text(content=content, y=0.0, size=TITLE, width=1.1),)
