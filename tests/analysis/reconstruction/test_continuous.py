"""Continuous values and logarithms: a true test is never impossible, a far one never possible."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from scipy import stats

from slipscale import commands
from slipscale.analysis.reconstruction.inference.interval_tests import answer
from slipscale.analysis.reconstruction.table.table_files import from_toml
from slipscale.analysis.statistics.repeated_measures import batched
from slipscale.faults import UserError

KINDS = ("paired_t", "independent_t", "welch_t", "one_way_f", "rm_f", "correlation")


def printed_table(columns, kind, *, logarithms, statistic):
    """A file with what a paper prints of raw values, shape (columns, n)."""
    text = ["[scale]", "continuous = true"]
    for j, x in enumerate(columns):
        text += ["[[column]]", f'label = "c{j}"', f"n = {len(x)}"]
        if logarithms:
            text.append(f'geometric_mean = "{np.exp(np.log(x).mean()):.2f}"')
            text.append(f'log_sd = "{np.log10(x).std(ddof=1):.3f}"')
        else:
            text += [f'mean = "{x.mean():.2f}"', f'sd = "{x.std(ddof=1):.2f}"']
    return "\n".join([*text, "[[test]]", f'kind = "{kind}"', f'statistic = "{statistic:.2f}"'])


def statistic_of(kind, columns):
    if kind == "rm_f":
        return float(batched.repeated_measures_f(columns.T[None])[0])
    found = {
        "paired_t": lambda: stats.ttest_rel(columns[1], columns[0]),
        "independent_t": lambda: stats.ttest_ind(columns[1], columns[0]),
        "welch_t": lambda: stats.ttest_ind(columns[1], columns[0], equal_var=False),
        "one_way_f": lambda: stats.f_oneway(*columns),
        "correlation": lambda: stats.pearsonr(columns[0], columns[1]),
    }[kind]()
    return float(found.statistic)


@settings(max_examples=60, deadline=None)
@given(
    kind=st.sampled_from(KINDS),
    seed=st.integers(0, 10**6),
    n=st.integers(5, 20),
    logarithms=st.booleans(),
)
def test_what_raw_data_print_is_possible_and_comes_with_values_that_print_it(
    kind, seed, n, logarithms
):
    random = np.random.default_rng(seed)
    k = 3 if kind in ("rm_f", "one_way_f") else 2
    own = random.normal(0, 0.4, n)
    x = np.exp(3 + 0.5 * np.arange(k)[:, None] + own + random.normal(0, 0.3, (k, n)))
    values = np.log(x) if logarithms else x
    true = statistic_of(kind, values)
    table = from_toml(printed_table(x, kind, logarithms=logarithms, statistic=true))
    found = answer(table.tests[0], table.intervals)
    assert found.verdict == "possible"
    assert found.low - 1e-9 <= abs(true) <= found.high + 1e-9 or kind == "correlation"
    shown = np.array(found.example)
    again = statistic_of(kind, np.log(shown) if logarithms else shown)
    assert abs(abs(again) - abs(true)) <= 0.0101
    for column, row in zip(table.intervals, np.log(shown) if logarithms else shown, strict=True):
        assert column.mean[0] - 1e-9 <= row.mean() <= column.mean[1] + 1e-9
        assert column.sd[0] - 1e-9 <= row.std(ddof=1) <= column.sd[1] + 1e-9


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "correlation"])
def test_a_statistic_beyond_the_extremes_is_impossible(kind):
    x = np.array([[10.0, 12, 15, 11, 9], [14.0, 16, 15, 18, 12.5]])
    for far in (0.001, 5000.0):
        table = from_toml(printed_table(x, kind, logarithms=False, statistic=far))
        assert answer(table.tests[0], table.intervals).verdict == "impossible"


def test_an_sd_that_the_scale_does_not_allow_is_inconsistent():
    # On 0 to 10 with mean 5 and n = 5 the SD is at most 5 √(5/4) = 5.59.
    text = "[scale]\ncontinuous = true\nminimum = 0\nmaximum = 10\n[[column]]\nn = 5\n"
    (fits,) = from_toml(text + 'mean = "5.0"\nsd = "5.5"').intervals
    (too_large,) = from_toml(text + 'mean = "5.0"\nsd = "5.7"').intervals
    assert not fits.reason
    assert "at most 5.59" in too_large.reason


def test_a_standard_error_and_an_interval_give_the_same_sd():
    half = stats.t.ppf(0.975, 15) * 0.5
    text = "[scale]\ncontinuous = true\n[[column]]\nn = 16\nmean = 5.000\n"
    by_se, by_interval = (
        from_toml(text + more).intervals[0]
        for more in (
            "se = 0.500",
            f'ci_low = "{5 - half:.3f}"\nci_high = "{5 + half:.3f}"',
        )
    )
    assert by_se.sd == pytest.approx((1.998, 2.002))
    assert by_interval.sd[0] < 2 < by_interval.sd[1]


@pytest.mark.parametrize(
    "old, new, said",
    [
        ("continuous = true", "continuous = true\nstep = 1", "no step: omit step"),
        ("sd = 2.0", "", "expected an sd, an se or a confidence interval"),
        ("sd = 2.0", "sd = 2.0\nmedian = 5", "omit median"),
        ("mean = 5.0", "geometric_mean = 5.0", "geometric_mean and log_sd must be given together"),
        ("sd = 2.0", "geometric_mean = 4.0\nlog_sd = 0.1", "omit mean, sum and sd"),
    ],
)
def test_what_continuous_values_cannot_have_is_refused(old, new, said):
    text = "[scale]\ncontinuous = true\n[[column]]\nn = 5\nmean = 5.0\nsd = 2.0\n"
    with pytest.raises(UserError, match=said):
        from_toml(text.replace(old, new))


def test_the_command_answers_for_geometric_means(tmp_path, capsys):
    x = np.exp(np.random.default_rng(1).normal([[3], [3.6]], 0.5, (2, 12)))
    true = statistic_of("paired_t", np.log(x))
    path = tmp_path / "table.toml"
    path.write_text(printed_table(x, "paired_t", logarithms=True, statistic=true))
    assert commands.main(["reconstruct", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    schema = Path(__file__).parents[3] / "docs" / "reference" / "reconstruct.schema.json"
    Draft202012Validator(json.loads(schema.read_text("utf-8"))).validate(found)
    assert found["tests"][0]["verdict"] == "possible"
    assert found["intervals"][0]["logarithms"] is True
    path.write_text(printed_table(x, "paired_t", logarithms=True, statistic=99))
    assert commands.main(["reconstruct", str(path)]) == 1
    assert "impossible" in capsys.readouterr().out
    assert commands.main(["reconstruct", str(path), "--sample", "3"]) == 2
    assert "--sample requires a finite number of data sets" in capsys.readouterr().err
