"""Every test of the report is in one list."""

import json
import re
from dataclasses import fields, is_dataclass, replace
from pathlib import Path

import pytest

from slipscale.analysis.json_form import form
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.analysis.reporting.multiplicity import multiplicity
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Inference

FOREIGN = Path(__file__).parents[2] / "data" / "foreign"
COLUMNS = {"participant": "Subject", "stimulus": "age", "response": "distance", "group": "Sex"}


@pytest.fixture(scope="module")
def analysis():
    path = FOREIGN / "orthodont.csv"
    return analyse(load(path, parse_mapping({"columns": COLUMNS}, "here")))


def test_every_family_is_listed_once_with_its_tests(analysis):
    found = multiplicity(analysis.inference, "ranks", 0.95)
    counts = {family.name: family.tests for family in found.families}
    # 4 ages: 6 pairs. Order is not identifiable: every child was measured as it grew.
    assert counts == {
        "amplitudes, Friedman's test": 1,
        "pairs of amplitudes, Wilcoxon's test": 6,
        "amplitudes, repeated-measures analysis of variance": 1,
        "pairs of amplitudes, paired t": 6,
        "pairs of amplitudes, equivalence": 6,
        "ordered trend, Page's test": 1,
        "linear trend": 1,
        "groups, Welch's tests": 2,
        "groups, mixed analysis of variance": 2,
    }
    assert found.tests == sum(counts.values())
    assert [family.name for family in found.families if family.primary] == [
        "amplitudes, Friedman's test",
        "pairs of amplitudes, Wilcoxon's test",
    ]


def test_correction_over_all_leaves_no_more_than_within_families(analysis):
    found = multiplicity(analysis.inference, "logarithms", 0.95)
    assert all(family.below_over_all <= family.below for family in found.families)
    groups = next(f for f in found.families if f.name == "groups, Welch's tests")
    # p = .067 and .010: the second survives alone, not among two dozen.
    assert (groups.below, groups.below_over_all) == (1, 0)


def test_families_are_counted_as_they_are_corrected(analysis):
    """At levels between a p and its correction, where the two would be counted otherwise."""
    pairs = [pair.logs for pair in analysis.inference.pairwise]
    told = 0
    for pair in pairs:
        level = (pair.p + pair.p_holm) / 2
        found = multiplicity(analysis.inference, "ranks", 1 - level)
        family = next(f for f in found.families if f.name == "pairs of amplitudes, paired t")
        assert family.corrected
        assert family.below == sum(one.p_holm < found.level for one in pairs)
        told += family.below != sum(one.p < found.level for one in pairs)
    assert told


def p_values(value):
    """Every field named p of a result, which a reader may take for a test."""
    if isinstance(value, tuple):
        return [p for one in value for p in p_values(one)]
    if not is_dataclass(value):
        return []
    own = [value.p] if hasattr(value, "p") else []
    return own + [p for field in fields(value) for p in p_values(getattr(value, field.name))]


def test_no_p_of_the_inference_is_missing_from_the_list(analysis):
    """Two groups: the pair's p is that of all, and is counted once; the other ANOVA's twice."""
    everything = p_values(tuple(analysis.inference.results.values()))
    pair_of_groups, amplitude_again, friction = 2, 1, 0
    assert len(everything) - pair_of_groups - amplitude_again - friction == (
        multiplicity(analysis.inference, "ranks", 0.95).tests
    )


def test_nothing_tested_is_no_table(analysis, page):
    none = dict.fromkeys(analysis.inference.results, NotComputed("not chosen"))
    none["normalisation"] = analysis.inference.normalisation
    empty = replace(analysis, inference=Inference(none, analysis.inference.declared))
    assert multiplicity(empty.inference, "ranks", 0.95).tests == 0
    assert ">overall<" in page(analysis)
    assert ">overall<" not in page(empty)


def test_the_report_and_results_tell_it(analysis, page):
    text = re.sub(r"<[^>]+>", " ", page(analysis))
    assert re.search(r"Tests significant at .05: \d+ of 26, or \d+ if", text)
    found = form(multiplicity(analysis.inference, "ranks", 0.95))
    assert json.loads(json.dumps(found))["tests"] == 26
