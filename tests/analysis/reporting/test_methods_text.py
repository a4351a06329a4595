"""The methods section describes what was computed, and nothing else."""

import pytest

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reporting.methods_text import cited, sentences


def text_of(folder):
    return cited(" ".join(sentences(analyse(load(folder)), {})))


@pytest.mark.parametrize(
    "primary, words",
    [
        ("ranks", "consists of the tests on ranks (Friedman's and Wilcoxon's)."),
        ("logarithms", "consists of the tests on logarithms (analysis of variance and paired t"),
    ],
)
def test_both_kinds_of_test_are_described_whichever_is_primary(dataset, primary, words):
    text = text_of(dataset(choices=f'primary = "{primary}"'))
    assert f"The primary analysis {words}" in text
    for test in (
        "by Friedman's test (Friedman, 1937)",
        "repeated-measures analysis of variance with the Greenhouse–Geisser correction",
        "Wilcoxon signed-rank tests (Wilcoxon, 1945) of estimates and by paired t tests",
    ):
        assert text.count(test) == 1, test


def test_a_test_that_the_study_omits_is_not_described(dataset):
    text = text_of(dataset(choices='tests = ["friedman"]'))
    assert "Friedman's test (Friedman, 1937)" in text
    assert "Pairs of amplitudes were compared" not in text
    assert "analysis of variance with the" not in text
