"""Unpack compressed files: gzip, bzip2, xz, and zip archives with one table."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import IO

from slipscale.analysis.reading.cells import listed
from slipscale.faults import UserError

#: Maximum unpacked size of a file.
LARGEST_MB = 300
#: First bytes of compressed files.
PACKED: dict[bytes, Callable[[io.BytesIO], io.BufferedIOBase]] = {
    b"\x1f\x8b": lambda file: gzip.GzipFile(fileobj=file),
    b"BZh": bz2.BZ2File,
    b"\xfd7zXZ\x00": lzma.LZMAFile,
}
#: Endings of compressed files. Files of other programs may be compressed too.
ARCHIVE, ENDINGS = ".zip", (".gz", ".bz2", ".xz", ".zip")


def unpacked(content: bytes, path: Path) -> tuple[bytes, Path]:
    """Return the content of a file and its name without the ending of the compression.

    Raises
    ------
    UserError
        If the file is damaged or too large, or an archive does not contain one file.
    """
    opened = next((PACKED[mark] for mark in PACKED if content.startswith(mark)), None)
    archive = path.suffix.lower() == ARCHIVE
    if opened is None and not archive:
        return content, path
    inner = path.with_suffix("") if path.suffix.lower() in ENDINGS else path
    file = io.BytesIO(content)
    try:
        if archive:
            files = zipfile.ZipFile(file)
            names = [name for name in files.namelist() if not name.startswith("__MACOSX/")]
            names = [name for name in names if not name.endswith("/")]
            if len(names) != 1:
                raise UserError(
                    "{path}: the archive contains {names}; expected one table (unpack the archive "
                    "and name its folder to read several)",
                    path=path,
                    names=listed(names) or "no files",
                )
            inner = path.with_name(Path(names[0]).name)
            stream: io.BufferedIOBase | IO[bytes] = files.open(names[0])
        else:
            stream = opened(file) if opened else file
        with stream:
            found = stream.read(LARGEST_MB * 2**20 + 1)
    except (OSError, EOFError, ValueError, RuntimeError, NotImplementedError) as error:
        raise _damaged(path, error) from None
    except (zipfile.BadZipFile, zlib.error, lzma.LZMAError) as error:
        raise _damaged(path, error) from None
    if len(found) > LARGEST_MB * 2**20:
        raise UserError(
            "{path}: more than {largest_mb} MB when unpacked; expected a smaller table, or the "
            "unpacked file",
            path=path,
            largest_mb=LARGEST_MB,
        )
    return found, inner


def _damaged(path: Path, error: Exception) -> UserError:
    return UserError(
        "{path}: the file cannot be unpacked ({error}); expected a complete file, or the table "
        "without compression",
        path=path,
        error=error,
    )
