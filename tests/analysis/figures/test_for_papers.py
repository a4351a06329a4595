"""Figures for papers: their width, their text, and what is in their files."""

import re
import struct

import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text

from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reporting.files import FOR_PAPER
from slipscale.analysis.reporting.notebook import DisplayedAnalysis
from slipscale.analysis.tasks.estimation.figures import fig15, growth_means, residuals
from slipscale.commands import main
from slipscale.faults import UserError
from slipscale.figure_style import canvas, lay_out, styled
from slipscale.figure_style.paper import STYLES, PaperStyle, drawn_for, paper_style

LOGS = pd.DataFrame(
    np.random.default_rng(1).normal([1, 2, 3, 4], 0.2, (8, 4)), columns=[0.0, 0.5, 1.2, 2.3]
)
DRAWN = {
    "fig15": lambda: fig15(
        np.exp(LOGS), unit="% of the declared top of the scale", paper=True, top=None
    ),
    "growth_means": lambda: growth_means(LOGS, unit="% of the declared top of the scale"),
    "residuals": lambda: residuals(LOGS),
}


@styled
def wordy():
    figure, axes = canvas(size=(6.8, 3))
    axes.plot([1, 2], label="a legend that is wide for a narrow figure")
    axes.set_title("A title that is too long for a column of a journal, and is 30 pt", fontsize=30)
    axes.set_ylabel("A label that is much too long for the height of the axes of this figure")
    axes.annotate("small", (0, 1), fontsize=4)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center")
    return figure


@pytest.mark.parametrize("draw", [*DRAWN.values(), wordy], ids=[*DRAWN, "wordy"])
@pytest.mark.parametrize("width_cm", [8.0, 8.9, 18.2])
def test_all_text_has_7_to_9_points_and_is_inside_the_figure(draw, width_cm):
    with drawn_for(PaperStyle(width_cm=width_cm)):
        figure = draw()
        lay_out(figure)
    assert figure.get_figwidth() == pytest.approx(width_cm / 2.54)
    texts = [each for each in figure.findobj(Text) if each.get_text()]
    assert min(text.get_fontsize() for text in texts) >= 7
    assert max(text.get_fontsize() for text in texts) <= 9
    width, height = figure.bbox.size
    named = [
        *figure.legends,
        *(axis.label for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)),
        *(axes._left_title for axes in figure.axes if axes.get_title("left")),
    ]
    for text in named:
        box = text.get_window_extent()
        assert box.x0 > -1, text
        assert box.y0 > -1, text
        assert box.x1 < width + 1, text
        assert box.y1 < height + 1, text


def test_a_style_lasts_as_long_as_its_block():
    with drawn_for(STYLES["apa"]):
        assert not fig15(np.exp(LOGS)).axes[0].yaxis.get_gridlines()[0].get_visible()
    later = fig15(np.exp(LOGS))
    assert later.axes[0].yaxis.get_gridlines()[0].get_visible()
    assert later.get_figwidth() == 5.6


@pytest.mark.parametrize("width", ["8.9cm", "89 mm", "3,504in", "8.90 cm"])
def test_widths_have_units(width):
    assert paper_style(width).width_cm == pytest.approx(8.9, abs=0.001)


@pytest.mark.parametrize(
    "given, told",
    [
        ({"width": "8.9"}, "expected a number with cm, mm or in"),
        ({"width": "89cm"}, "89 cm, expected 8 to 30 cm"),
        ({"width": "2cm"}, "2 cm, expected 8 to 30 cm"),
        ({"style": "nature"}, "'nature', expected one of ieee, apa"),
    ],
)
def test_a_width_or_style_that_cannot_be_used_is_refused(given, told):
    with pytest.raises(UserError, match=told):
        paper_style(**given)


def test_neither_width_nor_style_is_a_screen_and_a_width_replaces_that_of_a_style():
    assert paper_style() is None
    assert paper_style("10cm", "apa") == PaperStyle(width_cm=10, grid=False)


@pytest.mark.usefixtures("without_models")
def test_the_command_writes_text_as_text_and_600_dots_per_inch(dataset, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "slipscale.analysis.reporting.files.draw", lambda _: {"fig15": DRAWN["fig15"]()}
    )
    out = tmp_path / "out"
    words = ["analyse", str(dataset()), "--out", str(out), "--width", "8.9cm"]
    assert main(words) == 0
    assert sorted(path.name for path in (out / FOR_PAPER).iterdir()) == [
        "fig15.pdf",
        "fig15.png",
        "fig15.svg",
    ]
    svg = (out / FOR_PAPER / "fig15.svg").read_text(encoding="utf-8")
    assert re.search(r"<text[^>]*>Vibration amplitude", svg)
    assert float(re.search(r'width="([\d.]+)pt"', svg)[1]) == pytest.approx(8.9 / 2.54 * 72)
    head = (out / FOR_PAPER / "fig15.png").read_bytes()[16:20]
    assert struct.unpack(">I", head)[0] == int(8.9 / 2.54 * 600)
    pdf = (out / FOR_PAPER / "fig15.pdf").read_bytes()
    assert b"/TrueType" in pdf or b"/Type0" in pdf
    assert 'width="403' in (out / "fig15.svg").read_text(encoding="utf-8")


@pytest.mark.usefixtures("without_models")
def test_python_draws_the_same_figures(dataset, tmp_path):
    found = analyse(dataset())
    fields = {name: getattr(found, name) for name in found.__dataclass_fields__}
    shown = DisplayedAnalysis(**fields)
    assert shown.plot("fig15", width="8.9cm").get_figwidth() == pytest.approx(8.9 / 2.54)
    assert shown.plot("fig15", style="apa").get_figwidth() == pytest.approx(3.25, abs=0.01)
    assert shown.plot("fig15").get_figwidth() == 5.6
    shown.save(tmp_path / "out", style="ieee")
    assert (tmp_path / "out" / FOR_PAPER / "fig15.pdf").exists()
