"""Reports of data that are not a plate's speak of the data's own quantity only."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from slipscale import commands
from slipscale.analysis.json_form import OurName, form
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.analysis.reporting.files import draw, write_analysis
from slipscale.analysis.reporting.page import render
from slipscale.analysis.tasks.outside import guard
from slipscale.analysis.tasks.outside.short_form import OwnResult, own_analysis
from slipscale.figure_style import svg
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

PRESSURE = Quantity(
    name="sound pressure", unit="µPa", column="sound_pressure_uPa", judged="loudness"
)


class Point:
    """The entry point of an analysis that is called amplitude."""

    name, module = "amplitude", "ours"
    dist = SimpleNamespace(name="ours", version="1")

    def __init__(self, kind):
        self.load = lambda: kind


#: Four people's loudness, with noise.
ESTIMATES = {
    "a": (6.1, 31.2, 84.9, 402.0),
    "b": (14.8, 40.7, 230.1, 801.5),
    "c": (17.2, 88.0, 251.3, 1320.2),
    "d": (30.3, 79.6, 420.9, 1214.8),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    where = tmp_path_factory.mktemp("foreign")
    rows = [
        f"{who},{level},{estimate}"
        for who, estimates in ESTIMATES.items()
        for level, estimate in zip((20, 200, 2000, 20000), estimates, strict=True)
    ]
    path = where / "data.csv"
    path.write_text("\n".join(["subject,sound_pressure,loudness", *rows]))
    options = ["--participant", "subject", "--stimulus", "sound_pressure:µPa"]
    assert commands.main(["analyse", str(path), *options, "--response", "loudness"]) == 0
    return where / "data-slipscale"


def test_neither_plate_nor_film_nor_paper_is_in_the_report_or_a_file(folder):
    """Whatever a writer of the report adds later, too."""
    foreign = re.compile(
        r"plate\b|film|the paper|µm|um_pp|amplitude|slipper|friction|surface|vibration|peak to",
        re.IGNORECASE,
    )
    for name in ("report.html", "inference.json", "results.json", "fig15.svg", "growth.svg"):
        text = (folder / name).read_text(encoding="utf-8")
        text = re.sub(r"<style.*?</style>|template|threshold_friction", "", text, flags=re.DOTALL)
        assert sorted(set(foreign.findall(text))) == [], name
    for path in [*folder.glob("*.csv"), *folder.glob("*.tex")]:
        assert not foreign.search(path.read_text(encoding="utf-8")), path.name


def test_slopes_of_large_levels_are_not_written_as_zero(folder):
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert re.search(r"linear trend of log estimates was 0\.000150 per µPa", text)


def test_yes_and_no_are_told_against_the_stimulus(table_by_hand):
    """Nobody stepped down, and nobody was asked what has been removed."""
    rng = np.random.default_rng(1)
    rows = [
        f"{who},{level},{'yes' if rng.random() < 0.1 + 0.2 * level else 'no'}"
        for who in "abcde"
        for level in (0, 1, 2, 4)
        for _ in range(4)
    ]
    columns = {"participant": "who", "stimulus": "contrast", "answer": "seen"}
    found = analyse(
        load(
            table_by_hand("\n".join(["who,contrast,seen", *rows])),
            parse_mapping({"columns": columns}, "x"),
        )
    )
    svgs = {"difference": svg(draw(found)["difference"])}
    text = re.sub(r"<style.*?</style>", "", render(found, svgs, {}), flags=re.DOTALL)
    words = re.compile(
        r"removed|step|descending|µm|amplitude|slipper|surface|peak to|fell|feel| [,;)]",
        re.IGNORECASE,
    )
    assert sorted(set(words.findall(re.sub(r"<[^>]*>", "", text)))) == []
    assert "How does “yes” depend on contrast?" in text
    assert re.search(
        r"The probability of “yes” \w+.* on contrast: the slope of the log odds was [1-9]", text
    )


def test_columns_carry_the_quantity(folder):
    table = pd.read_csv(folder / "table3.csv")
    assert list(table["sound_pressure_uPa"]) == [20, 200, 2000, 20000]
    pairs = pd.read_csv(folder / "pairwise.csv")
    assert list(pairs.columns[:2]) == ["from_sound_pressure_uPa", "to_sound_pressure_uPa"]
    results = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    assert results["paper"] == []


@pytest.fixture(scope="module")
def named_like_ours(tmp_path_factory):
    """Data whose file, groups, participants' columns and outside analysis use our words."""
    where = tmp_path_factory.mktemp("named")
    path = where / "amplitude_pilot.csv"
    rows = [
        f"{who}{number},{level},{estimate * (1 + 0.07 * number):.3f},{group}"
        for number, group in enumerate(("surface clinic", "um_pp ward"))
        for who, estimates in ESTIMATES.items()
        for level, estimate in zip((20, 200, 2000, 20000), estimates, strict=True)
    ]
    path.write_text("\n".join(["subject,sound_pressure,loudness,amplitude_group", *rows]))
    columns = {
        "participant": "subject",
        "stimulus": "sound_pressure",
        "response": "loudness",
        "group": "amplitude_group",
    }
    table = {"columns": columns, "stimulus": {"unit": "µPa"}}
    result = OwnResult(
        sentences=("The amplitude of a surface is 3 µm.",),
        numbers={"friction": 0.4, "amplitude_um_pp": 3.0},
        table=pd.DataFrame({"amplitude_um_pp": [3.0]}),
    )
    kind = own_analysis("amplitude", title="Friction of a surface", run=lambda _: result)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(guard, "installed", lambda _: {"amplitude": Point(kind)})
        found = analyse(load(path, parse_mapping(table, "x")))
    write_analysis(found, where / "out")
    return where / "out"


