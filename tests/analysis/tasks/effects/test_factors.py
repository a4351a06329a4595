"""A factor crossed with the levels: as base R and lme4 have it, from tables and from data sets."""

import re
import shutil
import subprocess

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import slipscale
from slipscale.analysis.export.files import write_export
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.analysis.tasks.effects.factors.declaration import sentences
from slipscale.analysis.tasks.effects.factors.statistics import FACTORS
from slipscale.analysis.tasks.thresholds.reading import TRIALS

#: By R 4.2.2 of the table below: `anova(lm(M ~ 1), M = ~speed, X = ~1, test = "Spherical")` and so
#: on; F, p after Greenhouse and Geisser.
R = {
    "factor": (25.246, 0.00010193),
    "of_level": (862.81, 1.0016e-24),
    "interaction": (2.5635, 0.053586),
}
#: lme4's `ly ~ lx * speed + (1 + lx + speed | who)`: estimate and standard error.
LME4 = {
    ("medium", "mixed_log_ratio"): (-0.178661412, 0.079736896),
    ("slow", "mixed_log_ratio"): (-0.459252449, 0.069267739),
    ("medium", "mixed_exponent"): (-0.079937506, 0.033500100),
    ("slow", "mixed_exponent"): (-0.106646359, 0.033500100),
}
COLUMNS = {"participant": "who", "stimulus": "period", "response": "rough", "factor": "speed"}


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    rng = np.random.default_rng(4)
    rows = []
    for person in range(10):
        scale, exponent = rng.normal(3, 0.5), rng.normal(0.6, 0.1)
        louder = {"slow": 0, "medium": rng.normal(0.2, 0.1), "fast": rng.normal(0.4, 0.15)}
        steeper = {"slow": 0, "medium": 0.05, "fast": 0.15}
        for speed, more in louder.items():
            for period in (0.5, 1.2, 2.3, 4.0):
                for _ in range(3):
                    log = scale + more + (exponent + steeper[speed]) * np.log(period)
                    rough = float(np.exp(log + rng.normal(0, 0.2)))
                    rows.append((f"p{person}", speed, period, round(rough, 3)))
    path = tmp_path_factory.mktemp("factors") / "rough.csv"
    pd.DataFrame(rows, columns=["who", "speed", "period", "rough"]).to_csv(path, index=False)
    return path


@pytest.fixture(scope="module")
def analysis(table):
    return analyse(load(table, parse_mapping({"columns": COLUMNS}, "here")))


def test_the_analysis_of_variance_is_r_s(analysis):
    (found,) = analysis.inference[FACTORS]
    assert found.factor == "speed"
    assert found.anova.n == 10
    for name, (f, p) in R.items():
        effect = getattr(found.anova, name)
        assert (effect.F, effect.p) == pytest.approx((f, p), rel=1e-4)


def test_the_mixed_model_is_lme4_s(analysis):
    (found,) = analysis.inference[FACTORS]
    changes = {each.condition: each for each in found.changes}
    for (condition, what), (value, se) in LME4.items():
        fitted = getattr(changes[condition], what)
        assert fitted.value == pytest.approx(value, rel=1e-5)
        # The random effects' correlations are at their bound, where optimisers stop differently.
        assert fitted.se == pytest.approx(se, rel=0.01)
        # Student's t with 9 degrees of freedom for 10 people; 2.262157 is its 97.5 % quantile.
        ends = fitted.value - 2.262157 * fitted.se, fitted.value + 2.262157 * fitted.se
        assert tuple(fitted.interval) == pytest.approx(ends, abs=1e-6)
        assert fitted.p == pytest.approx(2 * stats.t.sf(abs(fitted.value / fitted.se), 9))
    # Balanced data: a participant's own changes have the same mean.
    assert changes["slow"].exponent.mean == pytest.approx(LME4["slow", "mixed_exponent"][0], 1e-5)


def test_a_fit_at_a_bound_is_named_as_in_the_exported_script(analysis, page, tmp_path):
    """lme4's fit is singular as well; the number is its log likelihood."""
    (found,) = analysis.inference[FACTORS]
    assert found.mixed.log_likelihood_reml == pytest.approx(15.704493, abs=1e-3)
    assert found.mixed.at_bound
    assert (
        "In the mixed model, an estimated variance or correlation is on the boundary of its range."
        in page(analysis)
    )
    write_export(analysis, tmp_path, ["scripts"])
    if shutil.which("Rscript"):
        command = ["Rscript", tmp_path / "recompute.R"]
        told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        assert "speed: an estimated variance or correlation is on the boundary of its range" in told
        numbers = re.findall(r"^factors\S+ +\S+ +\S+$", told, re.MULTILINE)
        assert len(numbers) > 60
        assert "not recomputed: factors" not in told


