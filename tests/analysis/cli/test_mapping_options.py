"""The options that say what a table's columns mean."""

import json
import re
from argparse import ArgumentParser
from io import StringIO

import pandas as pd
import pytest

from slipscale import commands
from slipscale.analysis.cli.analyse import add_analyse
from slipscale.analysis.cli.mapping_arguments import mapping_from
from slipscale.analysis.load import load
from slipscale.faults import UserError

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


def test_columns_that_only_select_rows_may_be_repeated(tmp_path, capsys):
    path = tmp_path / "data.csv"
    path.write_text(LOUD)
    kept = [f"--only=subject={who}" for who in "acd"]
    assert commands.main(["analyse", str(path), *OPTIONS, *kept, "--only=subject=a", "--json"]) == 0
    assert {row["n"] for row in json.loads(capsys.readouterr().out)} == {3}


def levels(*names):
    given = ["--participant", "who", "--stimulus", "pressure:Pa", "--levels", *names]
    parser = ArgumentParser()
    add_analyse(parser)
    return mapping_from(parser.parse_args(["data.csv", *given])).levels


def test_levels_are_read_from_the_ends_of_names():
    names = ["p0,5", "p1", "p2.25", "p_.75", "L_20", "level05", "x,5=0.4", "p-20=30"]
    numbers = [0.5, 1, 2.25, 0.75, 20, 5, 0.4, 30]
    assert list(levels(*names).values()) == numbers


@pytest.mark.parametrize(
    "name", ["x.5", "x,5", "p-20", "a1e-3", "a1e3", "p1.2.3", "p0_5", "p1,000", "p1,2,3", "p+4"]
)
def test_a_level_that_could_be_read_in_two_ways_is_refused(name):
    """The last digits were the level: 5, 3, 20, 3."""
    with pytest.raises(UserError, match=f"--levels {re.escape(name)}: .* several ways"):
        levels(name)


def test_one_column_has_one_level():
    with pytest.raises(UserError, match="--levels p1=3: column p1 is given twice"):
        levels("p1=1", "p1=3")
    with pytest.raises(UserError, match="--levels is given twice"):
        levels("p1=1", "--levels", "p2=3")


OWN = "participant_id;amplitude_um_pp;estimate;scale_top\n" + "".join(
    f"{who};{level};{estimate:.0f};10000\n"
    for who, estimates in ESTIMATES.items()
    for level, estimate in zip(("1,125", "2,250"), estimates, strict=False)
)


@pytest.mark.parametrize("kind", ["csv", "xlsx"])
def test_a_table_with_slipscales_columns_has_a_decimal_mark_a_sheet_and_rows(
    tmp_path, capsys, kind
):
    path, options = tmp_path / f"data.{kind}", ["--decimal", ","]
    if kind == "csv":
        path.write_text(OWN)
    else:
        options += ["--sheet", "data"]
        with pd.ExcelWriter(path) as book:
            pd.read_csv(StringIO(OWN), sep=";").to_excel(book, sheet_name="data", index=False)
            pd.DataFrame({"a": [1, 2]}).to_excel(book, sheet_name="notes", index=False)
    assert commands.main(["analyse", str(path)]) == 2
    options += ["--only", "participant_id=a", "--only", "participant_id=b", "--map", "--json"]
    assert commands.main(["analyse", str(path), *options]) == 0
    told = capsys.readouterr().out
    found = [(row["amplitude_um_pp"], row["n"]) for row in json.loads(told)]
    assert found == [(1.125, 2), (2.25, 2)]
    # The top of the scale is read, although no option names its column.
    assert load(path).estimates["scale_top"].tolist() == [10000] * 4
    assert commands.main(["analyse", str(path), "--json"]) == 0
    assert capsys.readouterr().out == told
    with pytest.raises(UserError, match="for a folder, expected --participant"):
        load(tmp_path)


@pytest.mark.parametrize(
    "options,words",
    [
        (
            ["--participant", "subject", "--stimulus", "sound_pressure"],
            "needs --stimulus and --response",
        ),
        ([*OPTIONS[:2], "--levels", "a"], "expected COLUMN=LEVEL with a number"),
        ([*OPTIONS, "--only", "ear"], "--only ear: expected COLUMN=VALUE"),
        (["--map"], "--map: requires options that name the columns"),
        (
            [*OPTIONS, "--sheet", "x", "--reference", "loud"],
            "estimates needs --stimulus and --response",
        ),
    ],
)
def test_options_that_do_not_fit_are_one_sentence(tmp_path, capsys, options, words):
    path = tmp_path / "data.csv"
    path.write_text(LOUD)
    assert commands.main(["analyse", str(path), *options]) == 2
    assert words in capsys.readouterr().err
