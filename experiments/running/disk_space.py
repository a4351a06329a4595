"""Check that disk space is available, including under quotas, by allocating the space."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import IO

BLOCK = 1_000_000


def why_not_taken(folder: Path, size: int) -> str:
    """Return the reason why a folder cannot store a file of ``size`` bytes; empty if it can.

    A temporary file is created for this test. Raises OSError if no file can be created.
    """
    with tempfile.TemporaryFile(dir=folder) as trial:
        try:
            _take(trial, size)
        except OSError as error:
            return str(error.strerror)
    return ""


def _take(stream: IO[bytes], size: int) -> None:
    """Allocate ``size`` bytes in the file system."""
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(stream.fileno(), 0, size)
    else:  # on macOS and Windows, the space must be written
        for _ in range(0, size, BLOCK):
            stream.write(bytes(BLOCK))
    stream.flush()
    os.fsync(stream.fileno())