def test_a_file_keeps_its_name(named_like_ours):
    results = json.loads((named_like_ours / "results.json").read_text(encoding="utf-8"))
    assert list(results["files"]) == ["amplitude_pilot.csv"]
    assert results["dataset"] == "amplitude_pilot"


def test_a_group_keeps_its_name(named_like_ours):
    inference = json.loads((named_like_ours / "inference.json").read_text(encoding="utf-8"))
    assert list(inference["groups"]["n"]) == ["surface clinic", "um_pp ward"]
    report = (named_like_ours / "report.html").read_text(encoding="utf-8")
    assert "surface clinic (n = 4), um_pp ward (n = 4)" in report.replace("\N{NO-BREAK SPACE}", " ")
    assert "stimulus clinic" not in report


def test_an_outside_analysis_keeps_its_words_numbers_and_columns(named_like_ours):
    inference = json.loads((named_like_ours / "inference.json").read_text(encoding="utf-8"))
    outside = inference["own_amplitude"]
    assert outside["numbers"] == {"friction": 0.4, "amplitude_um_pp": 3.0}
    assert outside["sentences"] == ["The amplitude of a surface is 3 µm."]
    assert list(pd.read_csv(named_like_ours / "own_amplitude.csv")) == ["amplitude_um_pp"]
    report = (named_like_ours / "report.html").read_text(encoding="utf-8")
    assert "The amplitude of a surface is 3 µm." in report


def test_our_keys_carry_the_quantity_and_film_is_left_out(named_like_ours):
    inference = json.loads((named_like_ours / "inference.json").read_text(encoding="utf-8"))
    (first, *_) = inference["pairwise"]
    assert (first["from_sound_pressure_uPa"], first["to_sound_pressure_uPa"]) == (20, 200)
    assert inference["rm_anova"]["levels_sound_pressure_uPa"] == [20, 200, 2000, 20000]
    assert inference["linear_trend"]["unit"] == "natural logarithm per sound_pressure_uPa"
    assert list(inference["growth"]) == ["stimulus", "individual"]


def test_a_plain_mapping_keeps_its_keys():
    keys = {"um_pp": OurName("per unit_of_level"), "amplitude": "amplitude of user"}
    assert form(keys, PRESSURE.named) == {
        "um_pp": "per sound_pressure_uPa",
        "amplitude": "amplitude of user",
    }


def test_sentences_tables_and_axes_name_the_quantity(folder):
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert "between levels of sound pressure, F(" in text.replace("\N{NO-BREAK SPACE}", " ")
    assert "at 20 µPa" in text
    assert "Levels of sound pressure" in text
    assert "Loudness against sound pressure." in text
    figure = (folder / "fig15.svg").read_text(encoding="utf-8")
    assert "Sound pressure (µPa)" in figure
    assert "Loudness" in figure
    latex = (folder / "pairwise.tex").read_text(encoding="utf-8")
    assert r"From ($\mu$Pa) & To ($\mu$Pa)" in latex
    assert r"Sound pressure ($\mu$Pa)" in (folder / "table3.tex").read_text(encoding="utf-8")


def test_a_quantity_without_a_unit_leaves_no_empty_parentheses():
    contrast = Quantity(name="contrast", column="contrast", judged="visibility")
    assert contrast.axis == contrast.headed(contrast.title) == "Contrast"
    assert contrast.with_convention("1, 2") == "1, 2"
    assert contrast.per == "per unit of contrast"


def test_a_quantity_that_is_called_like_ours_is_named_once():
    metres = Quantity(name="amplitude", unit="m", column="amplitude_um_pp_m", judged="force")
    assert metres.named("from_level") == "from_amplitude_um_pp_m"
    assert metres.named("level") == "amplitude_um_pp_m"
    assert PLATE_AMPLITUDE.named("level") == "amplitude_um_pp"
