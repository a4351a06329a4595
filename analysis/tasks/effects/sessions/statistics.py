"""Analyse differences between sessions, and test-retest agreement."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import pandas as pd

from slipscale.analysis.json_form import renamed
from slipscale.analysis.preprocessing.sessions import sessions_of
from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few
from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    holm_of,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.reliability import IntraclassCorrelation
from slipscale.analysis.statistics.statistic import Family, Inputs, Named, Statistic
from slipscale.analysis.tasks.effects.sessions.anova import SessionAnova, session_anova


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionChange:
    """A change from the first session to a later session.

    Parameters
    ----------
    session : str
    change : MeanOverParticipants or NotComputed
        Mean difference across participants, this session minus the first session.
    p_holm : float or None
        p-value, Holm-corrected across all changes in all measures.
    """

    session: str
    change: MeanOverParticipants | NotComputed
    p_holm: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionMeasure:
    """Comparison of one measure across sessions.

    Parameters
    ----------
    name, unit : str
        Name and unit of the measure.
    n : int
        Number of participants with a value in every session.
    means : tuple of float
        Mean across these participants in each session.
    changes : tuple of SessionChange
        Change from the first session to each later session.
    agreement : IntraclassCorrelation or NotComputed
        Test-retest reliability as ICC(A,1), the absolute agreement of single sessions.
    table : DataFrame
        Values of the measure. Rows are the ``n`` participants, and columns are sessions. Not
        included in JSON.
    """

    name: str
    unit: str
    n: int
    means: tuple[float, ...]
    changes: tuple[SessionChange, ...]
    agreement: IntraclassCorrelation | NotComputed
    table: pd.DataFrame = field(compare=False)

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, table="")


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionEffects:
    """All differences between sessions.

    Parameters
    ----------
    sessions : tuple of str
        Session labels, in order.
    anova : SessionAnova or NotComputed
        Analysis of variance of magnitude estimates.
    measures : tuple of SessionMeasure
        Measures of all tasks.
    """

    sessions: tuple[str, ...]
    anova: SessionAnova | NotComputed
    measures: tuple[SessionMeasure, ...]


def session_effects(inputs: Inputs) -> SessionEffects | NotComputed:
    """Return the differences between sessions, or NotComputed for fewer than two sessions."""
    data, prepared = inputs.data, inputs.prepared
    sessions = sessions_of(data)
    if len(sessions) < 2:  # noqa: PLR2004
        return NotComputed("there is only one session")
    confidence = data.choices.confidence
    measures = [
        _measure(name, unit, table.reindex(columns=sessions).dropna(), confidence)
        for name, unit, table in inputs.session_tables()
    ]
    return SessionEffects(
        sessions=tuple(sessions),
        anova=session_anova(prepared, sessions, confidence),
        measures=_corrected(measures),
    )


def _measure(name: str, unit: str, table: pd.DataFrame, confidence: float) -> SessionMeasure:
    values = table.to_numpy(float)
    return SessionMeasure(
        name=name,
        unit=unit,
        n=len(values),
        means=tuple(values.mean(axis=0).tolist()) if len(values) else (),
        changes=tuple(
            SessionChange(
                session=str(label),
                change=mean_over_participants(values[:, place] - values[:, 0], confidence),
            )
            for place, label in enumerate(table.columns)
            if place
        ),
        agreement=agreement(values, confidence),
        table=table,
    )


def _corrected(measures: list[SessionMeasure]) -> tuple[SessionMeasure, ...]:
    """Apply Holm's correction to the p-values of all changes in all measures."""
    ps = iter(holm_of([each.change for measure in measures for each in measure.changes]))
    return tuple(
        replace(
            measure,
            changes=tuple(replace(each, p_holm=next(ps)) for each in measure.changes),
        )
        for measure in measures
    )


def agreement(values: Array, confidence: float) -> IntraclassCorrelation | NotComputed:
    """Return ICC(A,1) for a participants-by-sessions table, with its interval.

    For the formulas, see McGraw and Wong (1996, Psychological Methods 1, 30-46, tables 4 and 7).
    The package pingouin is not used, because it rounds the interval to two decimals.
    """
    from scipy import stats

    n, k = values.shape
    if n < FEWEST:
        return NotComputed(few("participants with every session", n))
    rows, columns = values.mean(axis=1), values.mean(axis=0)
    residuals = values - rows[:, None] - columns + values.mean()
    between = k * rows.var(ddof=1)
    of_sessions = n * columns.var(ddof=1)
    error = float((residuals**2).sum()) / ((n - 1) * (k - 1))
    if between + of_sessions + error <= TINY:
        return NotComputed("every participant has the same value in every session")
    below = between + (k - 1) * error + k / n * (of_sessions - error)
    value = float((between - error) / below)
    if value >= 1 - TINY:
        return IntraclassCorrelation(value=value, interval=None)
    a = k * value / (n * (1 - value))
    b = 1 + k * value * (n - 1) / (n * (1 - value))
    parts = (a * of_sessions) ** 2 / (k - 1), (b * error) ** 2 / ((n - 1) * (k - 1))
    df = (a * of_sessions + b * error) ** 2 / sum(parts)
    quantile = (1 + confidence) / 2
    f_low, f_high = stats.f.ppf(quantile, n - 1, df), stats.f.ppf(quantile, df, n - 1)
    rest = k * of_sessions + (k * n - k - n) * error
    low = n * (between - f_low * error) / (f_low * rest + n * between)
    high = n * (f_high * between - error) / (rest + n * f_high * between)
    interval = ConfidenceInterval(float(low), float(high), confidence)
    return IntraclassCorrelation(value=value, interval=interval)


def _anova_ps(found: SessionEffects) -> list[float]:
    anova = found.anova
    return [anova.session.p, anova.interaction.p] if anova else []


def _change_ps(found: SessionEffects) -> list[float]:
    changes = (each.change for measure in found.measures for each in measure.changes)
    return [change.p for change in changes if isinstance(change, MeanOverParticipants)]


class _Sessions(Statistic[SessionEffects]):
    key = "sessions"
    meaning = "sessions: analysis of variance, changes between sessions, and test-retest agreement"
    title = "Sessions"
    families = (
        Family(name="sessions, analysis of variance", read=_anova_ps),
        Family(name="changes from the first session", corrected=True, read=_change_ps),
    )
    methods = (
        "Sessions were compared in an analysis of variance of mean log estimates with session and "
        "{q.name} as within-participant factors and the Greenhouse–Geisser correction "
        "[[greenhouse1959]], and through each participant's change from the first session, with "
        "Holm's correction across all changes [[holm1979]]; agreement between sessions is the "
        "intraclass correlation ICC(A,1) [[mcgraw1996]]."
    )
    conclusions = (
        Named("anova.session.p", "sessions differ (analysis of variance)"),
        Named("anova.of_level.p", "{q.levels} differ (analysis of variance with sessions)"),
        Named("anova.interaction.p", "session differences depend on {q.level} (interaction)"),
        Named("measures.*.changes.*.p_holm", "{0}: session {1} differs from the first"),
    )
    headlines = (Named("measures.*.agreement.value", "{0}: ICC(A,1) between sessions"),)

    compute = staticmethod(session_effects)


SESSIONS = _Sessions()
