"""The whole command: a study run simulated, and analysed, in one process."""

import csv
import json
import shlex
from statistics import fmean, stdev

import pytest

from slipscale import commands
from slipscale.experiments.dataset.journals import journals
from slipscale.experiments.running import pilot

STUDY = """
name = "small"
title = "A small study"
amplitudes_um_pp = [0.0, 1.2, 2.3]
participants = 4
[[tasks]]
protocol = "descending_difference"
[[tasks]]
protocol = "magnitude_estimation"
scale_top = "declared"
repetitions = 2
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the data set of a pilot run to its end, and nothing else touched."""
    root = tmp_path_factory.mktemp("pilot")
    (root / "small.toml").write_text(STUDY)
    out = root / "data"
    words = ["pilot", str(root / "small.toml"), "--seed", "5", "--out", str(out)]
    assert commands.main(words) == 0
    return out


def estimates(path):
    """Return amplitude -> estimates in % of the scale's top, straight from a journal's lines."""
    found, step, amplitude, top = {}, None, None, None
    for line in path.read_text(encoding="utf-8").splitlines():
        record = json.loads(line)
        if record["kind"] == "begin":
            step = record["what"]
        elif record["kind"] == "done" and step["type"] == "Present":
            amplitude = step["surface"]["amplitude_um_pp"]
        elif record["kind"] == "done" and step["type"] == "Ask":
            value = record["answer"]["value"]
            if step["name"] == "scale_top":
                top = value
            elif step["name"] == "estimate" and step["trial"]["phase"] == "main":
                found.setdefault(amplitude, []).append(100 * value / top)
    return found


def test_a_pilot_s_table_iii_is_what_its_journals_give_in_parts_of_the_declared_scale(folder):
    results = folder / "derivatives" / "slipscale"
    inference = json.loads((results / "inference.json").read_text(encoding="utf-8"))
    assert inference["normalisation"]["rule"] == "scale_top"
    people = [estimates(path) for path in journals(folder)]
    assert [len(values) for one in people for values in one.values()] == [2] * 12
    with (results / "table3.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["amplitude_um_pp"]) for row in rows] == [0.0, 1.2, 2.3]
    for row in rows:
        means = [fmean(one[float(row["amplitude_um_pp"])]) for one in people]
        mean = fmean(means)
        assert int(row["n"]) == 4
        assert float(row["mean"]) == pytest.approx(mean)
        assert float(row["standard_deviation"]) == pytest.approx(stdev(means))
        largest = max(abs(each - mean) for each in means)
        assert float(row["maximum_deviation"]) == pytest.approx(largest)


def test_a_pilot_s_steps_are_what_its_journals_hold(folder):
    difference = json.loads(
        (folder / "derivatives" / "slipscale" / "inference.json").read_text(encoding="utf-8")
    )["difference"]
    answers = [
        record["answer"]["value"]
        for path in journals(folder)
        for record in map(json.loads, path.read_text(encoding="utf-8").splitlines())
        if record["kind"] == "done" and isinstance((record["answer"] or {}).get("value"), bool)
    ]
    counted = [*difference["steps"], difference["catch"]]
    assert sum(each["n"] for each in counted) == len(answers) == 4 * 3
    assert sum(each["yes"] for each in counted) == sum(answers)


def interrupt(monkeypatch, after):
    """Have the pilot be interrupted after so many participants; afterwards it runs as ever."""
    run = pilot.run_simulated
    left = iter(range(after))

    def limited(*arguments):
        if next(left, None) is None:
            monkeypatch.setattr(pilot, "run_simulated", run)
            raise KeyboardInterrupt
        run(*arguments)

    monkeypatch.setattr(pilot, "run_simulated", limited)


@pytest.mark.parametrize(
    "options",
    [
        ["--participants", "2", "--seed", "8", "--language", "fr", "--plate", "mock:noise=0.001"],
        [],
    ],
)
def test_an_interrupted_pilot_tells_the_command_that_completes_it(
    capsys, tmp_path, monkeypatch, shipped_pilot, options
):
    monkeypatch.chdir(tmp_path)
    # Its tables are compared; what is printed of them is tested elsewhere.
    analysis = shipped_pilot("matching")[1]
    monkeypatch.setattr("slipscale.analysis.pipeline.analyse", lambda _: analysis)
    monkeypatch.setattr("slipscale.analysis.reporting.files.write_analysis", lambda _, out: out)
    study = tmp_path / "it's [bold] small.toml"
    study.write_text(STUDY)
    whole = tmp_path / "whole"
    words = ["pilot", str(study), *options]
    assert commands.main([*words, "--out", str(whole)]) == 0
    capsys.readouterr()
    # A name long enough to be broken over two lines, were it printed as prose.
    out = tmp_path / f"my {'long ' * 20}pilot"
    interrupt(monkeypatch, after=1)
    assert commands.main([*words, "--out", str(out)]) == 130
    said = next(line for line in capsys.readouterr().out.splitlines() if "To continue: " in line)
    command = shlex.split(said.partition("To continue: ")[2])
    assert command[0] == "slipscale"
    assert commands.main(command[1:]) == 0
    tables = [path.relative_to(whole) for path in sorted(whole.glob("sub-*/beh/*_beh.tsv"))]
    assert len(tables) == 2 * (2 if "--participants" in options else 4)
    assert all((out / name).read_bytes() == (whole / name).read_bytes() for name in tables)


def test_a_pilot_in_a_folder_of_its_own_choice_tells_that_folder(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    interrupt(monkeypatch, after=0)
    assert commands.main(["pilot", "--participants", "1"]) == 130
    assert "slipscale pilot biet2007 --participants 1 --out pilots/001" in capsys.readouterr().out
