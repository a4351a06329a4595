"""What is known of each participant: their power function, their d' and criterion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis.statistics.power_law import exponents
from experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from collections.abc import Mapping

    from analysis.preprocessing.log_transform import Prepared


def individuals(prepared: Prepared | None, inference: Mapping[str, Any]) -> pd.DataFrame:
    """Return one row a participant; columns only of what was computed.

    Parameters
    ----------
    prepared : Prepared or None
        Magnitude estimates.
    inference : Mapping
        `analysis.statistics.run_all.conclude`'s result.

    Returns
    -------
    DataFrame
        ``participant_id``; ``exponent``, ``estimate_at_1_um`` (the normalised estimate that the
        power function gives 1 µm peak to peak), ``points`` (amplitudes it went through) and
        ``growth_function`` (the one of least AICc); ``hits changes false_alarms catches d_prime
        criterion``. A participant without one task has no values of it.
    """
    parts = []
    if prepared is not None and not prepared.refused and _wanted(prepared, "power_law"):
        table = exponents(prepared.logs)
        table = table[table["exponent"].notna()]
        table.index = table.index.astype(str)
        table.insert(1, "estimate_at_1_um", np.exp(table.pop("intercept")))
        winners = inference["growth"].get("individual", {}).get("participants", {})
        if any(winners.values()):
            table["growth_function"] = table.index.map(winners)
        if len(table):
            parts.append(table)
    detection = inference["difference"].get("signal_detection", {})
    if detection.get("participants"):
        parts.append(pd.DataFrame.from_dict(detection["participants"], orient="index"))
    if not parts:
        return pd.DataFrame(columns=[PARTICIPANT])
    return pd.concat(parts, axis=1).sort_index().rename_axis(PARTICIPANT).reset_index()


def _wanted(prepared: Prepared, test: str) -> bool:
    chosen = prepared.choices.tests
    return chosen is None or test in chosen
