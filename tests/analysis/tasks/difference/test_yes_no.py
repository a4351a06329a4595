"""The descending difference: counts, d', words, coders."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.analysis.json_form import record
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.difference.coder_agreement import agreement
from slipscale.analysis.tasks.difference.verbal_coding import load_codebook
from slipscale.analysis.tasks.difference.verbal_reports import CategoryCount
from slipscale.analysis.tasks.difference.yes_no import (
    TRIALS_FOR_OWN,
    CatchAnswers,
    Finding,
    analyse_differences,
    d_prime,
    own_thresholds,
)
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_models")

BOOK = load_codebook()


def series(dataset, catch="no", words="less slippery", last="yes"):
    row = dataset.difference_row
    return [
        row(1, 2.3, 1.2, "yes", verbal_report=words),
        row(2, 1.2, 1.2, catch),
        row(3, 1.2, 0.5, "yes", verbal_report=words),
        row(4, 0.5, 0, last, verbal_report=words if last == "yes" else "n/a"),
    ]


def analysed(dataset, **own):
    people = {f"{n:02d}": series(dataset) for n in range(1, 7)} | own
    data = load(dataset(differences=people))
    assert not data.problems
    return analyse_differences(data.differences, BOOK)


def test_steps_are_counted_from_the_top_with_exact_intervals(dataset):
    found = analysed(dataset, **{"03": series(dataset, last="no")})
    assert [(row.from_level, row.to_level) for row in found.steps] == [
        (2.3, 1.2),
        (1.2, 0.5),
        (0.5, 0.0),
    ]
    assert [row.yes for row in found.steps] == [6, 6, 5]
    assert list(found.steps[0].interval) == pytest.approx([0.025 ** (1 / 6), 1.0])
    assert found.catch.n == 6
    assert found.catch.yes == 0


def test_the_paper_s_finding_is_a_computed_statement(dataset):
    found = analysed(dataset).finding
    assert found.all_felt_a_difference
    assert found.all_said_less_slippery


def test_the_finding_can_fail(dataset):
    found = analysed(dataset, **{"02": series(dataset, words="it got colder")}).finding
    assert found.all_felt_a_difference
    assert not found.all_said_less_slippery
    assert found.said_less_slippery == 5


def test_a_finding_without_participants_is_not_true_of_all_of_them():
    nobody = Finding(n=0, felt_a_difference=0, felt_every_change=0, said_less_slippery=0)
    assert not nobody.all_felt_a_difference
    assert not nobody.all_said_less_slippery


@pytest.mark.parametrize("missing, computed", [(0, True), (1, False)])
def test_a_participant_has_a_threshold_from_the_fewest_answers_that_are_stated(missing, computed):
    count = TRIALS_FOR_OWN - missing
    sizes = np.resize([0.2, 0.5, 1.1, 1.8], count)
    steps = pd.DataFrame(
        {
            "participant_id": "01",
            "level_before": 2.3,
            "level": 2.3 - sizes,
            "difference_felt": (sizes > np.repeat([0.3, 0.6, 1.2, 0.6, 1.5], 4)[:count]) * 1.0,
        }
    )
    found = own_thresholds(steps, 0.95)["01"]
    assert (not isinstance(found, NotComputed)) is computed


def test_a_false_alarm_lowers_d_prime(dataset):
    clean = analysed(dataset)
    biased = analysed(dataset, **{"02": series(dataset, catch="yes")})
    assert biased.catch.yes == 1
    assert biased.signal_detection.pooled.d_prime < clean.signal_detection.pooled.d_prime
    assert set(biased.signal_detection.participants) == {f"sub-0{n}" for n in range(1, 7)}


def test_without_catch_steps_there_is_no_d_prime(dataset):
    rows = {f"{n:02d}": [r for r in series(dataset) if r["catch"] == "false"] for n in range(1, 7)}
    found = analyse_differences(load(dataset(differences=rows)).differences, BOOK)
    assert "no catch steps" in found.signal_detection.reason
    assert found.catch == CatchAnswers(n=0, yes=0, interval=None)


def test_d_prime_by_hand():
    """17 of 20 hits, 3 of 20 false alarms, log-linear: z(17.5/21) - z(3.5/21)."""
    from statistics import NormalDist

    z = NormalDist().inv_cdf
    d, c = d_prime(17, 20, 3, 20)
    assert d == pytest.approx(z(17.5 / 21) - z(3.5 / 21))
    assert c == pytest.approx(0)


@given(st.integers(1, 50), st.integers(1, 50), st.data())
def test_d_prime_is_finite_and_turns_its_sign_when_kinds_change_places(signals, noises, data):
    hits = data.draw(st.integers(0, signals))
    alarms = data.draw(st.integers(0, noises))
    d, c = d_prime(hits, signals, alarms, noises)
    other, same = d_prime(alarms, noises, hits, signals)
    assert np.isfinite(d)
    assert d == pytest.approx(-other)
    assert c == pytest.approx(same)


def test_a_known_d_prime_is_recovered():
    """Equal-variance observer with d' = 1.5, c = 0.3: 200 participants of 40 + 40 trials."""
    from statistics import NormalDist

    rng = np.random.default_rng(4)
    hit, alarm = (1 - NormalDist(mean).cdf(0.75 + 0.3) for mean in (1.5, 0.0))
    found = [d_prime(rng.binomial(40, hit), 40, rng.binomial(40, alarm), 40) for _ in range(200)]
    mean = np.mean(found, axis=0)
    assert mean == pytest.approx([1.5, 0.3], abs=0.1)


