"""The layouts in the guide "Your own data" are read with the options that the guide gives."""

import re
import shlex
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
        yield pytest.param(example, options, first.strip("`"), id=layout)


def codes(text):
    return re.findall(r"`([^`]+)`", text)


def trials(*names, repeated=10, levels=LEVELS):
    """Return a table of people and levels, and its probability of a correct answer."""
    rows = [(who, level) for who in PEOPLE for level in levels for _ in range(repeated)]
    frame = pd.DataFrame(rows, columns=["who", "level"])
    place = frame.groupby(["who", "level"]).cumcount()
    chance = 0.5 + 0.5 * frame["level"] / (frame["level"] + 2 + frame["who"].map(PEOPLE.index) / 4)
    return frame, place < (repeated * chance).round()


def written(example, folder):
    """Write data with the columns of an example; return the name of the table or folder."""
    header = example[0].split(",")
    frame, good = trials()
    counts = good.groupby([frame["who"], frame["level"]], sort=False).sum().reset_index(name="k")
    if header[0].endswith(".csv"):
        for who, own in frame.assign(correct=good.astype(int)).groupby("who"):
            name = folder / f"s{PEOPLE.index(who)}_2026-03-01.csv"
            own.drop(columns="who").to_csv(name, index=False)
        return str(folder)
    if "chosen" in header or "apart" in header:
        pairs = [(who, x, y) for who in PEOPLE for x in ITEMS for y in ITEMS if x < y]
        frame = pd.DataFrame(pairs, columns=header[:3])
        later = frame["who"].isin(["a", "b", "c", "d"])
        frame["chosen"] = np.where(later, frame[header[1]], frame[header[2]])
        frame["apart"] = (
            3 + (frame[header[2]].map(ITEMS.index) - frame[header[1]].map(ITEMS.index)) ** 2
        )
        frame = frame[header]
    elif "loud" in header:
        frame = frame.assign(loud=4 * frame["level"] + frame["who"].map(PEOPLE.index))
    elif "offset" in header:
        frame, _ = trials(levels=(-2, -1, 0, 1, 2))
        place = frame.groupby(["who", "level"]).cumcount()
        said = np.where(
            place < [[1, 3, 4, 7, 9][level + 2] for level in frame["level"]], "right", "left"
        )
        frame = frame.assign(offset=frame["level"], said=said, cond="still")
        frame = pd.concat([frame, frame.assign(cond="moving", offset=2 * frame["offset"])])
        frame = frame[header]
    elif "felt" in header and "who" in header:
        frame = frame.assign(felt=np.where(good, "yes", "no"))
    elif "outcome" in header:
        place = frame.groupby(["who", "level"]).cumcount()
        wrong = np.where(place == 9, "aborted", "late")
        frame = frame.assign(outcome=np.where(good, "hit", wrong))
    elif {"k", "right", "pc"} & set(header):
        frame = counts.assign(right=counts["k"], wrong=10 - counts["k"], pc=10 * counts["k"], n=10)
        frame = frame[header]
    elif header[0] == "who" and header[1].startswith("L"):
        frame = counts.pivot(index="who", columns="level", values="k").add_prefix("L")
        frame = frame.reset_index()
    elif header[0] == "level":
        frame = counts.pivot(index="level", columns="who", values="k").reset_index()
    elif header[0] == "trial_type":
        shown = frame.assign(trial_type="stimulus", rating=np.nan)
        said = shown.assign(trial_type="rate", rating=9.0 * frame["level"], level=np.nan)
        frame = pd.concat([shown, said]).sort_index(kind="stable")
    elif header[0] == "" and "felt" in header:
        frame = pd.DataFrame(
            [[0, 5, 3], [7, 0, 6], [9, 6, 0]], index=ITEMS[1:4], columns=ITEMS[1:4]
        ).reset_index(names="")
    elif header[0] == "":
        close = np.exp(-np.abs(np.subtract.outer(np.arange(5.0), np.arange(5.0))) / 2)
        names = list("ABCDE")
        frame = pd.DataFrame(close, index=names, columns=names).reset_index(names="")
    else:
        four = [
            (a, b, c, d)
            for a in range(1, 8)
            for b in range(a + 1, 8)
            for c in range(b + 1, 8)
            for d in range(c + 1, 8)
        ]
        frame = pd.DataFrame(four, columns=header[:4])
        frame = pd.concat([frame] * 3, ignore_index=True)
        larger = frame["S4"] ** 2 - frame["S3"] ** 2 > frame["S2"] ** 2 - frame["S1"] ** 2
        frame["resp"] = larger.astype(int)
        frame.loc[::9, "resp"] = 1 - frame.loc[::9, "resp"]
    frame.to_csv(folder / "table.csv", index=False)
    return str(folder / "table.csv")


@pytest.mark.parametrize("example, options, first", list(layouts()))
def test_a_layout_of_the_guide_gives_its_first_line(
    example, options, first, tmp_path, capsys, monkeypatch
):
    (tmp_path / "data").mkdir()
    place = written(codes(example), tmp_path / "data")
    words = shlex.split(codes(options)[0])
    words = words[3:] if words[:2] == ["slipscale", "analyse"] else words
    if words[0] == "--factor":
        words = [*OFFSETS.split(), *words]
    monkeypatch.setenv("COLUMNS", "300")
    monkeypatch.setattr(
        "slipscale.analysis.reporting.files.write_analysis", lambda *_, **__: "report.html"
    )
    assert commands.main(["analyse", place, *words]) == 0
    said = [line.rstrip() for line in capsys.readouterr().out.splitlines() if line.strip()]
    assert said[0].startswith(first)
