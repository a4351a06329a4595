"""Draw a scene as SVG: the participant's screen without a window.

`slipscale.experiments.participants.psychopy_window.layout` positions the text. Each line is as wide
as in the window font, even if the browser uses another font.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from itertools import chain, repeat
from typing import assert_never

from slipscale.experiments.participants.psychopy_window.layout import LINE, lay
from slipscale.experiments.steps.screens.scene import (
    COLOURS,
    DARK,
    DESIGN_WIDTH,
    FONT,
    Area,
    Arrow,
    Box,
    Colour,
    Disc,
    Item,
    Scene,
    Text,
    Theme,
)

# Distance from the top of a line of Noto Sans to its baseline, relative to the font size.
BASELINE = 1.069


def drawn(
    scene: Scene,
    *,
    width_px: int,
    height_px: int,
    name: str,
    keys: Sequence[Sequence[str]] = (),
    theme: Theme = DARK,
) -> str:
    """Return a scene as SVG, in the proportions of a screen of ``width_px`` by ``height_px``.

    Parameters
    ----------
    name : str
        Label of the drawing for screen readers.
    keys : sequence
        Keys of each item's texts; the SVG elements of the item have the first as attribute.
    """
    unit = min(height_px, width_px / DESIGN_WIDTH)
    parts = "".join(
        _keyed("".join(_parts(item, theme)), at)
        for item, at in zip(scene, chain(keys, repeat(())), strict=False)
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width_px} {height_px}" role="img" '
        f'aria-label="{escape(name)}" font-family="{FONT}, sans-serif">'
        f'<rect width="{width_px}" height="{height_px}" fill="{_rgb("ground", theme)}"/>'
        f'<g transform="translate({width_px / 2:g} {height_px / 2:g}) scale({unit:g})">'
        f"{parts}</g></svg>"
    )


def _keyed(part: str, keys: Sequence[str]) -> str:
    return f'<g data-text="{escape(keys[0])}">{part}</g>' if keys else part


def _parts(item: Item, theme: Theme) -> Iterator[str]:
    """Yield the SVG elements of an item; y points down in SVG."""
    match item:
        case Text():
            yield from _letters(item, theme)
        case Box():
            yield _box(item.x, item.y, item.width, item.height, _rgb(item.colour, theme))
        case Disc():
            yield (
                f'<circle cx="{item.x:.5f}" cy="{-item.y:.5f}" r="{item.diameter / 2:.5f}" '
                f'fill="{_rgb(item.colour, theme)}"/>'
            )
        case Arrow():
            half = item.size / 2 if item.up else -item.size / 2
            stem, head = 0.24 * abs(half), 0.8 * abs(half)
            right = [(stem, half), (stem, 0.0), (head, 0.0), (0.0, -half)]
            outline = [*right, *((-x, y) for x, y in reversed(right[:-1]))]
            points = " ".join(f"{item.x + x:.5f},{y - item.y:.5f}" for x, y in outline)
            yield f'<polygon points="{points}" fill="{_rgb(item.colour, theme)}"/>'
        case Area():
            pass
        case _:
            assert_never(item)


def _letters(text: Text, theme: Theme) -> Iterator[str]:
    if not text.content.strip():
        return
    laid = lay(text)
    weight = ' font-weight="700"' if text.bold else ""
    blank = (LINE - 1) / 2 * laid.size
    for number, (line, width) in enumerate(zip(laid.lines, laid.widths, strict=True)):
        left = laid.left if text.align == "left" else text.x - width / 2
        y = -laid.top - blank + (number * LINE + BASELINE) * laid.size
        if line:
            yield (
                f'<text x="{left:.5f}" y="{y:.5f}" font-size="{laid.size:.5f}"{weight} '
                f'textLength="{width:.5f}" lengthAdjust="spacingAndGlyphs" '
                f'fill="{_rgb(text.colour, theme)}">{escape(line)}</text>'
            )
    if text.caret:
        yield _box(laid.right + 0.012, text.y, 0.006, text.size, _rgb("accent", theme))


def _box(x: float, y: float, width: float, height: float, fill: str) -> str:
    return (
        f'<rect x="{x - width / 2:.5f}" y="{-y - height / 2:.5f}" width="{width:.5f}" '
        f'height="{height:.5f}" fill="{fill}"/>'
    )


def _rgb(colour: Colour, theme: Theme) -> str:
    return "#{:02x}{:02x}{:02x}".format(*COLOURS[theme][colour])
