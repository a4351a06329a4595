"""Analyse magnitude production, and compare its exponent with that of magnitude estimation.

The amplitude is the response to a given number, so log amplitude is regressed on log number, and
the exponent is the inverse of the slope. People compress the range of their responses (the
regression effect). The exponent from magnitude production is therefore too large, because the
responses are amplitudes. The exponent from magnitude estimation is too small, because the responses
are numbers. The usual remedy is the geometric mean of both exponents (Stevens and Greenbaum 1966,
Perception and Psychophysics 1, 439-446).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp

import numpy as np
import pandas as pd

from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.task_tables import above_zero, by_task, task_trials
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed, missing
from slipscale.analysis.statistics.power_law import exponents
from slipscale.analysis.statistics.regression import fit_lines
from slipscale.analysis.statistics.statistic import Inputs, Named, Statistic
from slipscale.analysis.tasks.ratios.statistics import TRIALS as RATIO_TRIALS
from slipscale.analysis.tasks.ratios.statistics import catch_mean, geometric, log_cells
from slipscale.experiments.dataset.schema import PARTICIPANT

LOW, HIGH = "low", "high"
PRODUCED = ("produced_level", "number", "modulus", "standard_level")
POSITIVE = {"produced_level": "productions", "number": "numbers to be produced"}


def _above_zero(frame: pd.DataFrame, problems: Problems) -> pd.DataFrame:
    return frame.assign(
        **{name: above_zero(frame[name], what, problems) for name, what in POSITIVE.items()}
    )


TRIALS = task_trials(
    "productions",
    "production",
    marks=PRODUCED,
    numeric=PRODUCED,
    words=("bound",),
    codes={"began": (LOW, HIGH)},
    columns=("began", "bound", *PRODUCED),
    needed=PRODUCED,
    derive=_above_zero,
)


#: Share of productions at the plate's limits above which the mean of a number has no interval. In
#: simulations of 6 people, the intervals of such means covered the mean of many people in 87 %.
MOST_AT_BOUNDS = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class ProducedNumber:
    """The amplitudes that participants produced for one number.

    Parameters
    ----------
    number : float
        The number shown.
    participants, productions, at_bounds : int
        Number of participants, number of amplitudes that they produced, and number of these within
        one notch of the plate's limits.
    level : float
        Geometric mean of participants' geometric means, µm peak to peak.
    interval : ConfidenceInterval or None
        t-based interval, computed on logarithms; None if not defined, or if more than
        `MOST_AT_BOUNDS` of the productions ended at the limits.
    """

    number: float
    participants: int
    productions: int
    at_bounds: int
    level: float
    interval: ConfidenceInterval | None

    @property
    def piled(self) -> bool:
        """Whether more than `MOST_AT_BOUNDS` of the productions ended at the limits."""
        return self.at_bounds > MOST_AT_BOUNDS * self.productions


@dataclass(frozen=True, slots=True, kw_only=True)
class BothExponents:
    """Exponents of production and estimation, for participants who did both tasks.

    Parameters
    ----------
    counterpart : str
        Name of the task compared with production: "magnitude estimation" or "ratio judgements".
    n, participants : int
        Number of participants with both exponents above 0, and of all who did both tasks.
    estimation, production : float
        Geometric means of participants' exponents.
    ratio : float
        Production exponent divided by estimation exponent; above 1 if people compress the range
        that they control.
    ratio_interval : ConfidenceInterval
        t-based interval, computed on the logarithms of participants' ratios.
    combined : float
        Geometric mean of the production and estimation exponents.
    combined_interval : ConfidenceInterval
        t-based interval of ``combined``, computed on logarithms.
    """

    counterpart: str
    n: int
    participants: int
    estimation: float
    production: float
    ratio: float
    ratio_interval: ConfidenceInterval
    combined: float
    combined_interval: ConfidenceInterval


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskProductions:
    """Results for a production task.

    Parameters
    ----------
    task : str
        Task label, as in file names.
    standard_level, modulus : float
        Amplitude of the standard (µm peak to peak), and the number assigned to the standard.
    participants, answers, catch_trials : int
        Counts of participants, answers (without catch trials) and catch trials.
    catch_level : float or None
        Geometric mean of the amplitudes produced in catch trials, in which the number of the
        standard is shown.
    at_bounds : int
        Number of analysed trials in which the amplitude ended within one notch of the plate's
        limits.
    numbers : tuple of ProducedNumber
        Results for each number shown, in ascending order.
    slope : MeanOverParticipants or NotComputed
        Mean of participants' slopes of log amplitude on log number.
    exponent : float or None
        Inverse of the slope; None if the slope is not above 0.
    exponent_interval : ConfidenceInterval or None
        Inverses of the bounds of the slope's interval. None unless both bounds are above 0.
    beginning : MeanOverParticipants or NotComputed
        Mean log amplitude after high starts minus mean log amplitude after low starts.
    both : BothExponents or NotComputed
        Comparison with estimation.
    """

    task: str
    standard_level: float
    modulus: float
    participants: int
    answers: int
    catch_trials: int
    catch_level: float | None
    at_bounds: int
    numbers: tuple[ProducedNumber, ...]
    slope: MeanOverParticipants | NotComputed
    exponent: float | None
    exponent_interval: ConfidenceInterval | None
    beginning: MeanOverParticipants | NotComputed
    both: BothExponents | NotComputed


@dataclass(frozen=True, slots=True, kw_only=True)
class Counterpart:
    """Exponents of another task, for comparison with production.

    Parameters
    ----------
    name : str
        Name of the task, "magnitude estimation" or "ratio judgements".
    exponents : Series
        Exponents, indexed by participant.
    """

    name: str
    exponents: pd.Series[float]


def productions(
    trials: pd.DataFrame, confidence: float = 0.95, counterpart: Counterpart | None = None
) -> tuple[TaskProductions, ...] | NotComputed:
    """Return results for each production task.

    Parameters
    ----------
    trials : DataFrame
        Trials as read by `slipscale.analysis.tasks.productions.statistics.TRIALS`.
    counterpart : Counterpart, optional
        Exponents from the task that is compared with production.
    """
    if not len(trials) or trials["catch"].all():
        return NotComputed("no trials of magnitude production")
    return tuple(
        _task(task, rows, confidence, counterpart)
        for task, rows in by_task(trials)
        if not rows["catch"].all()
    )


def slopes(main: pd.DataFrame) -> pd.Series[float]:
    """Return each participant's slope of log amplitude on log number (NaN if only one number)."""
    table = log_cells(main, "number", "produced_level")
    lines = fit_lines(np.log(table.columns.to_numpy(float)), table.to_numpy(float))
    return pd.Series(lines.slope, index=table.index)


