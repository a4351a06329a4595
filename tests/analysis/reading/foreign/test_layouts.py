"""Every layout gives the trials of the tidy table with the same answers."""

from argparse import ArgumentParser
from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

from slipscale.analysis.cli.analyse import add_analyse, paths_of
from slipscale.analysis.cli.mapping_arguments import mapping_from
from slipscale.analysis.load import load
from slipscale.analysis.tasks.scales.statistics import scales
from slipscale.analysis.tasks.thresholds import section
from slipscale.analysis.tasks.thresholds.statistics import thresholds

#: Tables of the same layouts, which are kept next to some checkouts.
CASES = Path(__file__).parents[5] / "shared" / "cases" / "tables"
TIDY = "tidy.csv --participant participant --stimulus level --answer correct --alternatives 2"
COUNTS = "--participant participant --stimulus level --alternatives 2"
#: Commands for forced-choice answers, and whether they read the first participant only.
LAYOUTS = {
    "one file per person": (
        (
            "one_file_a_person --participant-from-name --stimulus level "
            "--answer key_resp.corr "
            "--alternatives 2"
        ),
        False,
    ),
    "no participant in the files": (
        ("without_id --participant-from-name --stimulus level --answer correct --alternatives 2"),
        False,
    ),
    "several files": (
        (
            "without_id/s01.csv without_id/s02.csv without_id/s03.csv without_id/s04.csv "
            "without_id/s05.csv without_id/s06.csv --participant-from-name ^(s\\d+) "
            "--stimulus level "
            "--answer correct --alternatives 2"
        ),
        False,
    ),
    "counts": (f"counts.csv {COUNTS} --yes-count n_correct --n n_trials", False),
    "a number for n": (f"counts.csv {COUNTS} --yes-count n_correct --n 20", False),
    "correct and wrong": (
        f"correct_and_wrong.csv {COUNTS} --yes-count n_correct --no-count n_wrong",
        False,
    ),
    "percent": (f"percent.csv {COUNTS} --percent percent_correct --n n_trials", False),
    "wide counts": (
        (
            "wide_counts.csv --participant participant --stimulus level "
            "--levels L2 L4 L6 L8 L12 L16 "
            "--n trials_per_level --alternatives 2"
        ),
        False,
    ),
    "people in columns": (
        "people_in_columns.csv --people-in-columns --stimulus level --alternatives 2",
        False,
    ),
    "several codes": (
        (
            "outcomes.csv --participant participant --stimulus level --answer outcome "
            "--alternatives 2 --yes hit --no miss wrong_side late --missing aborted"
        ),
        False,
    ),
    "no answer is 0": (
        (
            "no_answer_is_0.csv --participant participant --stimulus level --answer acc "
            "--alternatives 2 --yes TRUE --no FALSE --missing 0"
        ),
        False,
    ),
    "one person": (
        "one_person.csv --stimulus level --answer correct --alternatives 2",
        True,
    ),
    "one of the files": (
        "without_id/s01.csv --stimulus level --answer correct --alternatives 2",
        True,
    ),
    "no header": (
        "counts_without_header.csv --no-header --stimulus 1 --yes-count 2 --n 3 --alternatives 2",
        True,
    ),
    "a matrix of MATLAB": (
        "counts.mat --stimulus 1 --yes-count 2 --n 3 --alternatives 2",
        True,
    ),
}


