"""Screen contents as plain data (text, key caps and bars), readable at a distance of 1 m.

Lengths are fractions of the screen height, the origin is at the centre, and y points up. The
font size of the smallest text that participants must read is 0.036 of the screen height. The
x-height of this text is 5.8 mm on a 24 inch monitor. At a distance of 1 m, this is a visual
angle of 20 minutes of arc, four times the smallest letter size that people with normal vision can
read.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

Colour = Literal["ground", "field", "text", "quiet", "accent"]
Theme = Literal["dark", "light"]
DARK: Theme = "dark"

# Grey and one accent colour per theme (Okabe and Ito's blues, suitable for all types of colour
# vision).
COLOURS: dict[Theme, dict[Colour, tuple[int, int, int]]] = {
    "dark": {
        "ground": (38, 40, 43),
        "field": (56, 59, 63),
        "text": (232, 232, 230),
        "quiet": (168, 172, 177),
        "accent": (86, 180, 233),
    },
    "light": {
        "ground": (245, 245, 243),
        "field": (224, 226, 229),
        "text": (31, 35, 38),
        "quiet": (80, 86, 92),
        "accent": (0, 94, 158),
    },
}
FONT = "Noto Sans"  # included in PsychoPy, so it is available on every platform
DESIGN_WIDTH = 1.34  # maximum width of a scene, in screen heights; narrower screens scale it down

UP, DOWN = "up", "down"  # labels of the arrow keys
TITLE, BODY, HINT, DIGITS = 0.062, 0.042, 0.036, 0.13
HINT_Y = -0.4
WIDTH = 1.3  # line width of a text, in screen heights


@dataclass(frozen=True, slots=True, kw_only=True)
class Text:
    """Text of size ``size``, wrapped to ``width``, centred at ``x``, with its ``anchor`` at ``y``.

    If ``caret`` is True, a caret follows the last letter; this requires text of one line.
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
    height: float | None = None  # maximum height; a taller text is shrunk to fit
    caret: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A filled rectangle centred at ``x``, ``y``."""

    x: float
    y: float
    width: float
    height: float
    colour: Colour


@dataclass(frozen=True, slots=True, kw_only=True)
class Disc:
    """A filled circle centred at ``x``, ``y``."""

    x: float
    y: float
    diameter: float
    colour: Colour


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrow:
    """An arrow pointing up or down, drawn as a shape because the font lacks arrows."""

    x: float
    y: float
    size: float
    up: bool
    colour: Colour = "text"


@dataclass(frozen=True, slots=True, kw_only=True)
class Area:
    """An invisible area over a drawn key that responds to touches and clicks.

    A touch or click sends ``presses``: one or more characters, `UP` or `DOWN`.
    """

    x: float
    y: float
    width: float
    height: float
    presses: str

    def holds(self, x: float, y: float) -> bool:
        """Return whether a point is in the area."""
        return abs(x - self.x) <= self.width / 2 and abs(y - self.y) <= self.height / 2


Item = Text | Box | Disc | Arrow | Area
Scene = tuple[Item, ...]


def unbroken(text: str) -> str:
    """Insert no-break spaces to keep French punctuation on the same line as the adjacent word.

    >>> unbroken("Est-ce glissant ?") == "Est-ce glissant\N{NO-BREAK SPACE}?"
    True
    """
    return re.sub(r" (?=[?!:;»])|(?<=«) ", "\N{NO-BREAK SPACE}", text)


def bar(fraction: float, *, y: float, width: float = 0.8, height: float = 0.018) -> Scene:
    """Return a horizontal bar, filled from the left up to ``fraction`` (0 to 1)."""
    filled = width * min(max(fraction, 0.0), 1.0)
    track = Box(x=0, y=y, width=width, height=height, colour="field")
    if not filled:
        return (track,)
    left = -width / 2
    return (track, Box(x=left + filled / 2, y=y, width=filled, height=height, colour="accent"))


def key_cap(label: str, *, x: float, y: float, size: float = 0.14) -> Scene:
    """Return a drawing of a keyboard key. The labels `UP` and `DOWN` are drawn as arrows."""
    rim = 0.01 * size / 0.14
    arrow = Arrow(x=x, y=y, size=0.45 * size, up=label == UP)
    letter = Text(content=label.upper(), x=x, y=y, size=0.45 * size, bold=True, width=size)
    return (
        Box(x=x, y=y, width=size + rim, height=size + rim, colour="accent"),
        Box(x=x, y=y, width=size, height=size, colour="field"),
        arrow if label in (UP, DOWN) else letter,
    )


def pressed_at(scene: Scene, x: float, y: float) -> str:
    """Return the characters of the drawn key at a point, or an empty string if there is none."""
    areas = (item for item in scene if isinstance(item, Area))
    return next((area.presses for area in areas if area.holds(x, y)), "")


def key_row(
    keys: tuple[str, ...], meanings: tuple[str, ...], *, y: float, touch: bool = False
) -> Scene:
    """Return a row of drawn keys with a label below each key."""
    pitch = 0.44 if len(keys) < 3 else 0.38  # noqa: PLR2004 - so that three fit the narrowest screen
    left = -pitch * (len(keys) - 1) / 2
    return tuple(
        item
        for n, (key, meaning) in enumerate(zip(keys, meanings, strict=True))
        for item in (
            *key_cap(key, x=left + n * pitch, y=y),
            Text(content=meaning, x=left + n * pitch, y=y - 0.093, width=0.9 * pitch, anchor="top"),
            *_touched(
                touch,
                Area(x=left + n * pitch, y=y - 0.03, width=0.9 * pitch, height=0.22, presses=key),
            ),
        )
    )


def _touched(touch: bool, area: Area) -> Scene:
    return (area,) if touch else ()


def key_list(meanings: tuple[str, ...], *, top: float, height: float, touch: bool = False) -> Scene:
    """Return a column of drawn number keys (1, 2, ...), each with a label next to it."""
    pitch = min(height / len(meanings), 0.1)
    left, cap = -0.32, 0.72 * pitch
    rows = [(str(n), words, top - pitch * (n - 0.5)) for n, words in enumerate(meanings, start=1)]
    return tuple(
        item
        for key, words, y in rows
        for item in (
            *key_cap(key, x=left, y=y, size=cap),
            Text(content=words, x=left + 0.57, y=y, align="left", size=min(0.05, cap), width=1.0),
            *_touched(touch, Area(x=0.2, y=y, width=1.2, height=pitch, presses=key)),
        )
    )


def button(label: str, presses: str, *, x: float, y: float, width: float, height: float) -> Scene:
    """Return a wide on-screen key with a label."""
    rim = 0.006
    return (
        Box(x=x, y=y, width=width + rim, height=height + rim, colour="accent"),
        Box(x=x, y=y, width=width, height=height, colour="field"),
        Text(content=label, x=x, y=y, size=min(HINT, 0.45 * height), width=width, height=height),
        Area(x=x, y=y, width=width, height=height, presses=presses),
    )


def hint(content: str) -> Text:
    """Return the line of text at the bottom of a screen that names the continue key."""
    return Text(content=content, y=HINT_Y, size=HINT, colour="quiet")


def notice(content: str) -> Text:
    """Return the line that explains why an entry was rejected."""
    return Text(content=content, y=-0.28, size=HINT, colour="accent")


def pilot_banner(content: str) -> Scene:
    """Return the banner that appears at the top of every screen of a pilot run."""
    height = 0.055
    y = 0.5 - height / 2
    return (
        Box(x=0, y=y, width=4.0, height=height, colour="accent"),
        Text(content=content, y=y, size=0.03, colour="ground", bold=True),
    )


def progress_line(done: float) -> Scene:
    """Return a line at the bottom of a screen; ``done`` is the finished proportion, at most 1."""
    y, height, width = -0.488, 0.008, WIDTH
    finished = width * min(done, 1.0)
    return (
        Box(x=0, y=y, width=width, height=height, colour="field"),
        Box(x=(finished - width) / 2, y=y, width=finished, height=height, colour="quiet"),
    )


def message(content: str) -> Scene:
    """Return a screen that shows only a message."""
    return (Text(content=content, y=0.0, size=TITLE, width=1.1),)
