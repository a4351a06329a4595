"""Compute the agreement between two human coders of verbal reports."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.json_form import renamed
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, slots=True, kw_only=True)
class CoderAgreement:
    """Cohen's kappa for two coders.

    Parameters
    ----------
    coders : tuple of 2 str
        Names of the coders.
    reports : int
        Number of verbal reports with codes from both coders.
    kappa : float
        Cohen's kappa. Its 95 % confidence interval is in ``interval``.
    agreed : int
        Number of reports that both coders put in the same category.
    """

    coders: tuple[str, str]
    reports: int
    kappa: float
    interval: ConfidenceInterval
    agreed: int

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval="ci95")


def agreement(codes: pd.DataFrame) -> CoderAgreement | NotComputed:
    """Return Cohen's kappa for two coders.

    Parameters
    ----------
    codes : DataFrame
        Table with the columns ``verbal_report``, ``coder`` and ``category``, as in
        ``code/verbal_codes.tsv`` of a data set.
    """
    from statsmodels.stats.inter_rater import cohens_kappa

    codes = codes.dropna(subset=["verbal_report", "coder", "category"])
    coders = sorted(codes["coder"].astype(str).unique())
    if len(coders) != 2:  # noqa: PLR2004
        return NotComputed(f"there are {len(coders)} coders; agreement is computed only for two")
    wide = codes.assign(coder=codes["coder"].astype(str)).pivot_table(
        index="verbal_report", columns="coder", values="category", aggfunc="first"
    )
    both = wide.dropna()
    names = sorted(set(both.to_numpy().ravel()))
    if len(both) < 2 or len(names) < 2:  # noqa: PLR2004
        return NotComputed(
            "agreement requires at least two reports coded by both coders, in at least two "
            "categories"
        )
    table = np.zeros((len(names), len(names)))
    for first, second in both.to_numpy():
        table[names.index(first), names.index(second)] += 1
    with np.errstate(invalid="ignore", divide="ignore"):
        # statsmodels also tests against 0, which can divide by a standard error of 0.
        found = cohens_kappa(table)
    return CoderAgreement(
        coders=(coders[0], coders[1]),
        reports=len(both),
        kappa=float(found.kappa),
        interval=ConfidenceInterval(float(found.kappa_low), float(found.kappa_upp)),
        agreed=int(np.trace(table)),
    )