def read(folder, command, monkeypatch):
    """Read a table as the command would."""
    parser = ArgumentParser()
    add_analyse(parser)
    args = parser.parse_args(command.split())
    monkeypatch.chdir(folder)
    return load(paths_of(args), mapping_from(args))


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """Return a folder with small tables of all layouts, written from the same answers."""
    folder = tmp_path_factory.mktemp("tables")
    rng = np.random.default_rng(5)
    levels = [2, 4, 6, 8, 12, 16]
    tidy = pd.DataFrame(
        {"participant": who, "level": level, "correct": int(rng.random() < right)}
        for who, half in (("s01", 4), ("s02", 6), ("s03", 5), ("s04", 7), ("s05", 3), ("s06", 6))
        for level in rng.permutation(np.repeat(levels, 20))
        for right in [1 - 0.5 * np.exp(-((level / half) ** 2))]
    )
    inside = folder / "two_interval"
    for name in ("one_file_a_person", "without_id"):
        (inside / name).mkdir(parents=True)
    tidy.to_csv(inside / "tidy.csv", index=False)
    counts = tidy.groupby(["participant", "level"])["correct"].agg(["sum", "size"]).reset_index()
    counts.columns = ["participant", "level", "n_correct", "n_trials"]
    counts.to_csv(inside / "counts.csv", index=False)
    wrong = counts.assign(n_wrong=counts["n_trials"] - counts["n_correct"])
    wrong.drop(columns="n_trials").to_csv(inside / "correct_and_wrong.csv", index=False)
    percent = counts.assign(percent_correct=100 * counts["n_correct"] / counts["n_trials"])
    percent.drop(columns="n_correct").to_csv(inside / "percent.csv", index=False)
    table = counts.pivot_table("n_correct", "participant", "level").astype(int)
    wide = table.rename(columns="L{}".format).assign(trials_per_level=20)
    wide.to_csv(inside / "wide_counts.csv")
    lines = [f",{','.join(table.index)}", f"level{',n correct of 20' * len(table)}"]
    lines += [f"{level},{','.join(map(str, table[level]))}" for level in levels]
    (inside / "people_in_columns.csv").write_text("\n".join(lines) + "\n")
    spoilt = tidy.assign(
        outcome=np.where(
            tidy["correct"] == 1, "hit", rng.choice(["miss", "wrong_side", "late"], len(tidy))
        ),
        acc=np.where(tidy["correct"] == 1, "TRUE", "FALSE"),
    )
    aborted = tidy.iloc[::9].assign(outcome="aborted", acc="0")
    spoilt = pd.concat([spoilt, aborted]).sort_index(kind="stable").drop(columns="correct")
    spoilt.drop(columns="acc").to_csv(inside / "outcomes.csv", index=False)
    spoilt.drop(columns="outcome").to_csv(inside / "no_answer_is_0.csv", index=False)
    for who, rows in tidy.groupby("participant"):
        own = rows.drop(columns="participant")
        own.to_csv(inside / "without_id" / f"{who}.csv", index=False)
        psychopy = own.rename(columns={"correct": "key_resp.corr"}).assign(session="001")
        psychopy = pd.concat([pd.DataFrame({"session": ["001"]}), psychopy])
        day = int(who[1:])
        psychopy[["level", "key_resp.corr", "session"]].assign(**{"": None}).to_csv(
            inside / "one_file_a_person" / f"{who}_detect_2026-03-0{day}_10h1{day}.05.123.csv",
            index=False,
            encoding="utf-8-sig",
        )
    first = tidy[tidy["participant"] == "s01"]
    first.drop(columns="participant").to_csv(inside / "one_person.csv", index=False)
    matrix = counts[counts["participant"] == "s01"].drop(columns="participant")
    matrix.to_csv(inside / "counts_without_header.csv", index=False, header=False)
    savemat(inside / "counts.mat", {"data": matrix.to_numpy(float)})
    return folder


FOLDERS = [
    "generated",
    pytest.param("shared", marks=pytest.mark.skipif(not CASES.is_dir(), reason="no tables")),
]


@pytest.fixture(params=FOLDERS)
def folder(request, tables):
    return tables if request.param == "generated" else CASES


def counted(data):
    """Return the answers as numbers of correct answers and of all answers."""
    rows = data.trials["forced_choices"]
    people = rows["participant_id"].astype(str)
    return rows.groupby([people, "track_level"])["correct"].agg(["sum", "size"])


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_has_the_answers_of_the_tidy_table(folder, layout, monkeypatch):
    command, alone = LAYOUTS[layout]
    inside = folder / "two_interval"
    expected = counted(read(inside, TIDY, monkeypatch))
    found = read(inside, command, monkeypatch)
    if alone:
        expected = expected.loc[["s01"]].reset_index("participant_id", drop=True)
        assert counted(found).reset_index("participant_id", drop=True).equals(expected)
    else:
        assert counted(found).equals(expected)


def result(data):
    """Return the thresholds as in the report, without the labels of people."""
    (found,) = thresholds(data.trials["forced_choices"])
    return found.population, [each.function for each in found.participants]


@pytest.mark.parametrize("layout", ["one file per person", "wide counts", "several codes"])
def test_the_results_agree_digit_for_digit(folder, layout, monkeypatch):
    inside = folder / "two_interval"
    expected = result(read(inside, TIDY, monkeypatch))
    assert result(read(inside, LAYOUTS[layout][0], monkeypatch)) == expected


#: Wins of the row's item in 12 judgements of each pair, and maximum-likelihood log strengths.
WINS = """,felt,silk,paper,steel,glass
felt,0,5,3,1,1
silk,7,0,3,2,1
paper,9,9,0,5,5
steel,11,10,7,0,3
glass,11,11,7,9,0
"""
STRENGTHS = {"felt": -1.2016, "silk": -0.9167, "paper": 0.3331, "steel": 0.5804, "glass": 1.2049}


