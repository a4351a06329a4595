"""Compute scales from comparisons of pairs, triads and quadruples.

Each trial contains up to four stimulus labels; the others are empty. ``response`` is the number of
the chosen interval (pairs), of the larger step (triads) or of the more different pair (quadruples).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.surface_labels import amplitude_of, plain
from slipscale.analysis.reading.task_tables import by_task, task_trials
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Inputs, Named, Statistic
from slipscale.analysis.tasks.scales.difference_scaling import (
    DifferenceScale,
    difference_scale,
    triads_as_quadruples,
)
from slipscale.analysis.tasks.scales.paired_comparison_scale import (
    ComparisonScale,
    bradley_terry,
    thurstone,
)
from slipscale.analysis.tasks.scales.transitivity import (
    Consistency,
    StochasticTransitivity,
    consistency,
    stochastic_transitivity,
)
from slipscale.experiments.dataset.schema import PARTICIPANT

STIMULI = ("stimulus1", "stimulus2", "stimulus3", "stimulus4")


def _comparisons(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    return frame.assign(
        response=frame["response"].where(frame["response"].isin([1, 2])),
        **{name: frame[name].map(plain) for name in STIMULI},
    )


TRIALS = task_trials(
    "comparisons",
    "comparison",
    marks=(*STIMULI[:2], "response"),
    numeric=("response",),
    words=STIMULI,
    columns=(*STIMULI, "response"),
    needed=("response",),
    derive=_comparisons,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskScale:
    """The results of a comparison task.

    Parameters
    ----------
    task : str
        Task label, as in file names.
    surfaces : tuple of str
        Surfaces in the order of the scale values: amplitudes (µm peak to peak) in ascending order,
        then textures by name.
    participants, answers, catch_trials : int
        Counts of participants, answers and catch trials.
    chosen, compared : tuple of int
        Number of times that each surface was chosen, and number of times that it was presented, in
        trials with pairs.
    bradley_terry, thurstone : ComparisonScale or NotComputed
        Scales from pairs.
    transitivity : StochasticTransitivity or NotComputed
        Stochastic transitivity of the pooled choices.
    consistency : Mapping of str to Consistency or NotComputed
        Consistency of each participant.
    differences : DifferenceScale or NotComputed
        Scale from triads or quadruples.
    stimuli : int
        Number of stimuli per trial: 2 for pairs, 3 for triads, 4 for quadruples.
    """

    task: str
    surfaces: tuple[str, ...]
    participants: int
    answers: int
    catch_trials: int
    chosen: tuple[int, ...]
    compared: tuple[int, ...]
    bradley_terry: ComparisonScale | NotComputed
    thurstone: ComparisonScale | NotComputed
    transitivity: StochasticTransitivity | NotComputed
    consistency: Mapping[str, Consistency | NotComputed]
    differences: DifferenceScale | NotComputed
    stimuli: int = 2


def scales(
    comparisons: pd.DataFrame, confidence: float = 0.95
) -> tuple[TaskScale, ...] | NotComputed:
    """Return the scales for each comparison task.

    Parameters
    ----------
    comparisons : DataFrame
        Trials as read by `slipscale.analysis.tasks.scales.statistics.TRIALS`.
    """
    if not len(comparisons):
        return NotComputed("no trials of paired comparison")
    return tuple(_task(task, rows, confidence) for task, rows in by_task(comparisons))


def _task(task: str, rows: pd.DataFrame, confidence: float) -> TaskScale:
    main = rows[~rows["catch"]]
    stimuli = [name for name in STIMULI if name in STIMULI[:2] or _shown(rows, name)]
    triads = len(stimuli) > 2  # noqa: PLR2004 - differences are compared
    surfaces = in_order({str(name) for column in stimuli for name in main[column].unique()})
    no_pairs = NotComputed("triads were compared, not pairs")
    chosen = {} if triads else choices(main, surfaces)
    everybody = np.stack(list(chosen.values())) if chosen else None
    return TaskScale(
        task=task,
        surfaces=surfaces,
        participants=int(main[PARTICIPANT].nunique()),
        answers=len(main),
        catch_trials=len(rows) - len(main),
        chosen=() if everybody is None else _counts(everybody.sum(axis=(0, 2))),
        compared=()
        if everybody is None
        else _counts((everybody + everybody.transpose(0, 2, 1)).sum(axis=(0, 2))),
        bradley_terry=no_pairs if everybody is None else bradley_terry(everybody, confidence),
        thurstone=no_pairs if everybody is None else thurstone(everybody, confidence),
        transitivity=no_pairs if everybody is None else stochastic_transitivity(everybody),
        consistency={who: consistency(own) for who, own in chosen.items()},
        differences=_differences(main, stimuli, surfaces, confidence)
        if triads
        else NotComputed("pairs were compared, not triads"),
        stimuli=len(stimuli),
    )


def _shown(rows: pd.DataFrame, name: str) -> bool:
    return name in rows and bool((rows[name] != "").any())


def _counts(values: NDArray[np.float64]) -> tuple[int, ...]:
    return tuple(int(value) for value in values)


def in_order(names: set[str]) -> tuple[str, ...]:
    """Return amplitudes in ascending order, followed by textures sorted by name.

    >>> in_order({"2.3", "0.5", "fine", "1.2"})
    ('0.5', '1.2', '2.3', 'fine')
    """

    def place(name: str) -> tuple[bool, float, str]:
        amplitude = amplitude_of(name)
        return (True, 0.0, name) if amplitude is None else (False, amplitude, name)

    return tuple(sorted(names, key=place))


def choices(main: pd.DataFrame, surfaces: tuple[str, ...]) -> dict[str, NDArray[np.float64]]:
    """Count choices of the row's surface over the column's surface for each participant."""
    number = {name: place for place, name in enumerate(surfaces)}
    found = {}
    for who, rows in main.groupby(PARTICIPANT, observed=True):
        one = rows["stimulus1"].map(number).to_numpy(int)
        other = rows["stimulus2"].map(number).to_numpy(int)
        first = rows["response"].to_numpy(float) == 1
        table = np.zeros((len(surfaces), len(surfaces)))
        np.add.at(table, (np.where(first, one, other), np.where(first, other, one)), 1.0)
        found[str(who)] = table
    return found


def _differences(
    main: pd.DataFrame, stimuli: Sequence[str], surfaces: tuple[str, ...], confidence: float
) -> DifferenceScale | NotComputed:
    textures = [name for name in surfaces if amplitude_of(name) is None]
    if textures:
        return NotComputed(f"{', '.join(textures)}: textures have no predefined order")
    number = {name: place for place, name in enumerate(surfaces)}
    ranks = np.stack([main[name].map(number).to_numpy(int) for name in stimuli], axis=1)
    return difference_scale(
        ranks if len(stimuli) == len(STIMULI) else triads_as_quadruples(ranks),
        main["response"].to_numpy(float) == 2,  # noqa: PLR2004 - the second step
        confidence=confidence,
    )


class _Scales(Statistic[tuple[TaskScale, ...]]):
    key = "scales"
    meaning = "scales of paired comparison"
    methods = (
        "Scale values from pairs come from the Bradley–Terry model [[bradley1952]] and from "
        "Thurstone's case V [[thurstone1927]], fitted by maximum likelihood with Firth's "
        "correction [[firth1993]]; intervals account for correlated answers from the same "
        "participant. Each participant's consistency is measured by circular triads "
        "[[kendall1940]]. Scale values from triads come from maximum likelihood difference scaling "
        "[[maloney2003]], with intervals from a parametric bootstrap."
    )
    headlines = (
        Named("*.differences.values.*", "{0}: scale value of {1}"),
        Named("*.bradley_terry.values.*", "{0}: Bradley-Terry value of {1}"),
        Named("*.thurstone.values.*", "{0}: Thurstone value of {1}"),
    )

    def compute(self, inputs: Inputs) -> tuple[TaskScale, ...] | NotComputed:
        return scales(inputs.data.of(TRIALS), inputs.data.choices.confidence)


SCALES = _Scales()
