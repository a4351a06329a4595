"""Analyse ratings on a visual analogue scale or in categories.

Categories are numbered from 1. Means treat categories as equally spaced; ranks do not.

Positions on a bounded scale without a unit cannot be compared as ratios. Ratings are therefore not
divided by a participant's maximum, and neither logarithms nor exponents are computed. Surfaces are
compared by ranks within participants.

In the tables of trials, ``surface`` is the name of a texture or an amplitude (µm peak to peak).
Textures have no ``level``.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.task_tables import by_task, task_trials
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.repeated_measures.omnibus import (
    FRIEDMAN_ERRORS,
    Friedman,
    PageTrend,
    friedman_of,
    page_trend_of,
)
from slipscale.analysis.statistics.statistic import Family, Inputs, Named, Statistic
from slipscale.analysis.tasks.ratings.pairs import RatedPair, corrected, pairs_of
from slipscale.analysis.tasks.scales.statistics import in_order
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

#: Columns that identify a table of ratings.
RATED = ("rating", "level")
#: Columns for ratings on a line, and the number of categories for category ratings.
OF_SCALE = ("resolution", "cursor_start", "categories")
LENGTH = 100.0  # of the line


def _ratings(frame: pd.DataFrame, problems: Problems) -> pd.DataFrame:
    beyond = frame["rating"] > frame["categories"].fillna(LENGTH)
    if beyond.any():
        problems.add(
            f"{int(beyond.sum())} ratings are above the maximum ({LENGTH:g}, or the number "
            "of categories) and are left out"
        )
    amplitude = frame["level"]
    plain = frame["texture"] == ""
    return frame.assign(
        rating=frame["rating"].mask(beyond),
        surface=frame["texture"].mask(plain, amplitude.map("{:g}".format)),
        level=amplitude.where(plain),
    )


TRIALS = task_trials(
    "ratings",
    "rating",
    marks=RATED,
    numeric=(*OF_SCALE, *RATED),
    words=("texture",),
    columns=("surface", *OF_SCALE, *RATED),
    needed=("rating",),
    levels=("level",),
    derive=_ratings,
)


ENDS = (0.0, 100.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class RatedSurface:
    """Ratings of one surface, from 0 to 100 or as category numbers.

    Parameters
    ----------
    surface : str
        Amplitude (µm peak to peak), or name of the texture.
    participants, ratings : int
        Counts of participants and ratings.
    mean, sd : float, float or None
        Mean and standard deviation (n - 1) of participants' mean ratings.
    interval : ConfidenceInterval or NotComputed
        t-based interval for the mean, within the ends of the scale. Not computed for fewer than
        three participants or equal means.
    at_left, at_right : int
        Counts of ratings at the left and right ends of the scale.
    """

    surface: str
    participants: int
    ratings: int
    mean: float
    sd: float | None
    interval: ConfidenceInterval | NotComputed
    at_left: int
    at_right: int


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskRatings:
    """Results for a rating task.

    Parameters
    ----------
    task : str
        Task label, as in file names.
    participants, answers, catch_trials : int
        Counts of participants, answers (without catch trials) and catch trials.
    catch_mean : float or None
        Mean rating in catch trials, which present the bare plate.
    categories : int or None
        Number of ordered categories; None for ratings on a line.
    resolution : float or None
        Smallest difference between two possible ratings, or None if this differs between trials.
    surfaces : tuple of RatedSurface
        Surfaces in ascending order of amplitude, then textures.
    friedman : Friedman or NotComputed
        Friedman's test of differences between surfaces.
    page_trend : PageTrend or NotComputed
        One-sided test of an increase with amplitude; textures are excluded.
    pairs : tuple of RatedPair
    start_effect : MeanOverParticipants or NotComputed
        Mean across participants of the slope of ratings on the mark's starting position, fitted
        within surfaces.
    """

    task: str
    participants: int
    answers: int
    catch_trials: int
    catch_mean: float | None
    categories: int | None
    resolution: float | None
    surfaces: tuple[RatedSurface, ...]
    friedman: Friedman | NotComputed
    page_trend: PageTrend | NotComputed
    pairs: tuple[RatedPair, ...]
    start_effect: MeanOverParticipants | NotComputed


def ratings(
    trials: pd.DataFrame, confidence: float = 0.95, quantity: Quantity = PLATE_AMPLITUDE
) -> tuple[TaskRatings, ...] | NotComputed:
    """Return the results for each rating task.

    Parameters
    ----------
    trials : DataFrame
        Trials as read by `slipscale.analysis.tasks.ratings.statistics.TRIALS`.
    """
    if not len(trials) or trials["catch"].all():
        return NotComputed("no ratings on a visual analogue scale")
    found = [
        _task(task, rows, confidence, quantity)
        for task, rows in by_task(trials)
        if not rows["catch"].all()
    ]
    pairs = corrected(task.pairs for task in found)
    return tuple(replace(task, pairs=own) for task, own in zip(found, pairs, strict=True))


def cells(main: pd.DataFrame) -> pd.DataFrame:
    """Return participants' mean ratings, shape (participants, surfaces)."""
    means = main.pivot_table(index=PARTICIPANT, columns="surface", values="rating", observed=True)
    return means[list(in_order({str(name) for name in means.columns}))]


