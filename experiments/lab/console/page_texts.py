"""The texts of the pages, in the reader's language."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING

from slipscale.experiments.languages.texts import flatten

if TYPE_CHECKING:
    from collections.abc import Mapping

    from slipscale.experiments.protocols.base import Options, Protocol

PACKAGE = "slipscale.experiments.lab.console"
LANGUAGES = ("en", "fr")


@cache
def page_texts(language: str) -> Mapping[str, str]:
    """Return the texts of a language by key."""
    source = files(PACKAGE).joinpath("texts", f"{language}.toml")
    return flatten(tomllib.loads(source.read_text(encoding="utf-8")))


@cache
def sentences(language: str) -> dict[str, str]:
    """Return Slipscale's sentences with their translations, longest first.

    Notices, replies, remedies and descriptions are generated elsewhere, in English, and translated
    when a page is rendered.
    """
    known: dict[str, str] = {}
    for name in ("sentences", "study"):
        source = files(PACKAGE).joinpath("texts", f"{name}.{language}.toml")
        if source.is_file():
            known |= tomllib.loads(source.read_text(encoding="utf-8"))
    return {each: known[each] for each in sorted(known, key=len, reverse=True)}


@cache
def _patterns(language: str) -> tuple[tuple[re.Pattern[str], str], ...]:
    """Return patterns for the sentences with placeholders, with their translations."""
    return tuple(
        (re.compile(re.escape(each).replace(r"\{\}", "(.*?)"), re.DOTALL), text)
        for each, text in sentences(language).items()
        if "{}" in each
    )


@lru_cache(maxsize=2000)
def _translated(sentence: str, language: str) -> str:
    if text := sentences(language).get(sentence):
        return text
    for pattern, text in _patterns(language):
        if found := pattern.fullmatch(sentence):
            return text.format(*(_translated(each, language) for each in found.groups()))
    first, several, rest = sentence.partition("; ")
    if not several or not sentences(language):
        return sentence
    return f"{_translated(first, language)} ; {_translated(rest, language)}"


@dataclass(frozen=True, slots=True)
class Words:
    """The texts of one language. Call with a key and the values for the text's {placeholders}."""

    language: str

    def __call__(self, key: str, **blanks: object) -> str:
        """Return a text with its placeholders filled in."""
        return page_texts(self.language)[key].format(**blanks)

    def say(self, sentence: str) -> str:
        """Return one of Slipscale's sentences in this language; unknown sentences are unchanged.

        If sentences are joined by semicolons, each is translated.

        >>> Words("fr").say("copied 2 runs to disk"), Words("en").say("saved: a.toml")
        ('2 passages copiés vers disk', 'saved: a.toml')
        """
        return _translated(sentence, self.language)

    def task(self, options: Options, protocol: Protocol) -> str:
        """Return a task's title, which is the same in every language for external protocols."""
        return self.known(f"task_title.{options.protocol}", protocol.titled())

    def known(self, key: str, otherwise: str) -> str:
        """Return a text, or ``otherwise`` if the key has no text."""
        return page_texts(self.language).get(key, otherwise)


def preferred(accepted: str, chosen: str) -> str:
    """Return the reader's language: the one chosen on a page, otherwise the browser's.

    >>> preferred("de, fr;q=0.8, en;q=0.5", ""), preferred("fr", "en"), preferred("", "xx")
    ('fr', 'en', 'en')
    """
    if chosen in LANGUAGES:
        return chosen
    wanted = [part.split(";")[0].strip()[:2].lower() for part in accepted.split(",")]
    return next((code for code in wanted if code in LANGUAGES), LANGUAGES[0])
