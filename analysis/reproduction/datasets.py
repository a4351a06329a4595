"""Every raw data set that Table III allows: how many there are, and what holds in all of them.

The paper prints none of these numbers; they are what its Table III implies, whoever rated what.
A conclusion's lowest and highest value are over all data sets and all pairings of the ratings of
one participant; where no data set is known to attain a bound, the reason says so.
"""

from __future__ import annotations

from functools import cache, partial
from itertools import combinations
from typing import TYPE_CHECKING, Any

from analysis.reconstruction.published_table import CONVENTIONS
from analysis.reproduction import allowed_datasets
from analysis.reproduction.comparison import Outcome, record

if TYPE_CHECKING:
    from collections.abc import Callable

    from analysis.reconstruction.conclusions import Conclusion

AMPLITUDES_UM_PP = allowed_datasets.AMPLITUDES_UM_PP
ENDS = ("lowest", "highest")


@cache
def _counts() -> dict[tuple[float, str], int]:
    return {(c.amplitude_um_pp, c.sd_convention): c.multisets for c in allowed_datasets.counts()}


@cache
def _conclusions() -> dict[str, Conclusion]:
    section = allowed_datasets.section()
    return {found.name: found for found in section.always + section.depends}


def datasets(amplitude_um_pp: float, convention: str) -> Outcome:
    """Return how many multisets of twelve integers a column of Table III allows."""
    return Outcome(
        published=None,
        ours=float(_counts()[amplitude_um_pp, convention]),
        unit="multisets",
        reason=f"exact count, with the {convention} standard deviation",
    )


def bound(name: str, end: str) -> Outcome:
    """Return a conclusion's lowest or highest value over all data sets and pairings."""
    found = _conclusions()[name]
    holds = "the same conclusion in every data set" if found.decided else "depends on the data set"
    return Outcome(
        published=None,
        ours=found.low if end == "lowest" else found.high,
        unit="",
        reason=f"{found.question}: {holds}" + ("" if found.sharp else "; a bound, maybe not met"),
    )


def _bounded() -> dict[str, tuple[str, str]]:
    """Return the items of bounds: (the conclusion's name, which end)."""
    pairs = [
        f"{test}.{one:g} um.{other:g} um"
        for one, other in combinations(AMPLITUDES_UM_PP, 2)
        for test in ("sign", "t")
    ]
    names = {f"conclusions.{name.replace(' um', 'um')}": name for name in pairs}
    items = {f"{item}.{end}": (name, end) for item, name in names.items() for end in ENDS}
    # From above, F is not bounded by the table.
    return items | {"conclusions.rm_f.lowest": ("rm_f", "lowest")}


ITEMS: dict[str, Callable[[], Outcome]] = {
    **{
        f"datasets.{amplitude:g}.{convention}": partial(datasets, amplitude, convention)
        for amplitude in AMPLITUDES_UM_PP
        for convention in CONVENTIONS
    },
    **{item: partial(bound, *which) for item, which in _bounded().items()},
}
FIGURES: dict[str, Any] = {}


if __name__ == "__main__":
    record(ITEMS, "datasets.json")
