"""What the pages say, in the language of whoever reads them."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

from slipscale.experiments.languages.texts import flatten

if TYPE_CHECKING:
    from collections.abc import Mapping

LANGUAGES = ("en", "fr")


@cache
def page_texts(language: str) -> Mapping[str, str]:
    """Return the texts of a language, by their keys."""
    source = files("slipscale.experiments.lab.console").joinpath("texts", f"{language}.toml")
    return flatten(tomllib.loads(source.read_text(encoding="utf-8")))


@dataclass(frozen=True, slots=True)
class Words:
    """The texts of a language: called with a key, and what fills the text's {braces}."""

    language: str

    def __call__(self, key: str, **blanks: object) -> str:
        """Return a text."""
        return page_texts(self.language)[key].format(**blanks)

    def known(self, key: str, otherwise: str) -> str:
        """Return a text, or another where there is no such text."""
        return page_texts(self.language).get(key, otherwise)


def preferred(accepted: str, chosen: str) -> str:
    """Return the language of a reader: the one chosen on a page, else the browser's.

    >>> preferred("de, fr;q=0.8, en;q=0.5", ""), preferred("fr", "en"), preferred("", "xx")
    ('fr', 'en', 'en')
    """
    if chosen in LANGUAGES:
        return chosen
    wanted = [part.split(";")[0].strip()[:2].lower() for part in accepted.split(",")]
    return next((code for code in wanted if code in LANGUAGES), LANGUAGES[0])
