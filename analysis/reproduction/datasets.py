"""Count the raw data sets consistent with Table III, and report conclusions from them.

The paper does not contain these counts and conclusions. They follow from Table III if ratings are
whole numbers from 0 to 100, regardless of which participant gave which rating. The paper does not
state which standard deviation (SD) it uses, so the lowest and highest values cover both
conventions. For each bound on a statistic, the explanation in the output states the value under
each convention and the table of ratings that attains the bound (see `attained_bounds`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from itertools import combinations
from math import prod
from typing import TYPE_CHECKING

from slipscale.analysis.reconstruction.report import outward, ratings
from slipscale.analysis.reconstruction.table.published_table import CONVENTIONS
from slipscale.analysis.reproduction import allowed_datasets
from slipscale.analysis.reproduction.attained_bounds import COMMAND, known
from slipscale.analysis.reproduction.comparison import Outcome, record

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.analysis.reconstruction.inference.conclusions import Conclusion

AMPLITUDES_UM_PP = allowed_datasets.AMPLITUDES_UM_PP
ENDS = ("lowest", "highest")


WHOLE_RATINGS = (
    "ratings are assumed to be integers from 0 to 100: the published means and maximum "
    "deviations give extreme ratings of 40.00, 30.00, 40.00 and 100.00, and if ratings were not "
    "integers, the probability that all four means match twelve integer ratings would be only 2e-4"
)


@cache
def _counts() -> dict[tuple[float, str], allowed_datasets.Count]:
    return {(c.amplitude_um_pp, c.sd_convention): c for c in allowed_datasets.counts()}


@cache
def _conclusions() -> dict[str, dict[str, Conclusion]]:
    found: dict[str, dict[str, Conclusion]] = {}
    for convention in CONVENTIONS:
        for one in known(convention):
            found.setdefault(one.name, {})[convention] = one
    return found


def datasets(amplitude_um_pp: float, convention: str) -> Outcome:
    """Count the multisets of twelve integers that are consistent with a column of Table III."""
    count = _counts()[amplitude_um_pp, convention]
    return Outcome(
        published=None,
        ours=float(count.multisets),
        unit="multisets",
        reason=(
            f"exact count, with the {convention} standard deviation; {count.ordered:,} if "
            f"participants are distinguished; {WHOLE_RATINGS}"
        ),
        exact=count.multisets,
    )


def tables(convention: str) -> Outcome:
    """Count the 12 x 4 tables (participants, amplitudes) that are consistent with Table III."""
    exact = prod(_counts()[amplitude, convention].ordered for amplitude in AMPLITUDES_UM_PP)
    return Outcome(
        published=None,
        ours=float(exact),
        unit="tables",
        reason=(
            f"{exact:,} tables with the {convention} standard deviation: the product of the "
            "numbers of ordered samples of the four columns, because ratings in different "
            "columns can be paired in any way"
        ),
    )


def bound(name: str, end: str) -> Outcome:
    """Return the lowest or highest value of a statistic over all data sets and all pairings."""
    found = _conclusions()[name]
    values = {word: one.low if end == "lowest" else one.high for word, one in found.items()}
    extreme = (min if end == "lowest" else max)(values, key=lambda word: values[word])
    attained = found[extreme]
    table = attained.at_low if end == "lowest" else attained.at_high
    always = all(one.decided for one in found.values())
    holds = "is the same in every data set" if always else "depends on the data set"
    each = ", ".join(
        f"{outward(value, down=end == 'lowest')} with the {word} SD"
        for word, value in values.items()
    )
    ps = [p for one in found.values() for p in (one.p_low, one.p_high) if p is not None]
    p = f"p at most {max(ps):.2g}" if name == "rm_f" else f"p from {min(ps):.2g} to {max(ps):.2g}"
    return Outcome(
        published=None,
        ours=values[extreme],
        unit="",
        text=outward(values[extreme], down=end == "lowest"),
        reason=(
            f"{attained.question}: the conclusion {holds}; {each}, if means and SDs were "
            f"rounded, not truncated; {p}; the extreme is attained with the {extreme} SD by "
            f"{ratings(attained.labels, table)}. To repeat the search, run {COMMAND}"
        ),
    )


def _bounded() -> dict[str, tuple[str, str]]:
    """Return the name of the conclusion and "lowest" or "highest", keyed by item name."""
    pairs = [
        f"{test}.{one:g} um.{other:g} um"
        for one, other in combinations(AMPLITUDES_UM_PP, 2)
        for test in ("sign", "t")
    ]
    names = {f"conclusions.{name.replace(' um', 'um')}": name for name in pairs}
    items = {f"{item}.{end}": (name, end) for item, name in names.items() for end in ENDS}
    # No recorded table attains the upper bound on F.
    return items | {"conclusions.rm_f.lowest": ("rm_f", "lowest")}


ITEMS: dict[str, Callable[[], Outcome]] = {
    **{
        f"datasets.{amplitude:g}.{convention}": partial(datasets, amplitude, convention)
        for amplitude in AMPLITUDES_UM_PP
        for convention in CONVENTIONS
    },
    **{f"datasets.tables.{convention}": partial(tables, convention) for convention in CONVENTIONS},
    **{item: partial(bound, *which) for item, which in _bounded().items()},
}
FIGURES: Mapping[str, Callable[[], Figure]] = {}


if __name__ == "__main__":
    record(ITEMS, "datasets.json")
