"""Compare ratings in pairs by Wilcoxon's signed-rank test."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import combinations
from math import nan

import pandas as pd

from slipscale.analysis.preprocessing.sufficiency import FEWEST
from slipscale.analysis.statistics.holm import holm
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.repeated_measures.pairwise import signed_rank_p


@dataclass(frozen=True, slots=True, kw_only=True)
class RatedPair:
    """Comparison of two surfaces.

    Parameters
    ----------
    from_surface, to_surface : str
    difference : MeanOverParticipants or NotComputed
        Mean difference in rating, second surface minus first surface.
    participants : int
        Number of participants who rated both surfaces.
    p_wilcoxon, p_wilcoxon_holm : float
        p-values of the two-sided signed-rank test, uncorrected and Holm-corrected across the whole
        family: all pairs in all rating tasks and conditions. NaN if no ratings differ, or if fewer
        than three participants rated both surfaces.
    """

    from_surface: str
    to_surface: str
    difference: MeanOverParticipants | NotComputed
    participants: int
    p_wilcoxon: float
    p_wilcoxon_holm: float


def pairs_of(table: pd.DataFrame, confidence: float, length: float) -> tuple[RatedPair, ...]:
    """Compare all pairs of columns in a table with one row per participant.

    ``length`` is the distance between the ends of the scale, the largest possible difference. The
    p-values are not corrected; see `corrected`.
    """
    pairs = list(combinations(table.columns, 2))
    steps = [(table[other] - table[one]).dropna().to_numpy(float) for one, other in pairs]
    raw = [signed_rank_p(each) if len(each) >= FEWEST else nan for each in steps]
    return tuple(
        RatedPair(
            from_surface=str(one),
            to_surface=str(other),
            difference=mean_over_participants(each, confidence, (-length, length)),
            participants=len(each),
            p_wilcoxon=p,
            p_wilcoxon_holm=p,
        )
        for (one, other), each, p in zip(pairs, steps, raw, strict=True)
    )


def corrected(found: Iterable[tuple[RatedPair, ...]]) -> list[tuple[RatedPair, ...]]:
    """Apply Holm's correction across the pairs of all results, which are one family of tests."""
    every = list(found)
    ps = iter(holm([pair.p_wilcoxon for pairs in every for pair in pairs]))
    return [tuple(replace(pair, p_wilcoxon_holm=next(ps)) for pair in pairs) for pairs in every]
