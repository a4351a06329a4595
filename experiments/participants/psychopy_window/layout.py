"""Check that a scene is readable by laying out its texts without opening a window.

Scenes scale with the screen (`display`), so one layout is valid for every window size. Letters are
measured in the window's font if PsychoPy is installed, otherwise in matplotlib's font, which is
wider.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from itertools import combinations
from pathlib import Path

from slipscale.experiments.languages.screen_room import not_drawn
from slipscale.experiments.steps.screens.scene import (
    COLOURS,
    DARK,
    Box,
    Colour,
    Scene,
    Text,
    Theme,
    unbroken,
)
from slipscale.faults.message import Message

FILE = "NotoSans-Regular.ttf"
SMALLEST = 0.6  # relative size of a text that must shrink to fit
SHRINK = 0.94
LINE = 1.362  # line spacing of Noto Sans, relative to the font size
HALF_WIDTH, HALF_HEIGHT = 0.67, 0.5  # of a scene
MEASURED_AT = 100.0  # points
WIDER = 1.12  # width of letters in DejaVu Sans, relative to Noto Sans
# Tolerances for texts that exceed an area or overlap; sizes are measured with 1 % accuracy.
SLACK, SHARED = 0.012, 0.003
LEAST_CONTRAST = 4.5  # contrast between letters and background: WCAG 2.2, 1.4.3
MOST_NAMED = 50  # maximum length of a text quoted in a message


@dataclass(frozen=True, slots=True, kw_only=True)
class Laid:
    """Layout of a text: lines, edges, and whether the text fits its area."""

    content: str
    lines: tuple[str, ...]
    widths: tuple[float, ...]
    size: float
    left: float
    right: float
    bottom: float
    top: float
    fits: bool


def faults(scene: Scene, theme: Theme = DARK) -> Iterator[str]:
    """Yield a message for each reason why a text in a scene is not readable."""
    texts = [item for item in scene if isinstance(item, Text) and item.content.strip()]
    strange = {text: reason for text in texts if (reason := not_drawn(text.content))}
    for text, reason in strange.items():
        yield f"{_named(text.content)}: {reason}"
    laid = [lay(text) for text in texts if text not in strange]
    for each in laid:
        if not each.fits:
            yield Message(
                "{content} is too long for its place on the screen", content=_named(each.content)
            )
        elif max(each.right, -each.left) > HALF_WIDTH or max(each.top, -each.bottom) > HALF_HEIGHT:
            yield Message("{content} extends beyond the screen", content=_named(each.content))
    for one, other in combinations(laid, 2):
        across = min(one.right, other.right) - max(one.left, other.left)
        down = min(one.top, other.top) - max(one.bottom, other.bottom)
        if min(across, down) > SHARED:
            yield f"{_named(one.content)} and {_named(other.content)} overlap"
    for text, behind in _backgrounds(scene):
        if (found := contrast(text.colour, behind, theme)) < LEAST_CONTRAST:
            yield (
                Message(
                    "{content}: its contrast is {found:.1f} to 1, expected at least "
                    "{least_contrast:g} to 1",
                    content=_named(text.content),
                    found=found,
                    least_contrast=LEAST_CONTRAST,
                )
            )


def _backgrounds(scene: Scene) -> Iterator[tuple[Text, Colour]]:
    """Yield each text with its background, the colour of the topmost box behind its centre."""
    boxes: list[Box] = []
    for item in scene:
        if isinstance(item, Box):
            boxes.append(item)
        elif isinstance(item, Text) and item.content.strip():
            under = [
                box.colour
                for box in boxes
                if abs(item.x - box.x) < box.width / 2 and abs(item.y - box.y) < box.height / 2
            ]
            yield item, under[-1] if under else "ground"


def contrast(one: Colour, other: Colour, theme: Theme = DARK) -> float:
    """Return the contrast between two colours, from 1 to 21, as defined by WCAG 2.2.

    >>> round(contrast("text", "ground"), 1)
    12.0
    """
    colours = COLOURS[theme]
    bright, dark = sorted((_luminance(colours[one]), _luminance(colours[other])), reverse=True)
    return (bright + 0.05) / (dark + 0.05)


def _luminance(colour: tuple[int, int, int]) -> float:
    shares = (value / 255 for value in colour)
    linear = [s / 12.92 if s <= 0.04045 else ((s + 0.055) / 1.055) ** 2.4 for s in shares]  # noqa: PLR2004 - sRGB
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def lay(text: Text) -> Laid:
    """Lay out a text as the window does: wrap at spaces, and shrink the text if it is too tall."""
    size = text.size
    lines = _lines(text, size)
    limit = float("inf") if text.height is None else text.height
    while len(lines) * LINE * size > limit and size > SMALLEST * text.size:
        size *= SHRINK
        lines = _lines(text, size)
    wide, high = max(width for _, width in lines), len(lines) * LINE * size
    left = text.x - (text.width if text.align == "left" else wide) / 2
    bottom = text.y - {"top": high, "center": high / 2, "bottom": 0.0}[text.anchor]
    blank = (LINE - 1) / 2 * size  # blank space above the first and below the last line
    return Laid(
        content=text.content,
        lines=tuple(line for line, _ in lines),
        widths=tuple(width for _, width in lines),
        size=size,
        left=left,
        right=left + wide,
        bottom=bottom + blank,
        top=bottom + high - blank,
        fits=high <= limit + SLACK and wide <= text.width + SLACK,
    )


def _lines(text: Text, size: float) -> list[tuple[str, float]]:
    """Wrap a text into lines; return each line with its width."""
    space = _em(" ") * size
    lines: list[tuple[str, float]] = []
    for paragraph in unbroken(text.content).split("\n"):
        line, width = "", 0.0
        for word in filter(None, paragraph.split(" ")):
            wide = _em(word) * size
            if line and width + space + wide > text.width:
                lines.append((line, width))
                line, width = word, wide
            else:
                line, width = f"{line} {word}".strip(" "), width + wide + (space if line else 0.0)
        lines.append((line, width))
    return lines


@cache
def _em(word: str) -> float:
    """Return the width of a word in em (multiples of the font size)."""
    font, share = _font()
    font.set_text(word, 0.0)
    return float(font.get_width_height()[0] / 64 / MEASURED_AT * share) if word.strip() else 0.26


@cache
def _font():  # type: ignore[no-untyped-def] # noqa: ANN202 - matplotlib's font, loaded late
    from matplotlib import get_data_path
    from matplotlib.ft2font import FT2Font

    spec = find_spec("psychopy")
    own = Path(spec.origin if spec and spec.origin else "", "..", "assets/fonts", FILE).resolve()
    share = 1.0 if own.exists() else 1 / WIDER
    font = FT2Font(str(own if own.exists() else Path(get_data_path(), "fonts/ttf/DejaVuSans.ttf")))
    font.set_size(MEASURED_AT, 72)
    return font, share


def _named(content: str) -> str:
    words = " ".join(content.split())
    return f"'{words if len(words) <= MOST_NAMED else words[: MOST_NAMED - 1] + '…'}'"
