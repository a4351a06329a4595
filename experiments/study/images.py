"""Embed the images of friction maps in the text of a study file.

The images are embedded when the study is read, because journals and data sets contain only the
study's text.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from slipscale.faults import UserError
from slipscale.stimuli.friction_map import MOST_PIXELS, WHITE, Greys, packed


def with_images(text: str, source: str) -> str:
    """Return the text of a study file with the images of its friction maps embedded.

    Parameters
    ----------
    text : str
        The study file's text. Text that is not TOML or names no image is returned unchanged.
    source : str
        The study file's path; images are located in the same folder.

    Raises
    ------
    UserError
        If a file cannot be read, or is not a greyscale PNG file of the right size.
    """
    if "image" not in text:
        return text
    try:
        tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError):
        return text  # the study parser reports the error
    import tomlkit

    document: Any = tomlkit.parse(text)
    textures = document.get("textures")
    tables = [document.get("stimulus"), *(textures if isinstance(textures, list) else [])]
    for table in tables:
        if not isinstance(table, dict) or "pixels" in table:
            continue
        if isinstance(name := table.get("image"), str):
            rows = _greys(source, name)
            table["pixels"], table["columns"] = packed(rows), len(rows[0])
    return tomlkit.dumps(document)


def _greys(source: str, name: str) -> Greys:
    """Read an image in the study file's folder, and return its rows of grey values."""
    if Path(name).name != name or "\\" in name or not name.lower().endswith(".png"):
        raise UserError(
            "{source}: image: {name}: expected the name of a PNG file next to the study file, "
            "without a folder",
            source=source,
            name=repr(name),
        )
    import numpy as np
    from matplotlib.image import imread

    path = Path(source).parent / name
    try:
        values = np.asarray(imread(path), dtype=float)
    except (OSError, ValueError, SyntaxError) as error:
        reason = getattr(error, "strerror", None) or "it is not a PNG file"
        raise UserError(
            "{source}: image {path}: {reason}; expected a greyscale PNG file",
            source=source,
            path=path,
            reason=reason,
        ) from None
    if values.ndim > 2:  # noqa: PLR2004 - rows and columns, or also colours
        opaque, colours = values[..., 3:], values[..., :3]
        if (colours != colours[..., :1]).any() or (opaque != 1).any():
            raise UserError(
                "{source}: image {path}: the image must be greyscale, but is in colour",
                source=source,
                path=path,
            )
        values = values[..., 0]
    if values.size > MOST_PIXELS:
        rows, columns = values.shape
        raise UserError(
            "{source}: image {path}: {columns} x {rows} pixels are too many; reduce the image to "
            "at most {most_pixels:,} pixels",
            source=source,
            path=path,
            columns=columns,
            rows=rows,
            most_pixels=MOST_PIXELS,
        )
    return tuple(bytes(row) for row in np.round(values * WHITE).astype(np.uint8))
