"""Check whether data sets consistent with a table can reproduce its published tests.

For independent groups, the verdict depends only on n, the sums and the sums of squares. For columns
from the same participants, it also depends on the sum of cross products, which is unknown because
the pairing is unknown (see `cross_products`).

Verdicts:

- *Impossible* means that no combination of sums, sums of squares and, for paired columns, sums of
  cross products reproduces the published test, and that a search with formulas taken from the
  definitions (`definitions`) finds no counterexample.
- *Possible* means that a search found an example table whose statistic, computed from the
  definition, reproduces the published test.
- All other tests are *not decided*.
- An undefined statistic (t of equal differences, F or t without variation within groups, r of a
  constant column) never matches a published test.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from slipscale.analysis.reconstruction.inference.comparable_columns import require_comparable
from slipscale.analysis.reconstruction.inference.group_tests import of_independent_groups
from slipscale.analysis.reconstruction.inference.paired_tests import of_pairs
from slipscale.analysis.reconstruction.inference.printed_test_answer import (
    PAIRED,
    Case,
    PrintedTestAnswer,
    chosen_columns,
)

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
    from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest


def answer(test: PrintedTest, columns: Sequence[Solutions]) -> PrintedTestAnswer:
    """Check a published test.

    Raises
    ------
    UserError
        If a test of two columns does not name them and the table does not have exactly two columns,
        or if the columns cannot be compared.
    """
    chosen = chosen_columns(test, [(s.column.label, s) for s in columns])
    if test.kind in PAIRED:
        require_comparable(chosen)
    case = Case(test, tuple(chosen))
    for solutions in chosen:
        if solutions.targets.refused:
            return case.said("not decided", solutions.targets.refused)
        if not solutions.targets.wanted:
            label = solutions.column.label
            return case.said("impossible", f"no ratings give the published column '{label}'")
    return of_pairs(case) if test.kind in PAIRED else of_independent_groups(case)
