"""A screen's drawing has the places and widths that its layout computes."""

import re
from itertools import pairwise
from xml.etree import ElementTree as ET

import pytest

from slipscale.experiments.participants.psychopy_window.drawing import drawn
from slipscale.experiments.participants.psychopy_window.layout import lay
from slipscale.experiments.steps.screens.scene import Area, Arrow, Box, Text


def shapes(scene, width_px=1920, height_px=1080):
    # Our own drawing, not a stranger's file.
    root = ET.fromstring(drawn(scene, width_px=width_px, height_px=height_px, name="a <screen>"))  # noqa: S314
    ground, group = root
    return root, ground, group


def test_a_text_is_as_wide_as_its_layout_and_its_letters_stand_on_their_line():
    text = Text(content="How slippery <now>?", y=0.2, size=0.06)
    _, _, [line] = shapes((text,))
    laid = lay(text)
    assert line.text == "How slippery <now>?"
    assert float(line.get("textLength")) == pytest.approx(laid.right - laid.left, abs=1e-5)
    assert float(line.get("x")) == pytest.approx(laid.left, abs=1e-5)
    # Half of a lower-case letter above its line: the text's middle, which lies at y = 0.2.
    assert float(line.get("y")) == pytest.approx(-0.2 + 0.0233, abs=2e-3)


def test_every_line_of_a_paragraph_is_drawn_below_the_one_before():
    _, _, lines = shapes((Text(content="word " * 60, y=0.0, size=0.042, width=1.15),))
    heights = [float(line.get("y")) for line in lines]
    steps = [round(after - before, 4) for before, after in pairwise(heights)]
    assert set(steps) == {round(1.362 * 0.042, 4)}
    assert " ".join(line.text for line in lines) == ("word " * 60).strip()


def test_boxes_arrows_and_carets_are_drawn_and_areas_are_not():
    caret = Text(content="5", y=0.0, caret=True)
    arrow = Arrow(x=0.1, y=0.3, size=0.2, up=True)
    box = Box(x=0.1, y=0.2, width=0.4, height=0.1, colour="accent")
    _, _, group = shapes((box, arrow, caret, Area(x=0, y=0, width=1, height=1, presses="a")))
    rectangle, polygon, letters, bar = group
    assert [rectangle.get(key) for key in ("x", "y", "fill")] == ["-0.10000", "-0.25000", "#56b4e9"]
    tip = min(polygon.get("points").split(), key=lambda each: float(each.split(",")[1]))
    assert tip == "0.10000,-0.40000"
    assert (letters.tag, bar.tag) == tuple(
        "{http://www.w3.org/2000/svg}" + t for t in ("text", "rect")
    )
    assert polygon.get("points").count(" ") == 6


@pytest.mark.parametrize(
    "width_px, height_px, unit", [(1920, 1080, 1080), (1280, 1024, 1280 / 1.34)]
)
def test_a_narrow_screen_scales_its_scenes_down_as_the_window_does(width_px, height_px, unit):
    root, ground, group = shapes((), width_px, height_px)
    assert root.get("viewBox") == f"0 0 {width_px} {height_px}"
    assert (root.get("aria-label"), ground.get("fill")) == ("a <screen>", "#26282b")
    scale = float(re.search(r"scale\(([0-9.]+)\)", group.get("transform"))[1])
    assert scale == pytest.approx(unit, rel=1e-5)
