"""Write tables as SPSS files (``.sav``), which jamovi and JASP can open too."""

from __future__ import annotations

import re
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas as pd

#: Words that no variable of SPSS can have as its name.
RESERVED = {"all", "and", "by", "eq", "ge", "gt", "le", "lt", "ne", "not", "or", "to", "with"}
TRUTH = {0.0: "no", 1.0: "yes"}


def write_sav(table: pd.DataFrame, path: Path) -> None:
    """Write a table; variable labels are the names of its columns.

    Numbers are scale variables. Texts are nominal, and so are true and false, which are 0 and 1
    with value labels. A missing number is a system-missing value, and a missing text is empty.
    """
    import pyreadstat

    names = variable_names([str(name) for name in table.columns])
    columns, measures, labels = {}, {}, {}
    for name, (_, column) in zip(names, table.items(), strict=True):
        kinds = {type(each) for each in column.dropna()}
        truth = bool(kinds) and all(issubclass(kind, bool | np.bool_) for kind in kinds)
        numeric = truth or all(issubclass(kind, Real) for kind in kinds)
        measures[name] = "nominal" if truth or not numeric else "scale"
        columns[name] = (
            column.astype("float64") if numeric else column.astype(str).where(column.notna(), "")
        )
        if truth:
            labels[name] = TRUTH
    frame = table.set_axis(names, axis=1).assign(**columns)
    pyreadstat.write_sav(
        frame,
        path,
        column_labels=[str(name) for name in table.columns],
        variable_measure=measures,
        variable_value_labels=labels,
    )


def variable_names(names: list[str]) -> list[str]:
    """Return valid and different SPSS names: letters, digits and _, beginning with a letter.

    >>> variable_names(["amplitude_um_pp", "p (Holm)", "p Holm", "by", "95 %"])
    ['amplitude_um_pp', 'p_Holm', 'p_Holm_2', 'by_', 'v95']
    """
    found: list[str] = []
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_") or "v"
        plain = plain if plain[0].isalpha() else f"v{plain}"
        plain = f"{plain}_" if plain.lower() in RESERVED else plain
        taken = {each.lower() for each in found}
        number = 2
        unique = plain
        while unique.lower() in taken:
            unique, number = f"{plain}_{number}", number + 1
        found.append(unique)
    return found
