"""Convert results to a flat table with columns named after the keys of ``inference.json``."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from slipscale.analysis.json_form import JsonObject, record


def flat(results: Iterable[object]) -> pd.DataFrame:
    """Return results as a table; for the columns, see `flat_rows`."""
    return pd.DataFrame(flat_rows({}, results))


def flat_rows(above: JsonObject, results: Iterable[object]) -> list[JsonObject]:
    """Return one row per result, with the columns in ``above`` first.

    An interval ``[low, high]`` is split into two columns, such as ``ratio_ci_low`` and
    ``ratio_ci_high``. The field ``interval`` becomes ``ci_low`` and ``ci_high``.
    """
    rows = []
    for result in results:
        row = dict(above)
        for field, found in record(result).items():
            own = field == "interval"
            name, value = ("ci", found or [None, None]) if own else (field, found)
            parts = zip(("_low", "_high"), value, strict=True) if isinstance(value, list) else ()
            row |= {name + end: bound for end, bound in parts} or {name: value}
        rows.append(row)
    return rows