@pytest.mark.parametrize(
    "report,categories,meaning",
    [
        ("less slippery", ["slippery"], "less_slippery"),
        ("The slipperiness!", ["slippery"], "less_slippery"),
        ("more slippery", ["slippery"], "more_slippery"),
        ("moins glissant", ["slippery"], "less_slippery"),
        ("ça ne glisse plus", ["slippery"], "less_slippery"),
        ("plus rugueux", ["rough"], "less_slippery"),
        ("c’est plus rêche", ["rough"], "less_slippery"),
        ("it got rougher", ["rough"], "less_slippery"),
        ("it sticks more", ["sticky"], "less_slippery"),
        ("less smooth, it sticks more", ["smooth", "sticky"], "less_slippery"),
        ("less friction", ["sticky"], "more_slippery"),
        ("friction", ["sticky"], "unclear"),
        ("more slippery but stickier", ["slippery", "sticky"], "unclear"),
        ("warmer", ["temperature"], "unclear"),
        ("hair", ["other"], "unclear"),
        ("", ["other"], "unclear"),
    ],
)
def test_reports_are_coded_in_both_languages(report, categories, meaning):
    assert BOOK.code(report) == categories
    assert BOOK.meaning(report) == meaning


def test_the_raw_words_are_counted_under_their_categories(dataset):
    found = analysed(dataset, **{"01": series(dataset, words="plus rugueux")}).verbal_reports
    assert found.n == 18
    assert found.categories["slippery"] == CategoryCount(count=15, words={"less slippery": 15})
    assert found.categories["rough"].words == {"plus rugueux": 3}
    assert found.meaning == {"less_slippery": 18}


def test_an_edited_code_book_is_used_and_a_wrong_one_is_named(tmp_path):
    path = tmp_path / "book.toml"
    path.write_text('title = "Mine"\n[categories.velvet]\nstems = ["velvet"]\nbare = "unclear"\n')
    assert load_codebook(path).code("Velvety") == ["velvet"]
    path.write_text('title = "Mine"\n[categories.velvet]\nstem = ["velvet"]\n')
    with pytest.raises(UserError, match=r"(?s)book.toml.*stems.*stem"):
        load_codebook(path)


def test_kappa_by_hand():
    """Two coders, 20 reports, the textbook's 2 x 2 table 9, 1, 2, 8: (.85 - .5) / (1 - .5)."""
    pairs = [("a", "a")] * 9 + [("a", "b")] * 1 + [("b", "a")] * 2 + [("b", "b")] * 8
    rows = [
        {"verbal_report": f"r{i}", "coder": coder, "category": category}
        for i, pair in enumerate(pairs)
        for coder, category in zip(("one", "two"), pair, strict=True)
    ]
    found = agreement(pd.DataFrame(rows))
    assert found.kappa == pytest.approx(0.7)
    assert found.agreed == 17
    assert "for two" in agreement(pd.DataFrame(rows[::2])).reason


def test_an_interval_of_another_confidence_is_not_called_ci95(dataset):
    people = {f"{n:02d}": series(dataset) for n in range(1, 7)}
    data = load(dataset(differences=people))
    found = analyse_differences(data.differences, BOOK, 0.9)
    for part in (found.steps[0], found.catch):
        keys = record(part)
        assert "ci95" not in keys
        assert keys["ci"] == list(part.interval)
    assert "ci" not in record(analyse_differences(data.differences, BOOK).steps[0])


def test_the_figure_and_the_csv_take_the_study_s_confidence(dataset):
    from slipscale.analysis.reporting.files import draw
    from slipscale.analysis.reporting.tables import tables

    people = {f"{n:02d}": series(dataset) for n in range(1, 7)}
    analysis = analyse(dataset(differences=people, choices="confidence = 0.9"))
    assert {"ci_low", "ci_high"} <= set(tables(analysis)["difference"])
    assert "90 %" in draw(analysis)["difference"].axes[0].get_xlabel()
