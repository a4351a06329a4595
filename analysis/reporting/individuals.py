"""Tabulate the results of individual participants."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pandas as pd

from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.statistics.power_law import exponents
from slipscale.analysis.statistics.psychometrics.psychometric_function import PsychometricFunction
from slipscale.analysis.statistics.statistic import Inference
from slipscale.analysis.tasks.difference.statistics import DIFFERENCE
from slipscale.analysis.tasks.difference.yes_no import SignalDetection
from slipscale.analysis.tasks.estimation.growth.statistics import IndividualGrowth
from slipscale.analysis.tasks.estimation.statistics import BAYESIAN_GROWTH, GROWTH
from slipscale.experiments.dataset.schema import PARTICIPANT


def individuals(prepared: Prepared | None, inference: Inference) -> pd.DataFrame:
    """Return a table of individual results that contains only the computed columns.

    Parameters
    ----------
    prepared : Prepared or None
        Magnitude estimates.
    inference : Inference
        Result of `slipscale.analysis.tasks.table.conclude`.

    Returns
    -------
    DataFrame
        One row per participant. Columns: ``participant_id exponent estimate_at_1_level`` (the power
        function at 1 µm peak to peak), ``points`` (number of amplitudes fitted),
        ``growth_function`` (smallest AICc), ``exponent_bayesian`` with ``_low`` and ``_high``,
        ``hits changes false_alarms catches d_prime criterion``, and ``threshold_level`` with
        ``_low`` and ``_high``. Cells of tasks that a participant did not perform are empty.
    """
    parts = []
    if prepared is not None and not prepared.refused and _wanted(prepared, "power_law"):
        table = exponents(prepared.logs)
        table = table[table["exponent"].notna()]
        table.index = table.index.astype(str)
        table.insert(1, "estimate_at_1_level", np.exp(table.pop("intercept")))
        growth = inference.found(GROWTH)
        if growth is not None and isinstance(growth.individual, IndividualGrowth):
            winners = growth.individual.participants
            if any(winners.values()):
                table["growth_function"] = table.index.map(winners)
        bayesian = inference.found(BAYESIAN_GROWTH)
        if bayesian is not None and bayesian.converged:
            posterior = {
                one.participant: (one.exponent, one.interval.low, one.interval.high)
                for one in bayesian.individuals
            }
            columns = [f"exponent_bayesian{end}" for end in ("", "_low", "_high")]
            drawn = pd.DataFrame(posterior.values(), index=list(posterior), columns=columns)
            table = table.join(drawn)
        if len(table):
            parts.append(table)
    difference = inference.found(DIFFERENCE)
    detection = None if difference is None else difference.signal_detection
    if isinstance(detection, SignalDetection) and detection.participants:
        own = {who: asdict(found) for who, found in detection.participants.items()}
        parts.append(pd.DataFrame.from_dict(own, orient="index"))
    thresholds = {
        who: (own.threshold_level.value, *own.threshold_level.interval)
        for who, own in (difference.thresholds.items() if difference is not None else ())
        if isinstance(own, PsychometricFunction)
    }
    if thresholds:
        names = [f"threshold_level{end}" for end in ("", "_low", "_high")]
        parts.append(pd.DataFrame(thresholds.values(), index=list(thresholds), columns=names))
    if not parts:
        return pd.DataFrame(columns=[PARTICIPANT])
    return pd.concat(parts, axis=1).sort_index().rename_axis(PARTICIPANT).reset_index()


def _wanted(prepared: Prepared, test: str) -> bool:
    chosen = prepared.choices.tests
    return chosen is None or test in chosen
