"""Find the participant in the names of files: the part that differs between them.

Dates and times in names, which PsychoPy and other programs add, are not participants.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from slipscale.faults import UserError

#: Dates and times as programs write them: 2026-03-01_10h12.05.123, 2026_Mar_01_1012, 20260301-1012.
DATE = re.compile(
    r"(?<![^\W_])(?:(?:19|20)\d\d[-_.]?(?:[01]\d|[A-Z][a-z]{2})[-_.]?[0-3]\d)"
    r"(?:[-_ T]*\d{1,2}[-h:._]?\d\d(?:[-m:._]?\d\d)?(?:[.s]\d+)?)?(?![^\W_])"
)
#: Ending of compressed files, which have another ending before it.
PACKED = ".gz"
PARTS = re.compile(r"[_\s/\\]+")


def people_in_names(paths: Sequence[Path], pattern: str) -> list[str]:
    """Return the participant's label for each file.

    Parameters
    ----------
    paths : sequence of Path
    pattern : str
        Regular expression with one group, which is the label; if it is empty, the part of the names
        that differs.

    Raises
    ------
    UserError
        If a name does not match the pattern, or if more than one part differs.
    """
    if pattern:
        return [_matched(path, pattern) for path in paths]
    names = _names(paths)
    undated = [DATE.sub("", name) for name in names]
    parts = [PARTS.split(name.strip("_- ")) for name in (undated if all(undated) else names)]
    widths = {len(each) for each in parts}
    if len(widths) == 1:
        columns = list(zip(*parts, strict=True))
        differing = [column for column in columns if len(set(column)) > 1]
        # One file, or one participant in all of them.
        differing = differing or columns[:1]
        if len(differing) == 1:
            return list(differing[0])
    raise UserError(
        "--participant-from-name: more than one part of the file names differs ({one}, {other}); "
        "expected a pattern with one group, such as --participant-from-name '^([^_]+)'",
        one=paths[0].name,
        other=paths[-1].name,
    )


def _names(paths: Sequence[Path]) -> list[str]:
    """Return the names without their endings; names that do not differ, with their folders."""
    paths = [path.with_suffix("") if path.suffix == PACKED else path for path in paths]
    names = [path.stem for path in paths]
    if len(set(names)) == len(names):
        return names
    return [path.with_suffix("").as_posix() for path in paths]


def _matched(path: Path, pattern: str) -> str:
    found = re.search(pattern, path.name)
    if found is None or not found[1]:
        raise UserError(
            "{path}: the name does not match the pattern {pattern}; expected a group that contains "
            "the participant in every file's name",
            path=path,
            pattern=pattern,
        )
    return found[1]
