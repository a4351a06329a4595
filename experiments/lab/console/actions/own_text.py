"""Change single texts of a study file, in each language, by the key of the text."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import Any

from slipscale.experiments.lab.console.actions.study_changes import Change, changed
from slipscale.experiments.languages.texts import shipped_texts


def with_texts(text: str, key: str, texts: Mapping[str, str]) -> str:
    """Return the text of a study file in which a text is replaced.

    Parameters
    ----------
    text : str
        Text of the study file.
    key : str
        Key of the text, such as "session.welcome".
    texts : Mapping
        New text by language. An empty text, or that of Slipscale, removes the study's own text.
    """
    for language, new in texts.items():
        plain = new.replace("\r\n", "\n").strip()
        own = "" if plain == shipped_texts(language).get(key, "").strip() else plain
        place = _place(text, language, key)
        if own or _value_at(text, place) is not None:
            text = changed(text, Change(what="set", place=place, value=own))
    return text


def _place(text: str, language: str, key: str) -> tuple[str, ...]:
    """Return where a study file has a text, or should have it; a key may be written with dots."""
    dotted = ("texts", language, key)
    return dotted if _value_at(text, dotted) is not None else ("texts", language, *key.split("."))


def _value_at(text: str, place: tuple[str, ...]) -> Any:
    value: Any = tomllib.loads(text)
    for part in place:
        value = value.get(part) if isinstance(value, dict) else None
    return value
