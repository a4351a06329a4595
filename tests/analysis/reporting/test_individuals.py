"""Each participant's own results."""

import re

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reporting.files import write_analysis
from slipscale.analysis.reporting.individuals import individuals
from slipscale.analysis.statistics.not_computed import NotComputed

pytestmark = pytest.mark.usefixtures("without_models")


def test_every_participant_has_an_exponent_and_a_d_prime_of_their_own(dataset, page, tmp_path):
    row = dataset.difference_row
    people = {
        f"{n:02d}": [row(1, 2.3, 1.2, "yes"), row(2, 1.2, 1.2, "yes" if n == 4 else "no")]
        for n in range(1, 7)
    }
    analysis = analyse(dataset(differences=people))
    write_analysis(analysis, tmp_path)
    own = pd.read_csv(tmp_path / "individuals.csv").set_index("participant_id")
    assert list(own.index) == [f"sub-{n:02d}" for n in range(1, 7)]
    cells = analysis.cells.loc["sub-03", [0.5, 1.2, 2.3]]
    logs = analysis.prepared.logs.loc["sub-03", [0.5, 1.2, 2.3]]
    line = stats.linregress(np.log(cells.index.to_numpy(float)), logs)
    assert own.loc["sub-03", "exponent"] == pytest.approx(line.slope)
    assert own.loc["sub-03", "estimate_at_1_um_pp"] == pytest.approx(np.exp(line.intercept))
    assert own["exponent"].mean() == pytest.approx(analysis.inference.power_law.exponent)
    assert own.loc["sub-04", ["hits", "changes", "false_alarms", "catches"]].tolist() == [1] * 4
    assert own.loc["sub-04", "d_prime"] == pytest.approx(0)
    text = page(analysis)
    assert "Results of each participant." in text
    assert "0/1" in text


def test_a_participant_of_one_task_has_no_values_of_the_other(dataset, page):
    row = dataset.difference_row
    people = {f"{n:02d}": [row(1, 2.3, 1.2, "yes"), row(2, 1.2, 1.2, "no")] for n in range(1, 7)}
    folder = dataset(differences=people)
    next(folder.glob("sub-02/beh/*difference*_beh.tsv")).unlink()
    analysis = analyse(folder)
    own = individuals(analysis.prepared, analysis.inference).set_index("participant_id")
    assert np.isnan(own.loc["sub-02", "d_prime"])
    assert own["d_prime"].notna().sum() == 5
    assert own["exponent"].notna().all()
    assert not re.search(r"\bnan\b", page(analysis))


def test_where_nothing_is_known_of_anybody_there_is_no_table(table_by_hand, page):
    path = table_by_hand("participant_id,amplitude_um_pp,estimate\na,0,1\na,1,3\nb,0,1\nb,1,2\n")
    analysis = analyse(path)
    assert not len(individuals(analysis.prepared, analysis.inference))
    assert "Results of each participant." not in page(analysis)


def test_one_participant_s_exponent_is_theirs_though_a_mean_needs_three(table_by_hand):
    path = table_by_hand("participant_id,amplitude_um_pp,estimate\na,0,1\na,1,3\na,2,6\n")
    analysis = analyse(path)
    own = individuals(analysis.prepared, analysis.inference)
    assert own["exponent"].tolist() == pytest.approx([1.0])
    assert isinstance(analysis.inference.power_law, NotComputed)
