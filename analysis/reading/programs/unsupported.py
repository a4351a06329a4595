"""Reject files of other programs, with the command that converts them to CSV."""

from __future__ import annotations

from pathlib import Path

from slipscale.faults import UserError

#: Functions of pandas that read a file, with what follows the name of the file.
PANDAS = {
    ".ods": ("read_excel", ', engine="odf")'),
    ".parquet": ("read_parquet", ")"),
    ".feather": ("read_feather", ")"),
    ".pkl": ("read_pickle", ")"),
    ".pickle": ("read_pickle", ")"),
    ".h5": ("read_hdf", ")"),
    ".sas7bdat": ("read_sas", ', encoding="utf-8")'),
    ".xpt": ("read_sas", ', encoding="utf-8")'),
    ".htm": ("read_html", ")[0]"),
    ".html": ("read_html", ")[0]"),
}
#: Functions of R that read a file, with what follows the name of the file.
R = {".rds": ("readRDS", ")"), ".rdata": ("get(load", ")[1])"), ".rda": ("get(load", ")[1])")}
#: Programs whose own files are exported from the program itself.
EXPORTED = {".jasp": "JASP", ".omv": "jamovi", ".numbers": "Numbers", ".jmp": "JMP"}


def recognises(_head: str, path: Path) -> bool:
    """Return whether a file has an ending of a program that is not supported."""
    return path.suffix.lower() in {*PANDAS, *R, *EXPORTED}


def refuse(path: Path) -> UserError:
    """Return the error that states how the file is converted."""
    ending = path.suffix.lower()
    if ending in EXPORTED:
        return UserError(
            "{path}: {program} files are not supported; export the data from {program} as CSV",
            path=path,
            program=EXPORTED[ending],
        )
    function, rest = (R if ending in R else PANDAS)[ending]
    read, csv = f'{function}("{path.name}"{rest}', f'"{path.stem}.csv"'
    return UserError(
        "{path}: {ending} files are not supported; convert the file to CSV with {language}: "
        "{command}",
        path=path,
        ending=ending,
        language="R" if ending in R else "Python",
        command="".join(
            ("write.csv(", read, ", ", csv, ", row.names = FALSE)")
            if ending in R
            else ("import pandas; pandas.", read, ".to_csv(", csv, ", index=False)")
        ),
    )
