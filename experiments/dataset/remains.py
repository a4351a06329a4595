"""Find what may still hold data of a participant who withdrew, in files of other programs.

Editors, archives and version control keep copies whose names do not show what they hold.
"""

from __future__ import annotations

import mmap
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from slipscale.experiments.dataset.withdrawn import RECORD

#: The label in the name of a participant's file.
LABEL = re.compile(r"(?<![A-Za-z0-9])sub-([A-Za-z0-9]+)")
#: Files whose contents cannot be searched. Compressed tables of a data set are named after people.
PACKED = (
    *("7z", "bundle", "bz2", "gz", "rar", "tar", "tgz", "xz", "zip", "zst"),
    *("docx", "jasp", "mat", "ods", "odt", "omv", "parquet", "pdf", "pkl", "rdata", "rds"),
    *("sav", "xls", "xlsb", "xlsm", "xlsx", "zsav"),
)
ARCHIVES = re.compile(rf"(?<!\.tsv)\.({'|'.join(PACKED)})$", re.IGNORECASE)
#: Folders of version control, which keep every former state.
HISTORIES = (".git", ".hg", ".svn", ".datalad")


def remains(dataset: Path, participant: str) -> list[Path]:
    """Return the files in a data set that name a participant or cannot be searched, sorted.

    Call this after the participant's own files were removed.
    """
    return sorted(_remains(dataset, participant))


def linked(paths: Sequence[Path]) -> list[Path]:
    """Return the places outside these folders to which links in them lead."""
    found = {
        link.resolve()
        for path in paths
        for link in (path, *(path.rglob("*") if path.is_dir() else ()))
        if link.is_symlink()
    }
    return sorted(each for each in found if each.exists())


def _remains(dataset: Path, participant: str) -> Iterator[Path]:
    label = re.escape(participant.encode())
    # The second form is that of a journal's header.
    named = re.compile(
        rb'(?<![A-Za-z0-9])sub-%b(?![A-Za-z0-9])|"participant": ?"%b"' % (label, label)
    )
    for path in dataset.rglob("*"):
        inside = path.relative_to(dataset)
        if inside.parts[0] in HISTORIES:
            if len(inside.parts) == 1:
                yield path
        elif participant in LABEL.findall(path.name) or (
            path.is_file()
            and inside != RECORD
            and (ARCHIVES.search(path.name) or _has(path, named))
        ):
            yield path


def _has(path: Path, named: re.Pattern[bytes]) -> bool:
    """Return whether a file contains a pattern, or cannot be read."""
    try:
        if not path.stat().st_size:
            return False
        with path.open("rb") as stream:
            text = mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)
            with text:
                return named.search(text) is not None
    except OSError:
        return True
