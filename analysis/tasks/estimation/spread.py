"""Check whether repeated estimates have the same spread at all levels, as rank tests assume."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from slipscale.analysis.preprocessing.log_transform import Prepared

#: Ratio of standard deviations above which rank tests of arithmetic means are unreliable.
NOTICEABLE = 1.75
#: Smallest number of differences between repetitions for which standard deviations are compared.
FEWEST = 12


def unequal_spread(data: Prepared) -> list[str]:
    """Return a warning if the spread of repeated log estimates differs between levels.

    The arithmetic mean of skewed estimates increases with the spread. At levels with equal
    geometric means and unequal spreads, the arithmetic means therefore differ, and rank tests
    reject too often. In 1,000 simulated studies with 12 participants and standard deviations of 0.3
    and 0.6 (natural logarithms), Wilcoxon's test was significant at the 5 % level in 9 % of studies
    with 3 repetitions and in 21 % with 6. With equal spreads, the test was significant in 4 % of
    studies.
    """
    usable = data.trials[data.trials["log"].notna()]
    cells = usable.groupby([PARTICIPANT, "item"], observed=True)["log"]
    around = usable.assign(
        square=(usable["log"] - cells.transform("mean")) ** 2,
        freedom=1 - 1 / cells.transform("size"),
    )
    sums = around.groupby("level", observed=True)[["square", "freedom"]].sum()
    sums = sums.loc[sums["freedom"] >= FEWEST]
    levels = sums.index.to_numpy(float)
    deviations = np.sqrt((sums["square"] / sums["freedom"]).to_numpy(float))
    if len(deviations) < 2 or deviations.min() <= 0:  # noqa: PLR2004
        return []
    most, least = levels[deviations.argmax()], levels[deviations.argmin()]
    ratio = deviations.max() / deviations.min()
    if ratio < NOTICEABLE:
        return []
    value = data.quantity.value
    return [
        (
            f"The SD of repeated log estimates is {ratio:.1f} times as large at {value(most)} as "
            f"at {value(least)}. Rank tests then produce too many false positives: in 9 % of "
            "studies instead of 5 % with a ratio of 2, 12 participants and 3 repetitions. Prefer "
            "the tests on logarithms."
        )
    ]