def test_the_report_names_conditions_and_what_they_change(analysis, page):
    text = page(analysis)
    assert "speed and period as within-participant factors (n = 10" in text
    assert "Speed slow compared with fast: geometric means differed (ratio 0.63" in text


def test_levels_are_reported_with_the_unit_of_their_factor(table, tmp_path):
    rows = pd.read_csv(table).rename(columns={"speed": "finger_speed_mm_s"})
    rows["finger_speed_mm_s"] = rows["finger_speed_mm_s"].map({"slow": 5, "medium": 10, "fast": 20})
    path = tmp_path / "units.csv"
    rows.to_csv(path, index=False)
    columns = {"columns": COLUMNS | {"factor": "finger_speed_mm_s"}}
    told = " ".join(sentences(analyse(load(path, parse_mapping(columns, "here")))))
    assert "with finger speed and period as within-participant factors" in told
    assert "Finger speed 20 mm/s compared with 5 mm/s: " in told


def test_conditions_that_are_numbers_are_in_their_order(table, tmp_path):
    rows = pd.read_csv(table)
    rows["speed"] = rows["speed"].map({"slow": 5, "medium": 10, "fast": 100})
    path = tmp_path / "numbers.csv"
    rows[rows["who"] < "p3"].to_csv(path, index=False)
    (found,) = analyse(load(path, parse_mapping({"columns": COLUMNS}, "here"))).inference[FACTORS]
    assert [each.condition for each in found.conditions] == ["5", "10", "100"]


def test_the_factors_of_a_study_are_columns_of_its_data(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(
        'name = "two"\ntitle = "Two"\nseed = 1\nparticipants = 3\n'
        "amplitudes_um_pp = [0.5, 1.2, 2.3]\n"
        '[[factors]]\nname = "hand"\nlevels = ["left", "right"]\n'
        '[[tasks]]\nprotocol = "magnitude_estimation"\nrepetitions = 1\n'
        '[[tasks]]\nprotocol = "constant_stimuli"\nstandard_um_pp = 1.2\n'
        "comparisons_um_pp = [0.9, 1.5]\nrepetitions = 2\n"
        '[analysis]\ntests = ["factors"]\n',
        encoding="utf-8",
    )
    analysis = slipscale.pilot(study, folder=tmp_path / "d")
    hands = analysis.dataset.of(TRIALS).groupby("factor: hand").size()
    assert hands.to_dict() == {"left": 12, "right": 12}
    (found,) = analysis.inference[FACTORS]
    assert found.factor == "hand"
    assert [each.condition for each in found.conditions] == ["left", "right"]
    assert found.anova.n == 3


def test_every_mean_has_its_own_n_and_none_is_of_one_condition_only(table, tmp_path, page):
    rows = pd.read_csv(table)
    gone = (rows["who"] == "p3") & (rows["speed"] == "slow") & (rows["period"] == 4.0)
    rows[~gone].to_csv(tmp_path / "rough.csv", index=False)
    found = analyse(load(tmp_path / "rough.csv", parse_mapping({"columns": COLUMNS}, "here")))
    (effects,) = found.inference[FACTORS]
    ns = {each.condition: tuple(each.ns.values()) for each in effects.conditions}
    assert ns == {"fast": (10, 10, 10, 10), "medium": (10,) * 4, "slow": (10, 10, 10, 9)}
    assert re.search(r"<td>[\d.]+ \(n = 9\)</td>", page(found))
    # The pooled means: plain arithmetic, with equal weight of every condition.
    by_condition = rows[~gone].pivot_table("rough", ["who", "period"], "speed")
    pooled = by_condition.mean(axis=1, skipna=False).groupby("period")
    share = 100 / rows[~gone].groupby(["who", "period"])["rough"].mean().to_numpy().max()
    assert list(found.table3["n"]) == [10, 10, 10, 9] == list(pooled.count())
    ours = found.table3["mean"].to_numpy()
    assert ours / ours[0] == pytest.approx(pooled.mean().to_numpy() / pooled.mean().iloc[0])
    assert ours[0] == pytest.approx(share * pooled.mean().iloc[0], rel=0.02)
    (said,) = [text for text in found.problems if "did not judge it in every condition" in text]
    assert "at 4 are without p3," in said


def test_conditions_that_nobody_has_all_of_leave_each_person_s_own(table, tmp_path):
    rows = pd.read_csv(table)
    fast = rows["who"].isin([f"p{n}" for n in range(5)])
    own = rows[fast == (rows["speed"] == "fast")]
    own.to_csv(tmp_path / "rough.csv", index=False)
    found = analyse(load(tmp_path / "rough.csv", parse_mapping({"columns": COLUMNS}, "here")))
    assert list(found.table3["n"]) == [10, 10, 10, 10]
