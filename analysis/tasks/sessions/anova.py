"""Compute the analysis of variance of magnitude estimates with factors session and amplitude."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.preprocessing.normalisation import cell_means
from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few
from slipscale.analysis.statistics.effect_sizes import eta2_interval, eta2_of
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.groups.statistics import Effect

if TYPE_CHECKING:
    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.stimuli.quantity import Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionAnova:
    """Analysis of variance of mean log estimates, both factors within participants.

    Parameters
    ----------
    n : int
        Participants with a logarithm at every amplitude of every session.
    session, amplitude, interaction : Effect
        Degrees of freedom include Greenhouse and Geisser's correction.
    """

    n: int
    session: Effect
    amplitude: Effect
    interaction: Effect


def session_logs(prepared: Prepared) -> dict[str, pd.DataFrame]:
    """Return mean logarithms, participants by amplitudes, of each session."""
    labels = prepared.trials["session"].astype(str)
    return {
        str(label): cell_means(rows, "log").reindex(columns=prepared.logged)
        for label, rows in prepared.trials.groupby(labels)
    }


def session_anova(
    prepared: Prepared | None, sessions: list[str], confidence: float
) -> SessionAnova | NotComputed:
    """Test sessions and amplitudes together.

    Uses pingouin, which agrees with R in sums of squares and epsilons if every cell is present.

    Parameters
    ----------
    prepared : Prepared or None
        Magnitude estimates.
    sessions : list of str
        Sessions to compare.
    confidence : float
        Level of the intervals of effect sizes.
    """
    if prepared is None:
        return NotComputed("no magnitude estimates")
    if prepared.refused:
        return NotComputed(prepared.zero_sentence)
    if len(prepared.logged) < 2:  # noqa: PLR2004
        return NotComputed(few(prepared.quantity.levels, len(prepared.logged), 2))
    logs = session_logs(prepared)
    if any(label not in logs for label in sessions):
        return NotComputed("some session has no magnitude estimates")
    whole = pd.concat({label: logs[label] for label in sessions}, axis=1).dropna()
    why = _lacking(whole, prepared.quantity)
    return NotComputed(why) if why else _within(whole, confidence)


def _lacking(whole: pd.DataFrame, quantity: Quantity) -> str:
    """Return why a table of participants by sessions and amplitudes allows no test, if so."""
    if len(whole) < FEWEST:
        return few(f"participants with every {quantity.level} in every session", len(whole))
    residuals = whole.to_numpy(float) - whole.to_numpy(float).mean(axis=0)
    if np.abs(residuals - residuals.mean(axis=1, keepdims=True)).max() <= TINY:
        return f"no variance is left beside participants', sessions' and {quantity.levels}' means"
    return ""


def _within(whole: pd.DataFrame, confidence: float) -> SessionAnova:
    import pingouin  # noqa: PLC0415 - a second's import

    n = len(whole)
    long = pd.DataFrame(
        {
            "who": np.repeat(np.arange(n), whole.shape[1]),
            "session": np.tile(whole.columns.get_level_values(0).to_numpy(), n),
            "amplitude": np.tile(whole.columns.get_level_values(1).to_numpy(float), n),
            "value": whole.to_numpy(float).ravel(),
        }
    )
    with warnings.catch_warnings():
        # Only pingouin's warning on pandas 3 (dropna in place).
        warnings.filterwarnings("ignore", category=pd.errors.Pandas4Warning)
        found = pingouin.rm_anova(
            data=long,
            dv="value",
            within=["session", "amplitude"],
            subject="who",
            detailed=True,
            effsize="np2",
        )
    session, amplitude, interaction = (
        _effect(found.iloc[place], confidence) for place in range(len(found))
    )
    return SessionAnova(n=n, session=session, amplitude=amplitude, interaction=interaction)


def _effect(row: pd.Series[float], confidence: float) -> Effect:
    from scipy import stats  # noqa: PLC0415

    epsilon = float(row["eps"])
    f, df1, df2 = float(row["F"]), float(row["ddof1"]) * epsilon, float(row["ddof2"]) * epsilon
    return Effect(
        F=f,
        df1=df1,
        df2=df2,
        p=float(stats.f.sf(f, df1, df2)),
        eta2_partial=eta2_of(f, df1, df2),
        eta2_partial_interval=eta2_interval(f, df1, df2, confidence),
    )