def ends_of(rows: pd.DataFrame) -> tuple[float, float]:
    """Return the smallest and the largest possible rating of a task."""
    categories = rows["categories"]
    return ENDS if categories.isna().all() else (1.0, float(categories.max()))


def _task(task: str, rows: pd.DataFrame, confidence: float, quantity: Quantity) -> TaskRatings:
    main, catch = rows[~rows["catch"]], rows[rows["catch"]]
    table = cells(main)
    plain = {str(name) for name in main.loc[main["level"].notna(), "surface"]}
    whole = table.dropna()
    amplitudes = table[[name for name in table.columns if name in plain]]
    steps = rows["resolution"].dropna().unique()
    ends = ends_of(rows)
    return TaskRatings(
        task=task,
        participants=len(table),
        answers=len(main),
        catch_trials=len(catch),
        catch_mean=float(catch.groupby(PARTICIPANT, observed=True)["rating"].mean().mean())
        if len(catch)
        else None,
        categories=None if ends == ENDS else int(ends[1]),
        resolution=float(steps[0]) if len(steps) == 1 else None,
        surfaces=tuple(
            _surface(name, main[main["surface"] == name], table[name], ends, confidence)
            for name in table.columns
        ),
        friedman=friedman_of(whole, len(table) - len(whole)),
        page_trend=page_trend_of(
            amplitudes.dropna(), len(table) - len(amplitudes.dropna()), quantity
        ),
        pairs=pairs_of(table, confidence, ends[1] - ends[0]),
        start_effect=start_effect(main, confidence),
    )


def _surface(
    name: str,
    rows: pd.DataFrame,
    means: pd.Series[float],
    ends: tuple[float, float],
    confidence: float,
) -> RatedSurface:
    own = np.asarray(means.dropna(), np.float64)
    found = mean_over_participants(own, confidence, ends)
    left, right = (int((rows["rating"] == end).sum()) for end in ends)
    return RatedSurface(
        surface=name,
        participants=len(own),
        ratings=len(rows),
        mean=float(own.mean()),
        sd=float(own.std(ddof=1)) if len(own) > 1 else None,
        interval=found if isinstance(found, NotComputed) else found.interval,
        at_left=left,
        at_right=right,
    )


def start_effect(main: pd.DataFrame, confidence: float) -> MeanOverParticipants | NotComputed:
    """Regress ratings on the starting position of the mark, and return the slope.

    Each participant's slope is fitted to ratings and starting positions that are centred within
    surfaces.
    """
    known = main[main["cursor_start"].notna()]
    cell = known.groupby([PARTICIPANT, "surface"], observed=True)
    centred = {
        name: (known[name] - cell[name].transform("mean")).to_numpy(float)
        for name in ("rating", "cursor_start")
    }
    people = known[PARTICIPANT].astype(str).to_numpy()
    slopes = []
    for who in np.unique(people):
        dx, dy = centred["cursor_start"][people == who], centred["rating"][people == who]
        if (dx**2).sum() > 0:
            slopes.append((dx * dy).sum() / (dx**2).sum())
    if not slopes:
        return NotComputed(
            "the mark always started in the same place, or no surface was rated twice"
        )
    return mean_over_participants(np.array(slopes, np.float64), confidence)


def _ps(tests: Iterable[Friedman | PageTrend | NotComputed]) -> list[float]:
    return [test.p for test in tests if test]


class _Ratings(Statistic[tuple[TaskRatings, ...]]):
    key = "ratings"
    meaning = "ratings on a line: means, Friedman's test, ordered trend and pairwise tests"
    families = (
        Family(
            name="ratings, Friedman's test",
            read=lambda tasks: _ps(task.friedman for task in tasks),
        ),
        Family(
            name="ratings, Page's test",
            read=lambda tasks: _ps(task.page_trend for task in tasks),
        ),
        Family(
            name="pairs of rated surfaces, Wilcoxon's test",
            corrected=True,
            read=lambda tasks: [pair.p_wilcoxon for task in tasks for pair in task.pairs],
        ),
    )
    methods = (
        "Participants' mean ratings were compared between surfaces by Friedman's test "
        "[[friedman1937]], between pairs of surfaces by Wilcoxon signed-rank tests "
        "[[wilcoxon1945]] with Holm's correction across all pairs [[holm1979]], and across ordered "
        "{q.levels} by Page's test [[page1963]]. Ratings were not normalised, and means have "
        "t-based intervals, limited to the range of the scale. Near an end of a line, 95 % "
        "intervals contained the mean in 87 % of 100 simulated studies with 12 participants: they "
        "are too narrow. " + FRIEDMAN_ERRORS
    )
    conclusions = (
        Named("*.friedman.p", "{0}: ratings differ between surfaces (Friedman's test)"),
        Named("*.page_trend.p", "{0}: ratings {q.grow} with {q.level} (Page's test)"),
        Named("*.pairs.*.p_wilcoxon_holm", "{0}: {1[0]} and {1[1]} differ (Wilcoxon's test, Holm)"),
    )
    headlines = (Named("*.surfaces.*.mean", "{0}: mean rating of {1}"),)

    def compute(self, inputs: Inputs) -> tuple[TaskRatings, ...] | NotComputed:
        return ratings(inputs.data.of(TRIALS), inputs.data.choices.confidence, inputs.data.quantity)


RATINGS = _Ratings()
