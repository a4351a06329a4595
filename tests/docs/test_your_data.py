"""The layouts in the guide "Your own data" are read with the options that the guide gives."""

import re
import shlex
from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from slipscale import commands

GUIDE = Path(__file__).parents[2] / "docs" / "how-to" / "your-data.md"
#: Options that the row with a factor refers to.
OFFSETS = "--participant who --stimulus offset:mm --answer said --yes right"
LEVELS, PEOPLE, ITEMS = (1, 2, 4, 8), tuple("abcdef"), ("cork", "felt", "glass", "silk", "steel")


def layouts():
    """Yield each row of the guide's table: layout, example, options, first line of the result."""
    table = GUIDE.read_text(encoding="utf-8").partition("| your table |")[2].partition("\n\n")[0]
    for line in table.splitlines()[2:]:
        layout, example, options, first = (cell.strip() for cell in line.strip("|").split(" | "))
        yield pytest.param(layout, (codes(example), codes(options)[0], first), id=layout)


def codes(text):
    return re.findall(r"`([^`]+)`", text)


def trials(levels=LEVELS):
    """Return ten trials per person and level, with their place and whether the answer is right."""
    rows = [(who, level) for who in PEOPLE for level in levels for _ in range(10)]
    frame = pd.DataFrame(rows, columns=["who", "level"])
    place = frame.groupby(["who", "level"]).cumcount()
    chance = 0.5 + 0.5 * frame["level"] / (frame["level"] + 2 + frame["who"].map(PEOPLE.index) / 4)
    return frame.assign(place=place, good=place < (10 * chance).round())


def estimates():
    frame = trials()
    return frame.assign(loud=4 * frame["level"] + frame["who"].map(PEOPLE.index))


def answers():
    frame = trials()
    wrong = np.where(frame["place"] == 9, "aborted", "late")
    outcome, felt = np.where(frame["good"], "hit", wrong), np.where(frame["good"], "yes", "no")
    return frame.assign(felt=felt, outcome=outcome, correct=frame["good"].astype(int))


def offsets():
    frame = trials(levels=(-2, -1, 0, 1, 2))
    right = [[1, 3, 4, 7, 9][level + 2] for level in frame["level"]]
    said = np.where(frame["place"] < right, "right", "left")
    frame = frame.assign(offset=frame["level"], said=said, cond="still")
    return pd.concat([frame, frame.assign(cond="moving", offset=2 * frame["offset"])])


def counts():
    right = trials().groupby(["who", "level"])["good"].sum().reset_index(name="k")
    return right.assign(right=right["k"], wrong=10 - right["k"], pc=10 * right["k"], n=10)


def wide(index, columns):
    frame = counts().pivot_table("k", index=index, columns=columns)
    return (frame.add_prefix("L") if columns == "level" else frame).astype(int).reset_index()


def events():
    shown = trials().assign(trial_type="stimulus", rating=np.nan)
    said = shown.assign(trial_type="rate", rating=9.0 * shown["level"], level=np.nan)
    return pd.concat([shown, said]).sort_index(kind="stable")


def pairs(first, second):
    rows = [(who, x, y) for who in PEOPLE for x in ITEMS for y in ITEMS if x < y]
    frame = pd.DataFrame(rows, columns=["who", first, second])
    chosen = frame[first].where(frame["who"] < "e", frame[second])
    apart = frame[second].map(ITEMS.index) - frame[first].map(ITEMS.index)
    return frame.assign(chosen=chosen, apart=3 + apart**2)


def wins():
    items = ITEMS[1:4]
    frame = pd.DataFrame([[0, 5, 3], [7, 0, 6], [9, 6, 0]], index=items, columns=items)
    return frame.reset_index(names="")


def similarities():
    names = list("ABCDE")
    apart = np.abs(np.subtract.outer(np.arange(5.0), np.arange(5.0)))
    return pd.DataFrame(np.exp(-apart / 2), index=names, columns=names).reset_index(names="")


def quadruples():
    frame = pd.DataFrame(list(combinations(range(1, 8), 4)) * 3, columns=["S1", "S2", "S3", "S4"])
    squares = frame**2
    larger = squares["S4"] - squares["S3"] > squares["S2"] - squares["S1"]
    frame = frame.assign(resp=larger.astype(int))
    frame.loc[::9, "resp"] = 1 - frame.loc[::9, "resp"]
    return frame


TABLES = {
    "one estimate per row": estimates,
    "one answer per row": answers,
    "other codes": answers,
    "offsets to both sides of a standard": offsets,
    "answers in several conditions": offsets,
    "counts": counts,
    "correct and wrong": counts,
    "per cent": counts,
    "one row per person": lambda: wide("who", "level"),
    "people in columns": lambda: wide("level", "who"),
    "one file per person": answers,
    "stimulus and answer in separate rows": events,
    "choices in pairs": lambda: pairs("left", "right"),
    "wins": wins,
    "similarities": similarities,
    "rated pairs": lambda: pairs("a", "b"),
    "differences of pairs": quadruples,
}


@pytest.mark.parametrize("layout, row", list(layouts()))
def test_a_layout_of_the_guide_gives_its_first_line(layout, row, tmp_path, capsys, monkeypatch):
    example, options, first = row
    frame, header = TABLES[layout](), example[0].split(",")
    place, words = tmp_path / "table.csv", shlex.split(options)
    if words[:2] == ["slipscale", "analyse"]:  # a folder
        place, words = tmp_path, words[3:]
        for name, (_, own) in zip("123456", frame.groupby("who"), strict=True):
            own[["level", "correct"]].to_csv(place / f"s{name}_2026-03-01.csv", index=False)
    else:
        whole = header[0] in ("", "level") or header[1].startswith("L")
        frame[frame.columns if whole else header].to_csv(place, index=False)
    if words[0] == "--factor":
        words = [*OFFSETS.split(), *words]
    monkeypatch.setenv("COLUMNS", "300")
    monkeypatch.setattr(
        "slipscale.analysis.reporting.files.write_analysis", lambda *_, **__: "report.html"
    )
    assert commands.main(["analyse", str(place), *words]) == 0
    said = [line.rstrip() for line in capsys.readouterr().out.splitlines() if line.strip()]
    assert said[0].startswith(first)
