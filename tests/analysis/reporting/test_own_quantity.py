"""Reports of data that are not a plate's speak of the data's own quantity only."""

import json
import re

import numpy as np
import pandas as pd
import pytest

from slipscale import commands
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.mapping import parse_mapping
from slipscale.analysis.reading.own_words import in_own_words, own_name
from slipscale.analysis.reading.quantity import PLATE_AMPLITUDE, Quantity
from slipscale.analysis.reporting.files import draw
from slipscale.analysis.reporting.page import render
from slipscale.figure_style import svg

PRESSURE = Quantity(
    name="sound pressure", unit="µPa", column="sound_pressure_uPa", judged="loudness"
)
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
        text = re.sub(r"<style.*?</style>|template", "", text, flags=re.DOTALL)
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
    assert re.search(r"“Yes” \w+.* on contrast, log odds [1-9]", text)


def test_columns_carry_the_quantity(folder):
    table = pd.read_csv(folder / "table3.csv")
    assert list(table["sound_pressure_uPa"]) == [20, 200, 2000, 20000]
    pairs = pd.read_csv(folder / "pairwise.csv")
    assert list(pairs.columns[:2]) == ["from_sound_pressure_uPa", "to_sound_pressure_uPa"]
    results = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    assert results["paper"] == []


@pytest.mark.parametrize(
    "ours,theirs",
    [
        ("between amplitudes, F(3, 33)", "between levels of sound pressure, F(3, 33)"),
        ("0.5 and 1.2 µm", "0.5 and 1.2 µPa"),
        ("1.2 per µm (peak to peak)", "1.2 per µPa"),
        ("Amplitude", "Sound pressure"),
        ("Perceived slipperiness", "Loudness"),
    ],
)
def test_phrases(ours, theirs):
    assert in_own_words(ours, PRESSURE) == theirs
    assert in_own_words(ours, PLATE_AMPLITUDE) == ours


def test_a_quantity_that_is_called_like_ours_is_named_once():
    metres = Quantity(name="amplitude", unit="m", column="amplitude_um_pp_m", judged="force")
    assert own_name("from_um_pp", metres) == "from_amplitude_um_pp_m"
    assert own_name("amplitude_um_pp", metres) == "amplitude_um_pp_m"
    assert own_name("amplitude_um_pp", PLATE_AMPLITUDE) == "amplitude_um_pp"