@pytest.fixture(scope="module")
def comparisons(tmp_path_factory):
    """Return a folder with the same choices as a matrix, by name and by place."""
    inside = tmp_path_factory.mktemp("pairs")
    (inside / "wins.csv").write_text(WINS)
    wins = pd.read_csv(inside / "wins.csv", index_col=0)
    rows = [
        {"left_item": one, "right_item": other, "chosen": won, "judge": "j01"}
        for one, other in combinations(wins.index, 2)
        for won, times in ((one, wins.loc[one, other]), (other, wins.loc[other, one]))
        for _ in range(times)
    ]
    names = pd.DataFrame(rows)
    names.to_csv(inside / "choices.csv", index=False)
    place = np.where(names["chosen"] == names["left_item"], "left", "right")
    names.assign(response=place).to_csv(inside / "choices_left_right.csv", index=False)
    return inside


@pytest.mark.parametrize("folder", FOLDERS)
@pytest.mark.parametrize(
    "command",
    [
        "wins.csv --matrix wins",
        "choices.csv --participant judge --first left_item --second right_item --chosen chosen",
        (
            "choices_left_right.csv --participant judge --first left_item --second right_item "
            "--chosen response"
        ),
    ],
)
def test_choices_in_pairs_give_the_strengths(folder, command, comparisons, monkeypatch):
    data = read(comparisons if folder == "generated" else CASES / "pairs", command, monkeypatch)
    (found,) = scales(data.trials["comparisons"])
    scale = found.bradley_terry
    values = dict(zip(found.surfaces, scale.values, strict=True))
    # Firth's correction shrinks the maximum-likelihood values by a few per cent.
    assert values == pytest.approx(STRENGTHS, rel=0.05, abs=0.02)
    assert found.answers == 120


@pytest.fixture(scope="module")
def others(tmp_path_factory):
    """Return a folder with small tables of differences, squares, offsets and events."""
    folder = tmp_path_factory.mktemp("others")
    rng = np.random.default_rng(8)
    (folder / "quadruples").mkdir()
    scale = [0, 0.23, 1.162, 2.014, 3.25, 4.872, 6.249, 7.219]
    rows = [
        [a + 1, b + 1, c + 1, d + 1, int(scale[d] - scale[c] - scale[b] + scale[a] > rng.normal())]
        for a, b, c, d in combinations(range(8), 4)
        for _ in range(3)
    ]
    frame = pd.DataFrame(rows, columns=["S1", "S2", "S3", "S4", "resp"])
    frame.to_csv(folder / "quadruples" / "quadruples.csv", index=False)
    dissimilar = folder / "square" / "dissimilarities"
    dissimilar.mkdir(parents=True)
    places = rng.normal(size=(6, 2))
    apart = np.linalg.norm(places[:, None] - places, axis=2).round(2)
    names = list("ABCDEF")
    pd.DataFrame(1 - apart / 10, names, names).to_csv(folder / "square" / "similarities.csv")
    for who in ("p1", "p2", "p3"):
        noisy = apart + np.triu(rng.uniform(0, 0.05, (6, 6)), 1)
        noisy = (np.triu(noisy, 1) + np.triu(noisy, 1).T).round(3)
        pd.DataFrame(noisy, names, names).to_csv(dissimilar / f"{who}.csv")
    (folder / "signed").mkdir()
    pd.DataFrame(
        {"subj": who, "condition": name, "offset_mm": level, "answer": answer}
        for who in (f"P{n}" for n in range(8))
        for name, (pse, sd) in {"still": (0.0, 0.8), "moving": (0.3, 1.4)}.items()
        for level in np.repeat([-3, -2, -1, 0, 1, 2, 3], 12)
        for answer in ["right" if rng.logistic(pse, sd * np.sqrt(3) / np.pi) < level else "left"]
    ).to_csv(folder / "signed" / "signed_offsets.csv", index=False)
    for who in ("01", "02", "03", "04"):
        inside = folder / "events" / f"sub-{who}" / "func"
        inside.mkdir(parents=True)
        events = [
            event
            for level in rng.permutation(np.repeat([44, 45, 46, 47, 48], 4))
            for event in (("stimulus", level, None), ("rate", None, round(8 * (level - 43.0), 1)))
        ]
        table = pd.DataFrame(events, columns=["trial_type", "temperature", "rating"])
        table.insert(0, "onset", np.arange(len(table)) * 10.0)
        table.to_csv(
            inside / f"sub-{who}_task-pain_run-01_events.tsv", sep="\t", index=False, na_rep="n/a"
        )
    return folder


