"""Effects of order (drift, carry-over) and test-retest reliability."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from analysis.preprocessing.residuals import residuals, slopes_per_participant
from analysis.preprocessing.sufficiency import TINY
from analysis.statistics.confidence_interval import ConfidenceInterval
from analysis.statistics.mean_over_participants import mean_over_participants
from analysis.statistics.not_computed import NotComputed
from experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from collections.abc import Mapping

    from analysis.preprocessing.log_transform import Prepared
    from analysis.statistics.mean_over_participants import MeanOverParticipants

#: Reliability is computed on at most this many targets (participant x amplitude).
TARGETS_AT_MOST = 2000


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderEffects:
    """Participants' mean slopes of residual log estimates.

    Parameters
    ----------
    log_slope_per_trial : MeanOverParticipants or NotComputed
        On the trial's position: drift.
    log_slope_per_um_pp_before : MeanOverParticipants or NotComputed
        On the amplitude of the surface before, µm peak to peak: carry-over.
    """

    log_slope_per_trial: MeanOverParticipants | NotComputed
    log_slope_per_um_pp_before: MeanOverParticipants | NotComputed


@dataclass(frozen=True, slots=True, kw_only=True)
class IntraclassCorrelation:
    """One of Shrout and Fleiss's six coefficients."""

    value: float
    interval: ConfidenceInterval


@dataclass(frozen=True, slots=True, kw_only=True)
class Reliability:
    """Intraclass correlations over repetitions.

    Parameters
    ----------
    icc : Mapping
        ICC1, ICC2, ICC3, ICC1k, ICC2k, ICC3k -> coefficient, with a 95 % interval.
    targets : int
        Pairs of participant and amplitude.
    repetitions : int
        Estimates of each.
    """

    icc: Mapping[str, IntraclassCorrelation]
    targets: int
    repetitions: int


def order(data: Prepared) -> OrderEffects | NotComputed:
    """Test whether estimates drift with the trial's position, or follow the surface before.

    Each participant's slope of the residual (log estimate less participants' and amplitudes'
    means) on the position and on the previous amplitude (where that was no texture's); the mean
    slope against 0, Student's t.
    """
    if data.refused:
        return NotComputed(data.zero_sentence)
    trials = data.trials
    left = residuals(trials, data.logs)
    codes = data.logs.index.get_indexer(pd.Index(trials[PARTICIPANT]))
    people = len(data.logs)
    before = trials.groupby([PARTICIPANT, "session", "run"], observed=True)[
        "amplitude_um_pp"
    ].shift()
    if "after_texture" in trials:
        before = before.mask(trials["after_texture"])
    by_position, by_before = (
        mean_over_participants(
            slopes_per_participant(codes, x.to_numpy(float), left, people), data.choices.confidence
        )
        for x in (trials["position"], before)
    )
    return OrderEffects(log_slope_per_trial=by_position, log_slope_per_um_pp_before=by_before)


def reliability(data: Prepared) -> Reliability | NotComputed:
    """Intraclass correlations of log estimates over repetitions (Shrout and Fleiss 1979).

    Targets are participant-amplitude pairs, raters are repetitions; pingouin's. Participants
    with different numbers of repetitions are cut to the smallest.
    """
    import pingouin  # noqa: PLC0415 - a second's import

    if data.refused:
        return NotComputed(data.zero_sentence)
    target = [PARTICIPANT, "amplitude_um_pp"]
    usable = data.trials[data.trials["log"].notna()]
    counts = usable.groupby(target, observed=True).size()
    repeated = counts[counts >= 2]  # noqa: PLR2004
    if len(repeated) < 2:  # noqa: PLR2004
        return NotComputed("no repetitions: reliability needs two estimates of a surface or more")
    fewest = int(repeated.min())
    rows = usable[usable["repetition"] <= fewest]
    targets = rows.groupby(target, observed=True).ngroup().to_numpy()
    whole = np.flatnonzero(np.bincount(targets) == fewest)[:TARGETS_AT_MOST]
    kept = np.isin(targets, whole)
    long = rows.loc[kept, ["repetition", "log"]].assign(target=targets[kept])
    if len(whole) < 5 or np.ptp(long["log"]) == 0:  # noqa: PLR2004
        return NotComputed("too few repeated estimates, or all the same")
    around = long["log"] - long.groupby("target")["log"].transform("first")
    if around.abs().max() <= TINY:
        return NotComputed(
            "every repetition gave the same estimate: no spread within to compare with"
        )
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", category=pd.errors.Pandas4Warning)
        table = pingouin.intraclass_corr(
            data=long, targets="target", raters="repetition", ratings="log"
        )
    names = ("ICC1", "ICC2", "ICC3", "ICC1k", "ICC2k", "ICC3k")
    interval = next(name for name in table.columns if name.startswith("CI"))
    return Reliability(
        icc={
            name: IntraclassCorrelation(
                value=float(row["ICC"]),
                interval=ConfidenceInterval(*(float(bound) for bound in row[interval])),
            )
            for name, (_, row) in zip(names, table.iterrows(), strict=True)
        },
        targets=len(whole),
        repetitions=fewest,
    )
