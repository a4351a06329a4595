"""`import slipscale`: what it offers, what it imports, and how results are displayed."""

import subprocess
import sys

import pytest

import slipscale
from slipscale.analysis.published.biet2007 import ALLOWED_DATASET
from slipscale.analysis.reporting.files import draw
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock
from slipscale.stimuli.surface import VirtualSurface


@pytest.fixture(scope="module")
def analysis():
    return slipscale.analyse(ALLOWED_DATASET)


def test_importing_the_package_imports_nothing_else():
    code = "import sys; before = set(sys.modules); import slipscale; print(set(sys.modules)-before)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "{'slipscale'}"


def test_the_package_offers_its_api_and_nothing_else():
    assert set(dir(slipscale)) == {"__version__", *slipscale.FUNCTIONS} == set(slipscale.__all__)
    for name in slipscale.FUNCTIONS:
        assert callable(getattr(slipscale, name))
    with pytest.raises(AttributeError, match="no attribute 'analyze'"):
        _ = slipscale.analyze


@pytest.mark.parametrize(
    "call, said",
    [
        (lambda: slipscale.load("nowhere"), "nowhere: no such file or folder"),
        (lambda: slipscale.analyse("gone"), "gone: no such file or folder"),
        (lambda: slipscale.load(3), "load: 3 has the type int; expected a path"),
        (lambda: slipscale.read_study("nowhere"), "study 'nowhere'"),
        (lambda: slipscale.pilot("biet2007", participants=0), "expected 1 or more"),
        (lambda: slipscale.power(participants=0), r"participants is \[0\], expected 1 or more"),
        (lambda: slipscale.power(alpha=5), "alpha is 5, expected a proportion"),
        (lambda: slipscale.reconstruct("nowhere"), "nowhere"),
        (lambda: slipscale.reconstruct("biet2007_table3").sample(0), "number is 0"),
        (lambda: slipscale.open_plate("nowhere"), "unknown backend 'nowhere'"),
    ],
)
def test_wrong_input_is_reported_in_one_sentence(call, said):
    with pytest.raises(UserError, match=said) as error:
        call()
    assert "\n" not in str(error.value)


def test_a_pilot_is_written_into_the_folder_and_its_seed_decides_the_answers(tmp_path):
    first = slipscale.pilot(participants=2, seed=5, folder=tmp_path / "data")
    again = slipscale.pilot(participants=2, seed=5)
    assert first.dataset.folder == tmp_path / "data"
    assert again.dataset.folder.is_dir()
    assert first.estimates.equals(again.estimates)
    assert not first.estimates.equals(slipscale.pilot(participants=2, seed=6).estimates)


def test_power_counts_each_size_once_and_names_the_first_that_suffices():
    found = slipscale.power(participants=(4, 24, 24), studies=50)
    assert [row.condition.participants for row in found.rows] == [4, 24]
    assert found.enough == 24
    assert "24 participants or more reach a power of 0.8" in repr(found)


def test_samples_of_a_published_column_have_its_printed_mean():
    drawn = slipscale.reconstruct("biet2007_table3").sample(20)
    assert drawn["1.2 um"].mean(axis=1).round(2).tolist() == [56.25] * 20


def test_a_plate_is_switched_off_at_the_end():
    clock = VirtualClock()
    with slipscale.open_plate("mock", clock=clock) as plate:
        plate.present(VirtualSurface(level=1.2))
        assert plate.vibration_level() > 1
    clock.sleep(1)  # the plate rings down
    assert plate.vibration_level() < 0.01


def test_an_analysis_is_displayed_in_a_few_lines(analysis):
    lines = repr(analysis).splitlines()
    assert lines[1] == "12 participants, 48 trials, normalised by grand_maximum"
    assert "χ²(3, n = 12) = 34.00" in lines[2]
    assert len(lines) < 8


def test_in_a_notebook_an_analysis_shows_table_3_and_the_figure(analysis):
    shown = analysis._repr_html_()
    for text in ("grand_maximum", "12.75</td>", "<svg", "Perceived slipperiness"):
        assert text in shown
    assert shown.count("<tr>") == 5
    assert "<script" not in shown


def test_a_title_with_markup_is_shown_as_text(analysis, tmp_path):
    table = tmp_path / "<b>.csv"
    analysis.dataset.quantity.columns(analysis.estimates).to_csv(table, index=False)
    shown = slipscale.analyse(table)._repr_html_()
    assert "&lt;b&gt;" in shown
    assert "<b><b>" not in shown


def test_a_task_without_estimates_is_displayed_too():
    found = slipscale.pilot("matching", participants=2, seed=1)
    assert "Matching: 0.8 µm" in repr(found)
    assert "<tr>" not in found._repr_html_()


def test_a_data_set_and_a_study_are_displayed_in_one_line():
    assert repr(slipscale.load(ALLOWED_DATASET)) == (
        "Data set 'biet2007_table3_dataset' (unknown): 12 participants; 48 estimates"
    )
    assert repr(slipscale.read_study("biet2007")).startswith("Study 'biet2007' (")
    assert len(repr(slipscale.read_study("biet2007"))) < 250


def test_a_figure_displays_itself(analysis):
    assert draw(analysis)["fig15"]._repr_svg_().startswith("<svg")