@pytest.fixture(params=FOLDERS)
def of_others(request, others):
    return others if request.param == "generated" else CASES


def test_quadruples_give_the_difference_scale(of_others, monkeypatch):
    data = read(
        of_others / "quadruples",
        "quadruples.csv --quadruple S1,S2,S3,S4 --answer resp",
        monkeypatch,
    )
    (found,) = scales(data.trials["comparisons"])
    right = [0, 0.0318, 0.1609, 0.279, 0.4502, 0.6749, 0.8655, 1]
    exact = of_others == CASES
    values = found.differences.values  # noqa: PD011 - a tuple
    assert values == pytest.approx(right, abs=6e-5 if exact else 0.1)


def test_triads_are_quadruples_with_a_common_stimulus(tmp_path, others, monkeypatch):
    frame = pd.read_csv(others / "quadruples" / "quadruples.csv").query("S2 + 1 == S3")
    frame.assign(S3=frame["S2"]).to_csv(tmp_path / "four.csv", index=False)
    frame.drop(columns="S3").to_csv(tmp_path / "three.csv", index=False)
    of_four = read(tmp_path, "four.csv --quadruple S1,S2,S3,S4 --answer resp", monkeypatch)
    of_three = read(tmp_path, "three.csv --triad S1,S2,S4 --answer resp", monkeypatch)
    four, three = (scales(each.trials["comparisons"])[0] for each in (of_four, of_three))
    assert three.differences == four.differences


@pytest.mark.parametrize(
    "command, people",
    [
        ("similarities.csv --matrix similarities", 1),
        ("dissimilarities --matrix dissimilarities --participant-from-name", 3),
    ],
)
def test_square_tables_are_ratings_of_pairs(of_others, command, people, monkeypatch):
    data = read(of_others / "square", command, monkeypatch)
    rated = data.trials["dissimilarities"]
    assert rated.groupby("participant_id", observed=True).size().tolist() == [15] * people
    if people == 1:
        table = pd.read_csv(of_others / "square" / "similarities.csv", index_col=0)
        first = rated.iloc[0]
        assert (first["first"], first["second"]) == ("A", "B")
        assert first["dissimilarity"] == pytest.approx(1 - table.loc["A", "B"])


def test_offsets_in_two_conditions_have_different_points_of_equality(of_others, monkeypatch):
    data = read(
        of_others / "signed",
        "signed_offsets.csv --participant subj --stimulus offset_mm:mm --answer answer "
        "--yes right --factor condition",
        monkeypatch,
    )
    (found,) = thresholds(data.trials["forced_choices"])
    (factor,) = found.population.factors
    values = {each.name: each.threshold_level.value for each in factor.levels}
    assert values == pytest.approx({"moving": 0.3, "still": 0.0}, abs=0.15)
    assert factor.contrasts[0].p < 0.05
    # The generating standard deviations are 0.8 and 1.4.
    (slopes,) = found.slopes
    assert slopes.half_widths_level == pytest.approx(
        {"moving": 0.6745 * 1.4, "still": 0.6745 * 0.8}, rel=0.2
    )
    assert slopes.contrasts[0].p_holm < 0.05
    shown = " ".join(section.blocks(found, {}, 95, data.quantity))
    assert "Change: ratio of slopes." in shown
    assert "Slope by" in shown
    assert shown.count("still compared with moving") == 2
    assert data.quantity.unit == "mm"


def test_stimuli_and_answers_in_separate_rows_are_joined(of_others, monkeypatch):
    data = read(
        of_others,
        "events --participant-from-name --rows-of trial_type=stimulus,rate "
        "--stimulus temperature:°C --response rating",
        monkeypatch,
    )
    assert len(data.estimates) == 80
    assert data.people == {"sub-01", "sub-02", "sub-03", "sub-04"}
    means = data.estimates.groupby("level")["estimate"].mean()
    assert means.index.tolist() == [44, 45, 46, 47, 48]
    assert means.is_monotonic_increasing


@pytest.mark.parametrize("n", ["20", "of"])
def test_the_number_of_answers_is_no_person_in_a_column(tmp_path, n):
    """The stated number was one more person, who was always right."""
    text = "level,a,b,of\n1,9,8,20\n2,14,12,20\n4,18,17,20\n"
    lines = text.splitlines() if n == "of" else [each.rpartition(",")[0] for each in text.split()]
    (tmp_path / "t.csv").write_text("\n".join(lines))
    data = load(tmp_path / "t.csv", people_in_columns=True, stimulus="level", n=n)
    assert data.people == {"a", "b"}
    assert len(data) == 2 * 3 * 20
