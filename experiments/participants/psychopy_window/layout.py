"""Whether a scene can be read: its letters measured and laid out without a window.

Scenes scale with the screen (`display`), so one layout holds for every window's size. Letters are
measured in the window's own font if PsychoPy is installed, else in matplotlib's, which is wider.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.experiments.languages.screen_room import not_drawn
from slipscale.experiments.participants.psychopy_window.scene import Text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from slipscale.experiments.participants.psychopy_window.scene import Scene

FILE = "NotoSans-Regular.ttf"
SMALLEST = 0.6  # of a text's own size, where it must shrink
SHRINK = 0.94
LINE = 1.362  # of the size, from line to line: Noto Sans
HALF_WIDTH, HALF_HEIGHT = 0.67, 0.5  # of a scene
MEASURED_AT = 100.0  # points
WIDER = 1.12  # letters of DejaVu Sans, in those of Noto Sans
# How much a text may exceed its place, and what two texts may share: measures are to 1 %.
SLACK, SHARED = 0.012, 0.003
MOST_NAMED = 50  # letters of a text that a message repeats


@dataclass(frozen=True, slots=True, kw_only=True)
class Laid:
    """A text as it will stand: its edges, and whether it fits its own place."""

    content: str
    left: float
    right: float
    bottom: float
    top: float
    fits: bool


def faults(scene: Scene) -> Iterator[str]:
    """Yield a sentence for each text of a scene that cannot be read."""
    texts = [item for item in scene if isinstance(item, Text) and item.content.strip()]
    strange = {text: reason for text in texts if (reason := not_drawn(text.content))}
    for text, reason in strange.items():
        yield f"{_named(text.content)}: {reason}"
    laid = [lay(text) for text in texts if text not in strange]
    for each in laid:
        if not each.fits:
            yield f"{_named(each.content)}: is too long for its place on the screen"
        elif max(each.right, -each.left) > HALF_WIDTH or max(each.top, -each.bottom) > HALF_HEIGHT:
            yield f"{_named(each.content)}: reaches beyond the screen"
    for one, other in combinations(laid, 2):
        across = min(one.right, other.right) - max(one.left, other.left)
        down = min(one.top, other.top) - max(one.bottom, other.bottom)
        if min(across, down) > SHARED:
            yield f"{_named(one.content)} and {_named(other.content)} overlap"


def lay(text: Text) -> Laid:
    """Lay a text out as the window does: broken between words, smaller where it is too high."""
    size = text.size
    widths = _lines(text, size)
    limit = float("inf") if text.height is None else text.height
    while len(widths) * LINE * size > limit and size > SMALLEST * text.size:
        size *= SHRINK
        widths = _lines(text, size)
    wide, high = max(widths), len(widths) * LINE * size
    left = text.x - (text.width if text.align == "left" else wide) / 2
    bottom = text.y - {"top": high, "center": high / 2, "bottom": 0.0}[text.anchor]
    blank = (LINE - 1) / 2 * size  # above the first line and below the last
    return Laid(
        content=text.content,
        left=left,
        right=left + wide,
        bottom=bottom + blank,
        top=bottom + high - blank,
        fits=high <= limit + SLACK and wide <= text.width + SLACK,
    )


def _lines(text: Text, size: float) -> list[float]:
    """Return the width of each line of a text."""
    space = _em(" ") * size
    widths = []
    for paragraph in text.content.split("\n"):
        width = 0.0
        for number, word in enumerate(paragraph.split()):
            wide = _em(word) * size
            if number and width + space + wide > text.width:
                widths.append(width)
                width = wide
            else:
                width += wide + (space if number else 0.0)
        widths.append(width)
    return widths


@cache
def _em(word: str) -> float:
    """Return the width of a word, in multiples of its size."""
    font, share = _font()
    font.set_text(word, 0.0)
    return float(font.get_width_height()[0] / 64 / MEASURED_AT * share) if word.strip() else 0.26


@cache
def _font():  # type: ignore[no-untyped-def] # noqa: ANN202 - matplotlib's font, loaded late
    from matplotlib import get_data_path  # noqa: PLC0415
    from matplotlib.ft2font import FT2Font  # noqa: PLC0415

    spec = find_spec("psychopy")
    own = Path(spec.origin if spec and spec.origin else "", "..", "assets/fonts", FILE).resolve()
    share = 1.0 if own.exists() else 1 / WIDER
    font = FT2Font(str(own if own.exists() else Path(get_data_path(), "fonts/ttf/DejaVuSans.ttf")))
    font.set_size(MEASURED_AT, 72)
    return font, share


def _named(content: str) -> str:
    words = " ".join(content.split())
    return f"'{words if len(words) <= MOST_NAMED else words[: MOST_NAMED - 1] + '…'}'"
