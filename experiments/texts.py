"""What a participant reads: shipped in English and French, replaceable in the study file."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from faults import UserError

Texts = Mapping[str, str]


def languages() -> list[str]:
    """Return the codes of the shipped languages.

    >>> languages()
    ['en', 'fr']
    """
    names = (entry.name for entry in files("experiments").joinpath("languages").iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def flatten(table: Mapping[str, Any], prefix: str = "") -> dict[str, str]:
    """Return a nested table as one level, keys joined by dots.

    >>> flatten({"window": {"yes": "yes"}})
    {'window.yes': 'yes'}
    """
    flat: dict[str, str] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            flat |= flatten(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = str(value)
    return flat


def load_texts(language: str, replacements: Mapping[str, Any] | None = None) -> Texts:
    """Return all texts of a language, with a study's own in place of the shipped ones.

    Parameters
    ----------
    language : str
        A shipped language's code.
    replacements : Mapping, optional
        Texts that replace the shipped ones, nested or with dotted keys.

    Raises
    ------
    UserError
        No such language, or a replacement for a text that does not exist.
    """
    if language not in languages():
        raise UserError(f"language '{language}': expected one of {', '.join(languages())}")
    source = files("experiments").joinpath("languages", f"{language}.toml")
    shipped = flatten(tomllib.loads(source.read_text(encoding="utf-8")))
    own = flatten(replacements or {})
    unknown = sorted(set(own) - set(shipped))
    if unknown:
        raise UserError(
            f"texts.{language}: no text is called {', '.join(unknown)}; "
            f"there are: {', '.join(sorted(shipped))}"
        )
    return shipped | own
