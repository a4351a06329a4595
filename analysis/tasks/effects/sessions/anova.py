"""Analyse magnitude estimates by session and amplitude in a two-way analysis of variance."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.preprocessing.normalisation import cell_means
from slipscale.analysis.preprocessing.sufficiency import few
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.repeated_measures.two_way import Effect, two_way


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionAnova:
    """Analysis of variance of mean log estimates, with both factors within participants.

    Parameters
    ----------
    n : int
        Number of participants with a mean log estimate at every amplitude in every session.
    session, amplitude, interaction : Effect
        Effects with Greenhouse-Geisser-corrected degrees of freedom.
    """

    n: int
    session: Effect
    of_level: Effect
    interaction: Effect


def session_logs(prepared: Prepared) -> dict[str, pd.DataFrame]:
    """Return mean log estimates (participants by amplitudes) for each session."""
    labels = prepared.trials["session"].astype(str)
    return {
        str(label): cell_means(rows, "log").reindex(columns=prepared.logged)
        for label, rows in prepared.trials.groupby(labels)
    }


def session_anova(
    prepared: Prepared | None, sessions: list[str], confidence: float
) -> SessionAnova | NotComputed:
    """Test the effects of session and amplitude and their interaction.

    Parameters
    ----------
    prepared : Prepared or None
        Magnitude estimates.
    sessions : list of str
        Sessions to compare.
    confidence : float
        Confidence level of the effect-size intervals.
    """
    if prepared is None:
        return NotComputed("no magnitude estimates")
    if prepared.refused:
        return NotComputed(prepared.zero_sentence)
    if len(prepared.logged) < 2:  # noqa: PLR2004
        return NotComputed(few(prepared.quantity.levels, len(prepared.logged), 2))
    logs = session_logs(prepared)
    if any(label not in logs for label in sessions):
        return NotComputed("at least one session has no magnitude estimates")
    whole = pd.concat({label: logs[label] for label in sessions}, axis=1).dropna()
    found = two_way(whole, confidence, f"every {prepared.quantity.level} in every session")
    if isinstance(found, NotComputed):
        return found
    session, amplitude, interaction = found
    return SessionAnova(n=len(whole), session=session, of_level=amplitude, interaction=interaction)
