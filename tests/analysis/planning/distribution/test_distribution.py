"""A study simulated many times: whose numbers they are, how they spread, the command."""

import csv
import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from slipscale import commands
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.planning.distribution import many_studies, numbers
from slipscale.analysis.planning.distribution.distribution import distribution
from slipscale.analysis.planning.distribution.many_studies import ManyStudies, StudyResult, results
from slipscale.analysis.planning.distribution.names import said
from slipscale.analysis.planning.distribution.numbers import (
    BestModel,
    Findings,
    Label,
    ResultName,
    findings,
)
from slipscale.experiments.participants.simulated_people.habits import REALISTIC
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_simulated_fits")

STUDY = """
name = "small"
title = "A small study"
amplitudes_um_pp = [0.0, 1.2, 2.3]
participants = 5
seed = 3
[[tasks]]
protocol = "magnitude_estimation"
scale_top = "declared"
repetitions = 2
[analysis]
tests = ["friedman", "pairwise", "power_law"]
"""
RESTLESS = Population(
    name="restless", habits=REALISTIC.model_copy(update={"lapses": 0.1, "dropout": 0.3})
)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "small.toml"
    path.write_text(STUDY)
    return str(path)


@pytest.fixture(scope="module")
def many(study):
    return ManyStudies(study_name=study, population=RESTLESS)


@pytest.fixture(scope="module")
def found(many):
    return list(results(many, 6))


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Work in a folder that holds something else."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "precious.txt").write_text("mine")
    return tmp_path


def piloted(folder, study, seed, population, participants=None):
    """Return what `slipscale pilot` finds with a seed, session by session."""
    plans = pilot_plans(
        study, participants=participants, seed=seed, language=None, population=population
    )
    run_pilot(folder, plans, tell=lambda _: None)
    return findings(analyse(folder))


def test_each_study_is_the_pilot_of_its_seed(tmp_path, study, found):
    for each in found[1:3]:
        assert each.found == piloted(tmp_path / str(each.number), study, each.seed, RESTLESS)
    assert len({each.seed for each in found}) == len(found)


@pytest.mark.parametrize("name", ["difference_threshold", "matching"])
def test_other_protocols_are_the_pilots_of_their_seeds_too(tmp_path, name):
    many = ManyStudies(study_name=name, population=Population(), participants=3)
    first = many.compute(1)
    assert first.found == piloted(tmp_path / "pilot", name, first.seed, Population(), 3)
    assert first.found.numbers


def test_several_processes_find_the_same(many, found):
    assert list(results(many, 6, jobs=2)) == found


def test_seeds_depend_on_all_that_the_study_depends_on(many):
    others = [
        replace(many, seed=4),
        replace(many, participants=6),
        replace(many, language="fr"),
        replace(many, population=Population()),
    ]
    assert len({each.seed_of(1) for each in (many, *others)}) == 5


def test_a_number_spreads_as_its_percentiles_say(many):
    values = np.random.default_rng(1).normal(size=101)
    spread = distribution(
        many,
        [
            StudyResult(
                number=n,
                seed=n,
                found=Findings(numbers={ResultName(("power_law", "exponent")): value}),
            )
            for n, value in enumerate(values.tolist(), start=1)
        ]
        + [StudyResult(number=102, seed=102, refused="nobody is left")],
    ).by_name[ResultName(("power_law", "exponent"))]
    ordered = np.sort(values)
    assert (spread.p5, spread.median, spread.p95) == (ordered[5], ordered[50], ordered[95])
    assert spread.studies == 101


def test_a_study_that_is_refused_is_one_in_which_nothing_holds(many):
    holds = StudyResult(
        number=1, seed=1, found=Findings(conclusions={ResultName(("friedman", "p")): True})
    )
    refused = StudyResult(number=2, seed=2, refused="nobody is left")
    found = distribution(many, [holds, refused, replace(refused, number=3), holds])
    (only,) = found.conclusions
    assert only.words == "amplitudes differ (Friedman's test)"
    assert (only.share.value, only.share.studies) == (0.5, 4)
    assert found.refused == {"nobody is left": 2}


def test_exclusions_that_leave_nobody_are_told_and_not_raised(tmp_path):
    path = tmp_path / "strict.toml"
    path.write_text(STUDY + 'exclusions = ["fast"]\nthresholds = { fast_s = 99.0 }\n')
    result = ManyStudies(study_name=str(path), population=Population()).compute(1)
    assert "leave no participant" in result.refused
    assert not result.found.numbers


def test_numbers_of_one_participant_are_left_out_and_corrected_p_decide(found):
    names = {str(name) for each in found for name in each.found.numbers}
    assert "table3.1.2.standard_deviation" in names
    assert "pairwise.0 - 1.2.ratio_ci.low" in names
    assert not any("sub-" in name for name in names)
    concluded = {str(name) for each in found for name in each.found.conclusions}
    assert "pairwise.0 - 1.2.p_wilcoxon_holm" in concluded
    assert "pairwise.0 - 1.2.p_wilcoxon" not in concluded
    for result in found:
        p = ResultName(("friedman", "p"))
        assert result.found.conclusions[p] == (result.found.numbers[p] < 0.05)


