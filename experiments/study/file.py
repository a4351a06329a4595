"""Find, read and validate study files; all errors are reported at once, with line numbers.

`slipscale.experiments.study.model.Study` defines the allowed keys.
"""

from __future__ import annotations

import hashlib
import logging
from functools import lru_cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from slipscale.experiments.protocol_parts.registry import load_protocol, protocol_names
from slipscale.experiments.study.images import with_images
from slipscale.experiments.study.model import Study
from slipscale.experiments.study.own_language import check_words, with_own_language
from slipscale.experiments.study.tables import PlateSettings, StimulusTable, Texture
from slipscale.faults import UserError
from slipscale.faults.folders import visible
from slipscale.faults.suggestions import did_you_mean
from slipscale.faults.toml_file import parse_toml
from slipscale.stimuli.file_names import FileNames
from slipscale.stimuli.level_names import is_level
from slipscale.stimuli.parameters import field_of
from slipscale.stimuli.quantity_table import stated_quantity
from slipscale.stimuli.textures import PARAMETERS

# Tables whose levels are always in the plate's quantity, even if the study varies another
# parameter.
OF_PLATE = ("plate", "textures", "stimulus")
LOG = logging.getLogger(__name__)


@lru_cache(maxsize=16)
def parse_study(text: str, source: str) -> Study:
    """Parse the TOML text of a study file.

    Parameters
    ----------
    text : str
        The study file's text.
    source : str
        The file's name for error messages.

    Raises
    ------
    UserError
        If the text is not valid. The message lists every error with its line or key, and the
        expected value.
    """
    return parse_toml(text, source, Study, names=file_names)


def file_names(table: dict[str, Any]) -> FileNames:
    """Return the names of keys in a study file, which depend on the study's quantity."""
    tasks = table.get("tasks")
    named = {str(t.get("protocol")) for t in tasks if isinstance(t, dict)} if tasks else set()
    known = named & set(protocol_names())
    models: tuple[type[BaseModel], ...] = (
        Study,
        PlateSettings,
        Texture,
        StimulusTable,
        *(load_protocol(name).options for name in known),
    )
    fields = {field for model in models for field in model.model_fields}
    levels = frozenset(field for field in fields if is_level(field))
    plate, vary = stated_quantity(table), table.get("vary")
    second = table.get("second_plate")
    other = {"second_plate": stated_quantity(second)} if isinstance(second, dict) else {}
    varied = field_of(vary, plate, PARAMETERS) if isinstance(vary, str) else None
    return FileNames(
        PARAMETERS[varied].parameter.quantity(plate) if varied else plate,
        levels,
        frozenset({"tasks", *OF_PLATE, *other}),
        dict.fromkeys(OF_PLATE, plate) | other,
    )


def shipped_studies() -> list[str]:
    """Return the names of the studies shipped with Slipscale.

    >>> "biet2007" in shipped_studies()
    True
    """
    return sorted(_shipped_files())


def _shipped_files() -> dict[str, Traversable]:
    folder = files("slipscale.experiments").joinpath("studies")
    entries = (*folder.iterdir(), *folder.joinpath("published").iterdir())
    return {entry.name.removesuffix(".toml"): entry for entry in entries if entry.is_file()}


def study_text(name: str) -> str:
    """Return the text of a shipped study or of a study file.

    Raises
    ------
    UserError
        If there is no such study or file, or if the file cannot be read as text.
    """
    if shipped := _shipped_files().get(name):
        return shipped.read_text(encoding="utf-8")
    try:
        return Path(name).read_text(encoding="utf-8-sig")  # Windows editors write a byte order mark
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        files_here = [str(path) for path in visible(Path(), "*.toml")]
        meant = did_you_mean(name, [*shipped_studies(), *files_here])
        raise UserError(
            "study '{name}': {reason}{meant}; expected a TOML file or one of the shipped "
            "studies: {shipped_studies}; for a new file: slipscale study new FILE",
            name=name,
            reason=reason,
            meant=meant,
            shipped_studies=", ".join(shipped_studies()),
        ) from None


def parse_whole(text: str, name: str) -> tuple[Study, str]:
    """Parse the text of a study; also return the text with language files and images inserted.

    Raises
    ------
    UserError
        If the text is not valid (see `parse_study`), if the study's own language lacks a text, or
        if a text does not fit on the screen.
    """
    whole = with_images(with_own_language(text, name), name)
    study = parse_study(whole, name)
    check_words(study, name)
    return study, whole


def read_study(name: str) -> tuple[Study, str]:
    """Return a study and its complete text, which includes the content of its language files."""
    text = study_text(name)
    LOG.info("read study %s: %d characters", name, len(text))
    try:
        return parse_whole(text, name)
    except UserError as error:
        end = "\n" if "\n" in str(error) else "; "
        raise UserError(
            "{error}{end}correct it, then: slipscale study validate {name}",
            error=error,
            end=end,
            name=name,
        ) from None


def study_hash(text: str) -> str:
    """Return the SHA-256 of a study file's text, in hexadecimal."""
    return hashlib.sha256(text.encode()).hexdigest()
