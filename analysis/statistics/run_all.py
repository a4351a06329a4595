"""All that is concluded from a data set, as one plain structure: what the JSON files hold."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from analysis.preprocessing.log_transform import Prepared, prepare
from analysis.preprocessing.normalisation import RULES, cell_means, normalise_by_all
from analysis.reading.delimited import read_tables
from analysis.statistics import omnibus, order_and_reliability, power_law
from analysis.statistics.mixed_model import mixed_model
from analysis.statistics.omnibus import Result, reason
from analysis.statistics.pairwise import pairwise
from analysis.statistics.verbal_coding import SHIPPED, agreement, load_codebook
from analysis.statistics.yes_no import analyse_differences
from experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd

    from analysis.reading.dataset import Dataset

#: Everything that is concluded from magnitude estimates, by its name in inference.json.
TESTS: dict[str, Callable[[Prepared], Any]] = {
    **omnibus.TESTS,
    "pairwise": pairwise,
    "mixed_model": mixed_model,
    "power_law": power_law.power_law,
    "growth": power_law.growth,
    "order": order_and_reliability.order,
    "reliability": order_and_reliability.reliability,
}


def conclude(data: Dataset, prepared: Prepared | None, rule: str | None) -> Result:
    """Return what ``omnibus.json`` holds: each test's numbers, or the reason why there are none.

    Parameters
    ----------
    data : Dataset
        After exclusions.
    prepared : Prepared or None
        Magnitude estimates; None where there are none.
    rule : str or None
        How they were normalised.
    """
    chosen = data.choices.tests
    found: Result = {}
    for name, test in TESTS.items():
        if chosen is not None and name not in chosen:
            found[name] = reason("not chosen in the study file")
        elif prepared is None:
            found[name] = reason("no magnitude estimates")
        else:
            found[name] = test(prepared)
    found["normalisation"] = {
        "rule": rule,
        "zero_rule": data.choices.zero_rule,
        "zeros": prepared.zeros if prepared else 0,
        "standard_deviation": data.choices.standard_deviation,
    }
    found["difference"] = (
        reason("not chosen in the study file")
        if chosen is not None and "difference" not in chosen
        else difference(data)
    )
    return found


def difference(data: Dataset) -> Result:
    """Return the descending difference, with the data set's own code book and coders."""
    folder, name = data.folder, data.choices.codebook
    book = load_codebook(folder / name if folder and name else SHIPPED)
    found = analyse_differences(data.differences, book, data.choices.confidence)
    codes = folder / "code" / "verbal_codes.tsv" if folder else None
    if "reason" not in found and codes is not None and codes.is_file():
        frame, _ = read_tables(
            [codes], codes.parent, required=("verbal_report", "coder", "category")
        )
        found["coders"] = agreement(frame)
    return found


def sensitivity(trials: pd.DataFrame, used: str) -> list[Result]:
    """Return Table III's means and spreads under every rule that the data allows.

    The exponent and every test within participants on logarithms are the same under all of them.
    """
    rows = []
    for name, normalised in normalise_by_all(trials).items():
        cells = cell_means(trials.assign(normalised=normalised), "normalised")
        rows.append(
            {
                "rule": name,
                "used": name == used,
                "unit": RULES[name].unit,
                "mean": {f"{a:g}": float(m) for a, m in cells.mean().items()},
                "sd_sample": {f"{a:g}": float(s) for a, s in cells.std(ddof=1).items()},
            }
        )
    return rows


def robustness(everyone: Prepared, flagged: set[str]) -> list[Result]:
    """Return the chief results with and without the participants who carry a flag."""
    kept = ~everyone.trials[PARTICIPANT].isin(flagged)
    sets = {"all analysed": everyone}
    if flagged and kept.any():
        trials = everyone.trials[kept].reset_index(drop=True)
        sets["without the flagged"] = prepare(trials, everyone.choices)
    rows = []
    for name, data in sets.items():
        exponent, friedman = power_law.power_law(data), omnibus.friedman(data)
        rows.append(
            {
                "participants": name,
                "n": len(data.cells),
                "exponent": exponent.get("exponent"),
                "exponent_ci": exponent.get("ci95", exponent.get("ci")),
                "friedman_chi2": friedman.get("chi2"),
                "friedman_p": friedman.get("p"),
                "means": {f"{a:g}": float(m) for a, m in data.cells.mean().items()},
            }
        )
    return rows


def plain(value: Any) -> Any:
    """Return a structure as JSON can hold it: no NaN (null instead), no numpy scalars."""
    if isinstance(value, dict):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