def _task(
    task: str, rows: pd.DataFrame, confidence: float, counterpart: Counterpart | None
) -> TaskProductions:
    main, catch = rows[~rows["catch"]], rows[rows["catch"]]
    table = log_cells(main, "number", "produced_level")
    bounded = main["bound"].isin(["lowest", "highest"])
    numbers = []
    for number in table.columns:
        mean, interval = geometric(table[number], confidence)
        of_number = main["number"] == number
        produced = ProducedNumber(
            number=float(number),
            participants=int(table[number].notna().sum()),
            productions=int(of_number.sum()),
            at_bounds=int((bounded & of_number).sum()),
            level=mean,
            interval=interval,
        )
        numbers.append(replace(produced, interval=None) if produced.piled else produced)
    own = slopes(main)
    slope = mean_over_participants(np.asarray(own, np.float64), confidence)
    exponent, exponent_interval = _inverse(slope)
    return TaskProductions(
        task=task,
        standard_level=float(rows["standard_level"].iloc[0]),
        modulus=float(rows["modulus"].iloc[0]),
        participants=len(table),
        answers=len(main),
        catch_trials=len(catch),
        catch_level=catch_mean(catch, "produced_level"),
        at_bounds=int(bounded.sum()),
        numbers=tuple(numbers),
        slope=slope,
        exponent=exponent,
        exponent_interval=exponent_interval,
        beginning=_beginning(main, confidence),
        both=NotComputed("no participant has an estimation exponent")
        if counterpart is None
        else both_exponents(own, counterpart, confidence),
    )


