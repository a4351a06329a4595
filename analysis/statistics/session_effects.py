"""Sessions as a factor: do they differ, and does a participant's result come back in the next."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.preprocessing.sessions import sessions_of
from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.holm import holm
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.power_law import exponents
from slipscale.analysis.statistics.psychometrics.forced_choice import CURVE_OF
from slipscale.analysis.statistics.psychometrics.psychometric_function import Answers
from slipscale.analysis.statistics.psychometrics.thresholds import fit_threshold
from slipscale.analysis.statistics.reliability import IntraclassCorrelation
from slipscale.analysis.statistics.session_anova import session_anova, session_logs
from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.analysis.statistics.session_anova import SessionAnova

    Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionChange:
    """A session against the first.

    Parameters
    ----------
    session : str
    change : MeanOverParticipants or NotComputed
        Its value less the first session's, participant by participant.
    p_holm : float or None
        Corrected over every change of every measure.
    """

    session: str
    change: MeanOverParticipants | NotComputed
    p_holm: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionMeasure:
    """One number of a participant's session, over sessions.

    Parameters
    ----------
    name, unit : str
        What it is.
    n : int
        Participants who have it in every session.
    means : tuple of float
        Over these, session by session.
    changes : tuple of SessionChange
        One a session but the first.
    agreement : IntraclassCorrelation or NotComputed
        Test-retest: ICC(A,1), absolute agreement of single sessions.
    """

    name: str
    unit: str
    n: int
    means: tuple[float, ...]
    changes: tuple[SessionChange, ...]
    agreement: IntraclassCorrelation | NotComputed


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionEffects:
    """What sessions do.

    Parameters
    ----------
    sessions : tuple of str
        Their labels, in order.
    anova : SessionAnova or NotComputed
        Of magnitude estimates.
    measures : tuple of SessionMeasure
        Of every task.
    """

    sessions: tuple[str, ...]
    anova: SessionAnova | NotComputed
    measures: tuple[SessionMeasure, ...]


def session_effects(data: Dataset, prepared: Prepared | None) -> SessionEffects | NotComputed:
    """Return what sessions do; nothing where there are not two.

    Parameters
    ----------
    data : Dataset
        After exclusions.
    prepared : Prepared or None
        Magnitude estimates; None where there are none.
    """
    sessions = sessions_of(data)
    if len(sessions) < 2:  # noqa: PLR2004
        return NotComputed("there are not several sessions")
    confidence = data.choices.confidence
    measures = [
        _measure(name, unit, table.reindex(columns=sessions).dropna(), confidence)
        for name, unit, table in _tables(data, prepared)
    ]
    return SessionEffects(
        sessions=tuple(sessions),
        anova=session_anova(prepared, sessions, confidence),
        measures=_corrected(measures),
    )


def _tables(data: Dataset, prepared: Prepared | None) -> Iterator[tuple[str, str, pd.DataFrame]]:
    """Yield each measure's name, unit, and values: participants by sessions."""
    if prepared is not None and not prepared.refused:
        logs = session_logs(prepared)
        levels = {label: table.mean(axis=1, skipna=False) for label, table in logs.items()}
        slopes = {label: exponents(table)["exponent"] for label, table in logs.items()}
        yield "magnitude estimation, level", "mean natural logarithm", pd.DataFrame(levels)
        yield "magnitude estimation, exponent", "exponent", pd.DataFrame(slopes)
    steps = data.differences
    if len(steps):
        changed = steps[~steps["catch"]]
        table = _by_session(changed.assign(value=changed["difference_felt"].astype(float)))
        yield "descending difference, “yes” on changes", "share", table
    for task, rows in _by_task(data.forced_choices):
        yield f"{task}, threshold", "log10 µm p-p", _thresholds(rows)
    for trials, what, unit, value in (
        (data.matches, "match less reference", "µm p-p", _match_error),
        (data.ratings, "mean rating", "place on the line, 0 to 100", _rating),
        (data.ratios, "mean ratio", "natural logarithm", _log_ratio),
        (data.productions, "mean produced amplitude", "natural logarithm, µm p-p", _log_produced),
    ):
        for task, rows in _by_task(trials):
            main = rows[~rows["catch"]] if "catch" in rows else rows
            yield f"{task}, {what}", unit, _by_session(main.assign(value=value(main)))


def _match_error(rows: pd.DataFrame) -> pd.Series[float]:
    return (rows["matched_um_pp"] - rows["reference_um_pp"]).astype(float)


def _rating(rows: pd.DataFrame) -> pd.Series[float]:
    return rows["rating"].astype(float)


def _log_ratio(rows: pd.DataFrame) -> pd.Series[float]:
    return _log(rows["ratio"])


def _log_produced(rows: pd.DataFrame) -> pd.Series[float]:
    return _log(rows["produced_um_pp"])


def _log(values: pd.Series[float]) -> pd.Series[float]:
    """Return natural logarithms; of 0 there is none."""
    return pd.Series(np.log(values.where(values > 0).to_numpy(float)), index=values.index)


def _by_task(rows: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    return [(str(task), own) for task, own in rows.groupby("task", sort=True)] if len(rows) else []


def _by_session(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the mean of ``value``: participants by sessions."""
    return rows.assign(session=rows["session"].astype(str)).pivot_table(
        index=PARTICIPANT, columns="session", values="value", observed=True
    )


def _thresholds(rows: pd.DataFrame) -> pd.DataFrame:
    """Return log10 thresholds, participants by sessions; NaN where none can be told."""
    main = rows[~rows["catch"]]
    method = str(rows["method"].iloc[0])
    keys = [main[PARTICIPANT].astype(str), main["session"].astype(str)]
    found: dict[str, dict[str, float]] = {}
    for (who, session), own in main.groupby(keys):
        answers = Answers.of_trials(own["level_um_pp"].tolist(), own["correct"].tolist())
        fitted = fit_threshold(answers, method=method, curve=CURVE_OF.get(method, "weibull"))
        threshold = np.nan if isinstance(fitted, NotComputed) else fitted.threshold_um_pp.value
        log = float(np.log10(threshold)) if threshold > 0 else np.nan
        found.setdefault(str(session), {})[str(who)] = log
    return pd.DataFrame(found)


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
    )


def _corrected(measures: list[SessionMeasure]) -> tuple[SessionMeasure, ...]:
    """Return measures with Holm's p over the changes of all."""
    ps = [
        each.change.p if isinstance(each.change, MeanOverParticipants) else float("nan")
        for measure in measures
        for each in measure.changes
    ]
    corrected = iter(holm(ps))

    def told(each: SessionChange) -> SessionChange:
        p = next(corrected)
        return replace(each, p_holm=p if np.isfinite(p) else None)

    return tuple(
        replace(measure, changes=tuple(map(told, measure.changes))) for measure in measures
    )


def agreement(values: Array, confidence: float) -> IntraclassCorrelation | NotComputed:
    """Return ICC(A,1) of participants by sessions, with its interval.

    McGraw and Wong 1996, Psychol. Methods 1, 30-46, tables 4 and 7 (pingouin's interval has two
    decimals).
    """
    from scipy import stats  # noqa: PLC0415 - a second's import

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
