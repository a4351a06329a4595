import json
import subprocess
import sys
from importlib.resources import files

import pytest

from slipscale.analysis.figures.friction import perception_figure
from slipscale.analysis.published.biet2007 import BY_AMPLITUDE
from slipscale.analysis.reproduction import comparison, film, plate
from slipscale.analysis.reproduction.comparison import Comparison
from slipscale.analysis.reproduction.film import more_than

FILM_AND_PLATE = ("slipscale.analysis.reproduction.film", "slipscale.analysis.reproduction.plate")
ITEMS = {**film.ITEMS, **plate.ITEMS}

# Seconds, not minutes: the whole-plate items (fig11, fig12) are checked on a rougher mesh in
# tests/hardware/plate/test_vibration.py and on this one by `slipscale reproduce`.
QUICK_ITEMS = [name for name in ITEMS if not name.startswith(("fig11", "fig12", "fig9.fe.25"))]


@pytest.fixture(scope="module")
def recorded():
    names = [name for module, name in comparison.SOURCES if module in FILM_AND_PLATE]
    texts = [
        files("slipscale.analysis.reproduction")
        .joinpath("recorded", name)
        .read_text(encoding="utf-8")
        for name in names
    ]
    return {name: value for text in texts for name, value in json.loads(text).items()}


@pytest.mark.parametrize("name", QUICK_ITEMS)
def test_item_is_what_the_repository_records(name, recorded):
    found = Comparison(item=name, outcome=ITEMS[name](), recorded=recorded[name])
    assert not found.drifted
    assert found.outcome.reason
    assert found.outcome.published is not None or found.outcome.agrees is None


def test_every_item_is_recorded_and_nothing_else(recorded):
    assert list(recorded) == list(ITEMS)


def test_recorded_values_of_the_whole_plate_are_near_the_published_ones(recorded):
    assert recorded["fig11.mode80"] == pytest.approx(35.6, rel=0.005)
    assert recorded["fig12.frequency"] == pytest.approx(34.77, rel=0.025)
    assert recorded["fig12.amplitude"] == pytest.approx(3.2, rel=0.015)


@pytest.mark.parametrize(
    "name, agrees",
    [
        ("squeeze_number.30.5kHz", True),
        ("fig3.25kHz", True),
        ("fig5.hr0.6.hvib1.5", True),
        ("fig5.hr1.6.hvib4", True),
        ("fig8.1.5um", True),
        ("fig9.analytic.25kHz", False),
        ("fig13.frequency", True),
        ("fig13.amplitude", True),
    ],
)
def test_item_agrees_with_the_paper_or_honestly_does_not(name, agrees):
    assert ITEMS[name]().agrees is agrees


def test_drift_is_noticed():
    outcome = ITEMS["fig8.1.5um"]()
    assert Comparison(item="fig8.1.5um", outcome=outcome, recorded=outcome.ours * 1.00001).drifted


def test_more_than_is_strict():
    assert more_than(10)("> 10", 10.01)
    assert not more_than(10)("> 10", 10.0)


def test_items_fit_the_framework_s_choice_of_names(monkeypatch):
    sources = [source for source in comparison.SOURCES if source[0] in FILM_AND_PLATE]
    monkeypatch.setattr(comparison, "SOURCES", sources)
    assert len(comparison.choose(["fig9.fe"])) == 8
    assert [c.failed for c in comparison.compare(["fig5", "fig8"])] == [False] * 3


def test_listing_the_items_loads_no_solver():
    code = (
        "import sys; from slipscale.analysis.reproduction import film, plate; "
        "print([m for m in ('scipy', 'skfem', 'matplotlib') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_perception_figure_puts_estimates_over_falling_friction():
    means = {amplitude: float(row.mean) for amplitude, row in BY_AMPLITUDE.items()}
    figure = perception_figure(list(means), list(means.values()))
    axes = figure.axes[0]
    assert axes.xaxis_inverted()
    reynolds, closed = (line.get_xdata() for line in axes.get_lines()[:2])
    assert list(reynolds) == sorted(reynolds, reverse=True)
    assert all(closed[1:] < reynolds[1:])
    (shared,) = axes.collections[-1:]
    assert shared.get_label() == "shared load, not validated"
    assert shared.get_paths()[0].get_extents().x0 < min(closed)  # and reaches 1 at rest
