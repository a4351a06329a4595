"""What order and repetition tell: drift, carry-over, test-retest reliability."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis.preprocessing.residuals import residuals, slopes_per_participant
from analysis.preprocessing.sufficiency import TINY
from analysis.statistics.omnibus import Result, mean_with_interval, reason
from experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from analysis.preprocessing.log_transform import Prepared

#: Reliability is computed on at most this many targets (participant x amplitude).
TARGETS_AT_MOST = 2000


def order(data: Prepared) -> Result:
    """Test whether estimates drift with the trial's position, or follow the surface before.

    Each participant's slope of the residual (log estimate less participants' and amplitudes'
    means) on the position and on the previous amplitude (where that was no texture's); the mean
    slope against 0, Student's t.
    """
    if data.refused:
        return reason(data.zero_sentence)
    trials = data.trials
    left = residuals(trials, data.logs)
    codes = data.logs.index.get_indexer(pd.Index(trials[PARTICIPANT]))
    people = len(data.logs)
    before = trials.groupby([PARTICIPANT, "session", "run"], observed=True)[
        "amplitude_um_pp"
    ].shift()
    if "after_texture" in trials:
        before = before.mask(trials["after_texture"])
    found: dict[str, Any] = {}
    for name, unit, x in (
        ("position", "natural logarithm per trial", trials["position"].to_numpy(float)),
        ("carry_over", "natural logarithm per um_pp", before.to_numpy(float)),
    ):
        slopes = slopes_per_participant(codes, x, left, people)
        found[name] = {"unit": unit, **mean_with_interval(slopes, data.choices.confidence)}
    return found


def reliability(data: Prepared) -> Result:
    """Intraclass correlations of log estimates over repetitions (Shrout and Fleiss 1979).

    Targets are participant-amplitude pairs, raters are repetitions; pingouin's. Participants
    with different numbers of repetitions are cut to the smallest.
    """
    import pingouin  # noqa: PLC0415 - a second's import

    if data.refused:
        return reason(data.zero_sentence)
    target = [PARTICIPANT, "amplitude_um_pp"]
    usable = data.trials[data.trials["log"].notna()]
    counts = usable.groupby(target, observed=True).size()
    repeated = counts[counts >= 2]  # noqa: PLR2004
    if len(repeated) < 2:  # noqa: PLR2004
        return reason("no repetitions: reliability needs two estimates of a surface or more")
    fewest = int(repeated.min())
    rows = usable[usable["repetition"] <= fewest]
    targets = rows.groupby(target, observed=True).ngroup().to_numpy()
    whole = np.flatnonzero(np.bincount(targets) == fewest)[:TARGETS_AT_MOST]
    kept = np.isin(targets, whole)
    long = rows.loc[kept, ["repetition", "log"]].assign(target=targets[kept])
    if len(whole) < 5 or np.ptp(long["log"]) == 0:  # noqa: PLR2004
        return reason("too few repeated estimates, or all the same")
    around = long["log"] - long.groupby("target")["log"].transform("first")
    if around.abs().max() <= TINY:
        return reason("every repetition gave the same estimate: no spread within to compare with")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", category=pd.errors.Pandas4Warning)
        table = pingouin.intraclass_corr(
            data=long, targets="target", raters="repetition", ratings="log"
        )
    names = ("ICC1", "ICC2", "ICC3", "ICC1k", "ICC2k", "ICC3k")
    interval = next(name for name in table.columns if name.startswith("CI"))
    return {
        "icc": {
            name: {
                "value": float(row["ICC"]),
                "ci95": [float(bound) for bound in row[interval]],
            }
            for name, (_, row) in zip(names, table.iterrows(), strict=True)
        },
        "targets": len(whole),
        "repetitions": fewest,
    }
