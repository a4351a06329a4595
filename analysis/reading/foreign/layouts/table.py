"""List how the layouts of tables are read, keyed by the name of their rule.

To support another layout, write a module, add a line to `LAYOUTS`, and add its options to
`slipscale.analysis.reading.meaning.layout_rules`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.foreign.layouts import (
    differences,
    matrix,
    paired_rows,
    pairs,
    people_in_columns,
    wide,
)
from slipscale.analysis.reading.foreign.layouts.answers import convert_trials
from slipscale.analysis.reading.foreign.layouts.layout import Layout
from slipscale.analysis.reading.meaning.layout_rules import rule_of

if TYPE_CHECKING:
    from slipscale.analysis.reading.meaning.mapping import TableMapping

LAYOUTS = {
    "a square table": Layout(everything=True, reshape=matrix.reshape, convert=matrix.convert),
    "a table of quadruples or triads": Layout(convert=differences.convert),
    "a table of pairs": Layout(convert=pairs.convert),
    "a table with people in columns": Layout(
        everything=True, reshape=people_in_columns.reshape, convert=convert_trials
    ),
    "a wide table": Layout(reshape=wide.reshape, convert=convert_trials),
    "a table of counts": Layout(convert=convert_trials),
    "a table of answers": Layout(reshape=paired_rows.reshape, convert=convert_trials),
    "a table of magnitude estimates": Layout(reshape=paired_rows.reshape, convert=convert_trials),
}


def layout_of(mapping: TableMapping) -> Layout:
    """Return the layout that a mapping describes."""
    return LAYOUTS[rule_of(mapping.given).name]
