"""Compare exponents, levels and growth between groups of participants."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.json_form import Unchanged, renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few
from slipscale.analysis.reading.cells import listed
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.power_law import exponents
from slipscale.analysis.statistics.repeated_measures.two_way import Effect, effect
from slipscale.analysis.statistics.statistic import Family, Inputs, Statistic, of_estimates
from slipscale.analysis.tasks.effects.groups.welch import Welch, welch
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.reading.dataset import Dataset

#: Default column of participants.tsv that contains the group.
DEFAULT_COLUMN = "group"
#: Largest number of names in a message.
NAMED = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class MixedAnova:
    """Analysis of variance of mean logarithms, by group (between) and amplitude (within).

    Parameters
    ----------
    group, amplitude, interaction : Effect
        Main effects of group and amplitude, and their interaction (group differences in growth).
    epsilon_gg : float
        Greenhouse-Geisser epsilon, computed from the covariance within groups.
    """

    group: Effect
    of_level: Effect
    interaction: Effect
    epsilon_gg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupComparison:
    """Comparison of groups of participants.

    Parameters
    ----------
    column : str
        Column that contains the groups.
    n : Mapping
        Number of participants in each compared group.
    left_out : tuple of str
        Groups with fewer than three participants.
    without_group : int
        Number of participants without a group.
    exponents : Welch or NotComputed
        Comparison of participants' power-function exponents.
    levels : Welch or NotComputed
        Comparison of participants' log estimates, averaged over all amplitudes.
    anova : MixedAnova or NotComputed
        Mixed analysis of variance of participants who have a mean log estimate at every amplitude.
    """

    column: str
    n: Mapping[str, int]
    left_out: tuple[str, ...]
    without_group: int
    exponents: Welch | NotComputed
    levels: Welch | NotComputed
    anova: MixedAnova | NotComputed

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, levels=Unchanged("levels"))


def membership(data: Dataset) -> pd.Series[str] | NotComputed:
    """Return each participant's group, omitting participants without a group.

    Raises
    ------
    UserError
        The file participants.tsv does not contain the column that the study selects.
    """
    asked = data.choices.group
    about = data.participants
    columns = [str(name) for name in about.columns if name != PARTICIPANT]
    if asked is not None and asked not in columns:
        raise UserError(
            "{data_name}: the table of participants has no column '{asked}', the value of "
            "analysis.group; found {listed}",
            data_name=data.name,
            asked=asked,
            listed=listed(columns, NAMED) if columns else "none",
        )
    column = asked or DEFAULT_COLUMN
    if column not in columns:
        return NotComputed("no groups are defined")
    named = about.dropna(subset=[column]).drop_duplicates(PARTICIPANT)
    values = [f"{one:g}" if isinstance(one, float) else str(one) for one in named[column]]
    return pd.Series(values, index=named[PARTICIPANT].astype(str), name=column)


def compare_groups(
    data: Prepared, group_of: pd.Series[str] | NotComputed
) -> GroupComparison | NotComputed:
    """Compare exponents, levels and growth between groups.

    Parameters
    ----------
    group_of : Series or NotComputed
        Result of `membership`.
    """
    if isinstance(group_of, NotComputed):
        return group_of
    if data.refused:
        return NotComputed(data.zero_sentence)
    people = data.logs.index.astype(str)
    groups = group_of.reindex(people)
    sizes = groups.value_counts().sort_index()
    compared = [str(name) for name in sizes.index[sizes >= FEWEST]]
    small = [str(name) for name in sizes.index[sizes < FEWEST]]
    if len(compared) < 2:  # noqa: PLR2004
        named = f"; smaller: {listed(small, NAMED)}" if small else ""
        return NotComputed(
            few(f"groups of {FEWEST} participants or more", len(compared), 2) + named
        )
    slopes = exponents(data.logs)["exponent"].to_numpy(float)
    whole = data.whole_logs
    levels = whole.mean(axis=1).reindex(data.logs.index).to_numpy(float)
    kept = groups.to_numpy()
    confidence = data.choices.confidence
    return GroupComparison(
        column=str(group_of.name),
        n={name: int(sizes[name]) for name in compared},
        left_out=tuple(small),
        without_group=int(groups.isna().sum()),
        exponents=_welch(slopes, kept, compared, confidence),
        levels=_welch(levels, kept, compared, confidence),
        anova=_mixed_anova(whole, group_of, compared, data),
    )


def _welch(
    values: NDArray[np.float64], groups: NDArray[np.object_], compared: list[str], confidence: float
) -> Welch | NotComputed:
    own = {name: values[(groups == name) & np.isfinite(values)] for name in compared}
    for name, found in own.items():
        if len(found) < FEWEST:
            return NotComputed(f"group '{name}': {few('participants with a value', len(found))}")
    return welch(own, confidence)


def _mixed_anova(
    logs: pd.DataFrame, group_of: pd.Series[str], compared: list[str], data: Prepared
) -> MixedAnova | NotComputed:
    """Return the mixed ANOVA from pingouin, which agrees with R if no values are missing."""
    import pingouin

    groups = group_of.reindex(logs.index.astype(str)).to_numpy()
    table = logs.set_axis(groups, axis=0)[np.isin(groups.astype(str), compared)]
    for name in compared:
        if (n := int((table.index == name).sum())) < FEWEST:
            whom = f"participants with an estimate at every {data.quantity.level}"
            return NotComputed(f"group '{name}': {few(whom, n)}")
    n, k = table.shape
    if k < 2:  # noqa: PLR2004
        return NotComputed(few(data.quantity.levels, k, 2))
    residuals = table.to_numpy(float) - table.groupby(level=0).transform("mean").to_numpy(float)
    if np.abs(residuals - residuals.mean(axis=1, keepdims=True)).max() <= TINY:
        return NotComputed(
            "no variance remains after removing the means of participants and groups"
        )
    long = pd.DataFrame(
        {
            "who": np.repeat(np.arange(n), k),
            "group": np.repeat(table.index.to_numpy(), k),
            "amplitude": np.tile(table.columns.to_numpy(float), n),
            "value": table.to_numpy(float).ravel(),
        }
    )
    with warnings.catch_warnings():
        # Suppresses only pingouin's warning with pandas 3 (dropna in place).
        warnings.filterwarnings("ignore", category=pd.errors.Pandas4Warning)
        found = pingouin.mixed_anova(
            data=long, dv="value", within="amplitude", subject="who", between="group"
        ).set_index("Source")
    epsilon = float(found.loc["amplitude", "eps"]) if k > 2 else 1.0  # noqa: PLR2004
    group, amplitude, interaction = (
        effect(
            found.loc[source, "F"],
            found.loc[source, "DF1"],
            found.loc[source, "DF2"],
            own_epsilon,
            data.choices.confidence,
        )
        for source, own_epsilon in (
            ("group", 1.0),
            ("amplitude", epsilon),
            ("Interaction", epsilon),
        )
    )
    return MixedAnova(group=group, of_level=amplitude, interaction=interaction, epsilon_gg=epsilon)


def _groups(inputs: Inputs) -> GroupComparison | NotComputed:
    compare = partial(compare_groups, group_of=membership(inputs.data))
    return of_estimates(compare)(inputs)


def _welch_ps(found: GroupComparison) -> list[float]:
    parts = (found.exponents, found.levels)
    return [part.p for part in parts if part]


def _pair_ps(found: GroupComparison) -> list[float]:
    parts = [part for part in (found.exponents, found.levels) if part]
    # With two groups, the pairwise test equals the overall test.
    return [pair.p for part in parts if len(part.groups) > 2 for pair in part.pairs]  # noqa: PLR2004


def _mixed_ps(found: GroupComparison) -> list[float]:
    anova = found.anova
    return [anova.group.p, anova.interaction.p] if anova else []


class _Groups(Statistic[GroupComparison]):
    key = "groups"
    meaning = "comparison of groups of participants"
    title = "Groups of participants"
    families = (
        Family(name="groups, Welch's tests", read=_welch_ps),
        Family(name="pairs of groups, Welch's t", corrected=True, read=_pair_ps),
        Family(name="groups, mixed analysis of variance", read=_mixed_ps),
    )
    methods = (
        "Exponents and mean log estimates were compared between groups by Welch's tests "
        "[[welch1951]], with Holm's correction for pairs of groups. Mean log estimates were also "
        "compared in a mixed analysis of variance with group (between participants) and {q.name} "
        "(within), with the Greenhouse–Geisser correction [[greenhouse1959]]."
    )

    compute = staticmethod(_groups)


GROUPS = _Groups()
