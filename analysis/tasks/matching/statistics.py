"""Analyse bias, variability and the effect of direction in matching by adjustment.

The column ``felt_again`` is the number of times the reference was repeated in a trial, or NaN if
the data do not contain it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.task_tables import by_task, task_trials
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Family, Inputs, Named, Statistic
from slipscale.experiments.dataset.schema import INTERVAL, PARTICIPANT

REFERENCE = f"{INTERVAL}1_level"
ASCENDING, DESCENDING, EQUAL = "ascending", "descending", "equal"


def _matches(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    return frame.assign(reference_level=frame[REFERENCE])


TRIALS = task_trials(
    "matches",
    "matching",
    marks=("matched_level", "direction"),
    required=(REFERENCE,),
    numeric=(REFERENCE, "matched_level", "felt_again"),
    codes={"direction": (ASCENDING, DESCENDING, EQUAL)},
    columns=("direction", "reference_level", "matched_level", "felt_again"),
    needed=("reference_level", "matched_level"),
    derive=_matches,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class MatchedReference:
    """Results for matching one reference.

    Parameters
    ----------
    task : str
        Task label, as in file names.
    reference_level : float
        Amplitude of the reference, µm peak to peak.
    matches, participants : int
        Number of matches and number of participants.
    mean_level : float
        Mean across participants of each participant's mean match.
    bias_level : MeanOverParticipants or NotComputed
        Mean match minus reference across participants (constant error), tested against 0.
    variability_level : float or None
        Root mean square of participants' standard deviations within a direction (variable error).
        None if no participant made two matches in the same direction.
    ascending_level, descending_level : float or None
        Mean matches from below and from above.
    direction_level : MeanOverParticipants or NotComputed
        Mean difference across participants, matches from above minus matches from below, tested
        against 0.
    catch_trials : int
        Number of trials that started at the reference and do not count as matches.
    catch_error_level : float or None
        Mean absolute difference from the reference in catch trials; None without catch trials.
    felt_again : float or None
        Mean number of repetitions of the reference per match; None if not recorded.
    """

    task: str
    reference_level: float
    matches: int
    participants: int
    mean_level: float
    bias_level: MeanOverParticipants | NotComputed
    variability_level: float | None
    ascending_level: float | None
    descending_level: float | None
    direction_level: MeanOverParticipants | NotComputed
    catch_trials: int
    catch_error_level: float | None
    felt_again: float | None


def matching(
    matches: pd.DataFrame, confidence: float = 0.95
) -> tuple[MatchedReference, ...] | NotComputed:
    """Return results for each reference.

    Parameters
    ----------
    matches : DataFrame
        Trials as read by `slipscale.analysis.tasks.matching.statistics.TRIALS`.
    """
    if not len(matches) or matches["catch"].all():
        return NotComputed("no trials of matching")
    return tuple(
        _reference(task, reference, rows, confidence)
        for task, own in by_task(matches)
        for reference in sorted(own.loc[~own["catch"], "reference_level"].unique().tolist())
        for rows in [own[own["reference_level"] == reference]]
    )


def _reference(
    task: str, reference: float, every: pd.DataFrame, confidence: float
) -> MatchedReference:
    caught, rows = every[every["catch"]], every[~every["catch"]]
    own = rows.groupby(PARTICIPANT, observed=True)["matched_level"].mean()
    sides = rows.pivot_table(
        index=PARTICIPANT, columns="direction", values="matched_level", observed=True
    ).reindex(columns=[ASCENDING, DESCENDING])
    spread = rows.groupby([PARTICIPANT, "direction"], observed=True)["matched_level"].var(ddof=1)
    known = spread.dropna().to_numpy(float)
    difference = (sides[DESCENDING] - sides[ASCENDING]).to_numpy(float)
    return MatchedReference(
        task=task,
        reference_level=reference,
        matches=len(rows),
        participants=len(own),
        mean_level=float(own.mean()),
        bias_level=mean_over_participants(own.to_numpy(float) - reference, confidence),
        variability_level=float(np.sqrt(known.mean())) if len(known) else None,
        ascending_level=_mean(sides[ASCENDING]),
        descending_level=_mean(sides[DESCENDING]),
        direction_level=mean_over_participants(difference, confidence),
        catch_trials=len(caught),
        catch_error_level=_mean((caught["matched_level"] - reference).abs()),
        felt_again=_mean(rows["felt_again"]),
    )


def _mean(values: pd.Series[float]) -> float | None:
    known = values.dropna()
    return float(known.mean()) if len(known) else None


class _Matching(Statistic[tuple[MatchedReference, ...]]):
    key = "matching"
    meaning = "bias and variability of matching"
    families = (
        Family(
            name="bias of matches, t tests",
            read=lambda found: [each.bias_level.p for each in found if each.bias_level],
        ),
        Family(
            name="direction of adjustment, t tests",
            read=lambda found: [each.direction_level.p for each in found if each.direction_level],
        ),
    )
    methods = (
        "The bias of matches (constant error) is the mean of participants' mean matches minus the "
        "reference. The effect of direction is the mean difference between matches from above and "
        "from below. Bias and effect have t-based intervals and t tests across participants. "
        "Variability (variable error) is the root mean square of participants' standard deviations "
        "within a direction."
    )
    conclusions = (
        Named("*.bias_level.p", "{0[0]}, {0[1]} {q.unit}: matches differ from the reference"),
        Named(
            "*.direction_level.p",
            "{0[0]}, {0[1]} {q.unit}: matches depend on the direction of adjustment",
        ),
    )
    headlines = (
        Named(
            "*.bias_level.mean", "{0[0]}, {0[1]} {q.unit}: match minus reference, {q.unit_in_short}"
        ),
        Named(
            "*.variability_level",
            "{0[0]}, {0[1]} {q.unit}: within-participant SD of matches, {q.unit_in_short}",
        ),
    )

    def compute(self, inputs: Inputs) -> tuple[MatchedReference, ...] | NotComputed:
        return matching(inputs.data.of(TRIALS), inputs.data.choices.confidence)


MATCHING = _Matching()