def _inverse(
    slope: MeanOverParticipants | NotComputed,
) -> tuple[float | None, ConfidenceInterval | None]:
    """Return the inverse of a slope and the inverse of its interval.

    Inverses are None if the slope is not above 0. The inverse of the interval is None if the
    interval includes 0.
    """
    if not slope or slope.mean <= 0:
        return None, None
    low, high = slope.interval
    interval = replace(slope.interval, low=1 / high, high=1 / low) if low > 0 else None
    return 1 / slope.mean, interval


def _beginning(main: pd.DataFrame, confidence: float) -> MeanOverParticipants | NotComputed:
    """Return the mean log amplitude after high starting values minus that after low ones."""
    logs = main.assign(log=np.log(main["produced_level"].to_numpy(float)))
    sides = logs.pivot_table(index=PARTICIPANT, columns="began", values="log", observed=True)
    sides = sides.reindex(columns=[LOW, HIGH])
    return mean_over_participants(np.asarray(sides[HIGH] - sides[LOW], np.float64), confidence)


def both_exponents(
    own: pd.Series[float], counterpart: Counterpart, confidence: float
) -> BothExponents | NotComputed:
    """Compare the exponents of participants who did both tasks.

    Parameters
    ----------
    own : Series
        Participants' slopes of log amplitude on log number.
    counterpart : Counterpart
    """
    other = counterpart.exponents.copy()
    other.index = other.index.astype(str)
    paired = pd.DataFrame({"slope": own.rename(str), "other": other}).dropna()
    usable = paired[(paired > 0).all(axis=1)]
    production = np.asarray(-np.log(usable["slope"].to_numpy(float)), np.float64)
    estimation = np.asarray(np.log(usable["other"].to_numpy(float)), np.float64)
    ratio = mean_over_participants(production - estimation, confidence)
    combined = mean_over_participants((production + estimation) / 2, confidence)
    if not (ratio and combined):
        return missing([ratio, combined])[0]
    return BothExponents(
        counterpart=counterpart.name,
        n=len(usable),
        participants=len(own.rename(str).index.intersection(other.index)),
        estimation=exp(estimation.mean()),
        production=exp(production.mean()),
        ratio=exp(ratio.mean),
        ratio_interval=_exp(ratio.interval),
        combined=exp(combined.mean),
        combined_interval=_exp(combined.interval),
    )


def _exp(interval: ConfidenceInterval) -> ConfidenceInterval:
    return replace(interval, low=exp(interval.low), high=exp(interval.high))


def counterpart(inputs: Inputs) -> Counterpart | None:
    """Return exponents from magnitude estimates or, if unusable, from ratio judgements."""
    prepared = inputs.prepared
    if prepared is not None and not prepared.refused:
        return Counterpart(
            name="magnitude estimation", exponents=exponents(prepared.logs)["exponent"]
        )
    judged = inputs.data.of(RATIO_TRIALS)
    main = judged[~judged["catch"].astype(bool)]
    if not len(main):
        return None
    logs = log_cells(main, "comparison_level", "ratio")
    return Counterpart(name="ratio judgements", exponents=exponents(logs)["exponent"])


class _Productions(Statistic[tuple[TaskProductions, ...]]):
    key = "productions"
    meaning = "magnitude production: produced {q.levels}, slope and exponent"
    methods = (
        "The exponent of magnitude production is the inverse of the mean of participants' "
        "regression slopes of log {q.name} on log number, with a t-based interval. For "
        "participants who also gave estimates or ratios, the exponents of both tasks were compared "
        "and combined as geometric means [[stevens1966]]."
    )
    conclusions = (Named("*.slope.p", "{0}: produced {q.levels} rise with the number"),)
    headlines = (Named("*.exponent", "{0[0]}: exponent"),)

    def compute(self, inputs: Inputs) -> tuple[TaskProductions, ...] | NotComputed:
        data = inputs.data
        return productions(
            data.of(TRIALS), data.choices.confidence, counterpart=counterpart(inputs)
        )


PRODUCTIONS = _Productions()
