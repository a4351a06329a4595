"""Read MATLAB ``.mat`` files, versions 4 to 7: variables, a structure or a structure array.

A table is a structure array, a structure with fields of equal length, separate vectors of equal
length, or a matrix, whose columns are called 1, 2, 3. Single values next to vectors are repeated in
every row. If a file contains several tables, ``--sheet`` selects one by the name of its variable.
MATLAB ``table`` objects and version 7.3 files are not supported; the error message contains a
command that saves them in a supported format.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reading.programs.records import framed
from slipscale.analysis.reading.programs.wanted import SeveralTables
from slipscale.faults import UserError

if TYPE_CHECKING:
    import pandas as pd

    Table = dict[str, Sequence[object]]

SAVE = (
    "save it in MATLAB with: s = table2struct(T, 'ToScalar', true); save('data.mat', '-struct', "
    "'s', '-v7')"
)
#: First bytes of a version 7.3 file, which is in HDF5 format.
VERSION_7_3 = b"MATLAB 7.3 MAT-file"


def recognises(_head: str, path: Path) -> bool:
    """Return whether a file was written by MATLAB."""
    return path.suffix.lower() == ".mat"


def read(content: bytes, path: Path, sheet: str | None) -> pd.DataFrame:
    """Read one row per element, as text or numbers; ``line`` is the row number, from 1.

    Parameters
    ----------
    sheet : str or None
        Name of the variable; None selects the only table.

    Raises
    ------
    UserError
        If the file cannot be read, or does not contain one table.
    """
    tables = _tables(content, path)
    chosen = [tables[sheet]] if sheet in tables else list(tables.values()) if not sheet else []
    if len(chosen) != 1:
        named = ", ".join(name or "the vectors" for name in tables) or "none"
        several = not sheet and len(tables) > 1 and all(tables)
        raise (partial(SeveralTables, names=list(tables)) if several else UserError)(
            "{path}: the file contains these tables: {named}; expected one table, or --sheet "
            "with the name of a table; {remedy}",
            path=path,
            named=named,
            remedy=SAVE,
        )
    (table,) = chosen
    length = len(next(iter(table.values())))
    rows = [{name: cells[i] for name, cells in table.items()} for i in range(length)]
    return framed(rows, range(1, length + 1))


def _tables(content: bytes, path: Path) -> dict[str, Table]:
    from scipy import io as scipy_io

    if content.startswith(VERSION_7_3):
        raise UserError(
            "{path}: a MATLAB 7.3 file; expected version 7; {remedy}", path=path, remedy=SAVE
        )
    try:
        found = scipy_io.loadmat(io.BytesIO(content), simplify_cells=True)
    except Exception as error:  # noqa: BLE001 - loadmat raises whatever damaged bytes lead to
        raise UserError(
            "{path}: not a readable MATLAB file ({error}); {remedy}",
            path=path,
            error=error,
            remedy=SAVE,
        ) from None
    own = {name: value for name, value in found.items() if not name.startswith("__")}
    tables = {name: table for name, value in own.items() if (table := _table(value))}
    loose = _columns({name: value for name, value in own.items() if name not in tables})
    return tables | ({"": loose} if loose else {})


def _table(value: object) -> Table | None:
    """Convert a structure, an array of structures or a matrix to a table, or return None."""
    if isinstance(value, dict):
        return _columns(value)
    if isinstance(value, np.ndarray) and value.ndim == 2 and value.dtype.kind in "biuf":  # noqa: PLR2004 - a matrix
        return {str(place): list(cells) for place, cells in enumerate(value.T, start=1)}
    if isinstance(value, list | np.ndarray) and len(value) and isinstance(value[0], dict):
        names = list(value[0])
        return {name: [row.get(name) for row in value] for name in names}
    return None


def _columns(values: dict[str, object]) -> Table | None:
    """Return vectors of the same length, and repeat single values; None without such vectors.

    A structure often has a text or a number, such as the name of the participant, next to its
    vectors.
    """
    vectors = _alike(
        {str(name): cells for name, part in values.items() if (cells := _cells(part)) is not None}
    )
    if vectors is None:
        return None
    length = len(next(iter(vectors.values())))
    single = {
        str(name): [value] * length
        for name, value in values.items()
        if isinstance(value, str | int | float)
    }
    return vectors | single


def _alike(columns: dict[str, Sequence[object]]) -> Table | None:
    """Return `columns` if all have the same length of at least 2, otherwise None."""
    lengths = {len(cells) for cells in columns.values()}
    return columns if len(lengths) == 1 and min(lengths) > 1 else None


def _cells(value: object) -> Sequence[object] | None:
    """Return the elements of a vector, or None for single values, matrices and objects."""
    if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.names is None:
        return list(value)
    return value if isinstance(value, list) and len(value) else None