def test_a_list_s_records_are_named_by_what_they_are_of():
    records = {
        "scales": [
            {"task": "pairs", "surfaces": ["1", "fine"], "values": [0.0, 2.0], "ci": [3, 4]}
        ],
        "ratings": [
            {
                "task": "line",
                "surfaces": [{"surface": "0", "mean": 5.0}],
                "pairs": [{"from_surface": "0", "to_surface": "1.2", "p_holm": 0.1}],
                "participants": [{"participant": "sub-01", "mean": 7.0}],
            }
        ],
        "factors": [
            {"factor": name, "anova": {"factor": {"p": p}}, "changes": [{"condition": "b"}]}
            for name, p in (("speed", 0.1), ("force", 0.2))
        ],
        "contrasts": [{"first": "80", "second": "180", "p_holm": 0.3}],
        "plain": [{"value": 8.0}, {"value": 9.0}],
    }
    leaves = numbers._leaves(records, ResultName())
    names = {str(name): value for name, value in leaves}
    assert names == {
        "scales.pairs.values.1": 0.0,
        "scales.pairs.values.fine": 2.0,
        "scales.pairs.ci.low": 3,
        "scales.pairs.ci.high": 4,
        "ratings.line.surfaces.0.mean": 5.0,
        "ratings.line.pairs.0 - 1.2.p_holm": 0.1,
        "factors.speed.anova.factor.p": 0.1,
        "factors.force.anova.factor.p": 0.2,
        "contrasts.80 - 180.p_holm": 0.3,
        "plain.1.value": 8.0,
        "plain.2.value": 9.0,
    }


def test_a_description_names_the_elements_of_its_path_and_no_result_at_another():
    pair = ResultName(("ratings", Label(("line", "0.5")), "pairs", Label(("0", "1.2")), "p_holm"))
    assert pair.at(("ratings", "*", "pairs", "*", "p_holm")) == [("line", "0.5"), ("0", "1.2")]
    assert pair.at(("ratings", "*", "pairs", "*", "p")) is None
    assert pair.at(("ratings", "*", "pairs", "*")) is None
    words = {("ratings", "*", "pairs", "*", "p_holm"): "{0[0]} ({0}): {1[0]} and {1[1]} {q.unit}"}
    assert said(pair, words) == (0, "line (line - 0.5): 0 and 1.2 µm")
    best = ResultName(("growth", "amplitude", "best", BestModel("power")))
    counted = ResultName(("growth", "individual", "best", "power"))
    assert [str(counted), str(ResultName(("own",)))] == ["growth.individual.best.power", "own"]
    assert (best.at(("growth", "amplitude", "best", "*")), str(best)) == (
        ["power"],
        "growth.amplitude.best: power",
    )
    assert said(pair, {}) == (0, "ratings.line - 0.5.pairs.0 - 1.2.p_holm")


def test_what_would_take_hours_asks_first(monkeypatch, many):
    clock = iter([0.0, 0.0, 100.0])
    monkeypatch.setattr(many_studies, "time", SimpleNamespace(perf_counter=lambda: next(clock)))
    monkeypatch.setattr(
        ManyStudies, "compute", lambda _self, number: StudyResult(number=number, seed=0)
    )
    with pytest.raises(
        UserError, match=r"2\.7 hours on this computer \(100\.0 s per study\).*--yes"
    ):
        list(results(many, 100))


def test_without_a_folder_it_lies_beside_the_pilots(here, study):
    for number in ("001", "002"):
        assert commands.main(["pilot", study, "--times", "1", "--participants", "3"]) == 0
        assert (here / "pilots" / "distributions" / number / "distribution.html").exists()


def test_the_command_writes_page_figures_and_tables(tmp_path, study, capsys):
    out = tmp_path / "out"
    words = ["pilot", study, "--times", "3", "--out", str(out)]
    assert commands.main(words) == 0
    told = capsys.readouterr().out
    assert "median (5th to 95th percentile of the studies)" in told
    record = json.loads((out / "distribution.json").read_text())
    with (out / "studies.csv").open() as file:
        studies = list(csv.DictReader(file))
    means = [float(row["table3.1.2.mean"]) for row in studies]
    assert record["numbers"]["table3.1.2.mean"]["median"] == np.median(means)
    page = (out / "distribution.html").read_text()
    assert f"{np.median(means):.4g} (" in page
    assert "amplitudes differ (Friedman&#39;s test)" in page
    assert {"table3.svg", "fig15.png", "results.svg"} <= {path.name for path in out.iterdir()}
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    assert commands.main(words) == 0  # its own folder is written again, to the same bytes
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


@pytest.mark.parametrize(
    "options, sentence",
    [
        (["--times", "0"], "--times 0: expected 1 to 1000000"),
        (["--times", "2", "--jobs", "0"], "--jobs 0: expected 1 or more"),
        (["--jobs", "2"], "--jobs applies only to repeated simulations"),
        (["--yes"], "--yes applies only to repeated simulations"),
        (["--times", "2", "--plate", "mock:faults=0.1"], "omit --plate, or --times"),
        (["--times", "2", "--force", "simulated"], "omit --force, or --times"),
        (["--times", "2", "--participants", "0"], "--participants 0: expected 1 or more"),
        (["--times", "2", "--out", "."], "is not empty"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(here, study, capsys, options, sentence):
    assert commands.main(["pilot", study, *options]) == 2
    told = capsys.readouterr().err
    assert sentence in told
    assert told.count("\n") == 1
    assert [path.name for path in here.iterdir()] == ["precious.txt"]
