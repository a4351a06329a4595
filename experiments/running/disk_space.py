"""Whether a disk gives the space that it says is free: quotas and limits are met by taking it."""

from __future__ import annotations

import os
import tempfile
from typing import IO, TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

BLOCK = 1_000_000


def why_not_taken(folder: Path, size: int) -> str:
    """Return why a file of ``size`` bytes cannot be kept in a folder; empty where it can.

    The file has no name, and is gone afterwards. OSError where none can be begun.
    """
    with tempfile.TemporaryFile(dir=folder) as trial:
        try:
            _take(trial, size)
        except OSError as error:
            return str(error.strerror)
    return ""


def _take(stream: IO[bytes], size: int) -> None:
    """Have the file system set so many bytes aside."""
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(stream.fileno(), 0, size)
    else:  # macOS and Windows: by writing
        for _ in range(0, size, BLOCK):
            stream.write(bytes(BLOCK))
    stream.flush()
    os.fsync(stream.fileno())
