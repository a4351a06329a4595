"""The options that say what a table's columns mean."""

import pytest

from slipscale import commands

pytestmark = pytest.mark.usefixtures("without_models")

#: Four people's loudness, with noise.
ESTIMATES = {
    "a": (6.1, 31.2, 84.9, 402.0),
    "b": (14.8, 40.7, 230.1, 801.5),
    "c": (17.2, 88.0, 251.3, 1320.2),
    "d": (30.3, 79.6, 420.9, 1214.8),
}
LOUD = "subject,sound_pressure,loudness\n" + "".join(
    f"{who},{level},{estimate}\n"
    for who, estimates in ESTIMATES.items()
    for level, estimate in zip((20, 200, 2000, 20000), estimates, strict=True)
)
OPTIONS = ["--participant", "subject", "--stimulus", "sound_pressure:µPa", "--response", "loudness"]


def test_the_mapping_that_is_written_stands_for_the_options(tmp_path, capsys):
    path = tmp_path / "data.csv"
    path.write_text(LOUD)
    assert commands.main(["analyse", str(path), *OPTIONS, "--map", "--json"]) == 0
    told = capsys.readouterr().out
    assert (tmp_path / "analysis.toml").read_text(encoding="utf-8").count("sound_pressure") == 1
    assert commands.main(["analyse", str(path), "--json"]) == 0
    assert capsys.readouterr().out == told


@pytest.mark.parametrize(
    "options,words",
    [
        (
            ["--stimulus", "sound_pressure", "--response", "loudness"],
            "columns.participant: is missing",
        ),
        ([*OPTIONS[:2], "--levels", "a"], "expected COLUMN=LEVEL with a number"),
        ([*OPTIONS, "--only", "ear"], "--only ear: expected COLUMN=VALUE"),
        (["--map"], "--map: requires options that name the columns"),
        (
            [*OPTIONS, "--sheet", "x", "--reference", "loud"],
            "a reference requires a column of answers",
        ),
    ],
)
def test_options_that_do_not_fit_are_one_sentence(tmp_path, capsys, options, words):
    path = tmp_path / "data.csv"
    path.write_text(LOUD)
    assert commands.main(["analyse", str(path), *options]) == 2
    assert words in capsys.readouterr().err
