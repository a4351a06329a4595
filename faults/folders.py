"""List the files of a folder, without hidden files.

Names of hidden files begin with a dot. On disks with another file system, macOS writes a hidden
file ``._name`` beside every file, whose name matches the same patterns.
"""

from __future__ import annotations

from pathlib import Path


def visible(folder: Path, pattern: str) -> list[Path]:
    """Return the paths in a folder that match a pattern, sorted, without hidden ones."""
    return sorted(
        path
        for path in folder.glob(pattern)
        if not any(part.startswith(".") for part in path.relative_to(folder).parts)
    )
