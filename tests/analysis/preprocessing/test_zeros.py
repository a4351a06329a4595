"""Estimates of zero: each leaves its own pairs of logarithms, and no test on ranks."""

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.preprocessing.log_transform import prepare
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.repeated_measures import omnibus
from slipscale.analysis.statistics.repeated_measures.pairwise import pairwise
from slipscale.analysis.tasks.estimation import primary
from slipscale.analysis.tasks.estimation import sentences as apa
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

pytestmark = pytest.mark.usefixtures("without_models")

AMPLITUDES = (0.0, 0.5, 1.2, 2.3)


def ready(values, **choices):
    """Values, shape (participants, amplitudes)."""
    rows = [
        (f"p{who:02d}", amplitude, value)
        for who, row in enumerate(values)
        for amplitude, value in zip(AMPLITUDES, row, strict=False)
    ]
    frame = pd.DataFrame(rows, columns=["participant_id", "level", "normalised"])
    frame = frame.assign(
        participant_id=frame["participant_id"].astype("category"), session="", run="1"
    ).dropna()
    return prepare(frame.reset_index(drop=True), AnalysisChoices(**choices))


@pytest.fixture
def values():
    rng = np.random.default_rng(7)
    return np.exp(rng.normal(np.log([4, 20, 50, 80]), 0.25, (12, 4)))


def test_everybody_at_zero_at_0_um_leaves_tests_of_the_other_amplitudes(values):
    values[:, 0] = 0
    data = ready(values)
    anova = omnibus.rm_anova(data)
    assert (anova.n, anova.df1, anova.left_out_levels) == (12, 2, (0.0,))
    assert "without 0 µm, where every estimate is zero" in apa.rm_anova(
        anova, 0.95, PLATE_AMPLITUDE
    )
    pairs = pairwise(data)
    with_zero = [pair for pair in pairs if pair.from_level == 0]
    others = [pair for pair in pairs if pair.from_level > 0]
    assert all(isinstance(pair.logs, NotComputed) and pair.n_logs == 0 for pair in with_zero)
    assert all(pair.ranks.p == pytest.approx(2 / 2**12) and pair.n == 12 for pair in with_zero)
    assert all(pair.logs.df == 11 for pair in others)
    assert omnibus.friedman(data).n == 12


def test_eight_of_twelve_zeros_are_told_apart_by_wilcoxon_on_all_twelve():
    """Four people with logarithms at both: t on them says p > .1; ranks of all twelve, .008."""
    low = [0] * 8 + [9.0, 10.0, 14.0, 11.0]
    high = [6.0, 7, 8, 9, 10, 11, 12, 13, 12.0, 9.0, 16.0, 10.0]
    pair = pairwise(ready(np.column_stack([low, high])))[0]
    assert (pair.n, pair.n_logs) == (12, 4)
    assert pair.logs.p > 0.1
    assert pair.ranks.p < 0.01
    text = apa.pairwise_ranks([pair], 0.95, PLATE_AMPLITUDE)
    assert text.startswith(
        "Estimates differed between the two amplitudes (Wilcoxon signed-rank test"
    )
    assert "of 12 participants" in text


def test_a_zero_takes_its_participant_out_of_its_own_pairs_only(values):
    values[0, 0] = 0
    pairs = {(pair.from_level, pair.to_level): pair for pair in pairwise(ready(values))}
    assert pairs[0.0, 2.3].n_logs == 11
    assert pairs[0.5, 2.3].n_logs == 12
    assert {pair.n for pair in pairs.values()} == {12}


def test_the_zero_rule_refuse_leaves_the_tests_on_ranks(values):
    values[0, 0] = 0
    pairs = pairwise(ready(values, zero_rule="refuse"))
    assert all("refuse" in pair.logs.reason for pair in pairs)
    assert all(pair.ranks.p < 0.05 for pair in pairs)


def test_the_primary_analysis_is_on_ranks_of_everybody_unless_the_study_declares_otherwise(
    table_by_hand, page, values
):
    from slipscale.analysis.pipeline import analyse

    values[:5, 0] = 0
    lines = [
        f"p{who:02d},{amplitude},{value:.3f}"
        for who, row in enumerate(values)
        for amplitude, value in zip(AMPLITUDES, row, strict=True)
    ]
    text = "participant_id,amplitude_um_pp,estimate\n" + "\n".join(lines) + "\n"
    found = analyse(table_by_hand(text))
    first = primary.primary_sentences(found.inference, "ranks", 0.95, PLATE_AMPLITUDE)
    assert "Friedman" in first[0]
    assert "n = 12" in first[0]
    asked = (found.inference, "logarithms", 0.95, PLATE_AMPLITUDE)
    assert "F(" in primary.primary_sentences(*asked)[0]
    assert (
        "n = 7 of 12"
        in primary.secondary_sentences(found.inference, "ranks", 0.95, PLATE_AMPLITUDE)[0]
    )
    html = page(found)
    summary = html[html.index("<b>Answer.</b>") : html.index("<b>Design.</b>")]
    assert "Estimates of zero: 5" in summary
    assert summary.index("Friedman") < summary.index("Estimates of zero: 5")
