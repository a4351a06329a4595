"""Page text in the reader's language."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING

from slipscale.experiments.languages.texts import flatten

if TYPE_CHECKING:
    from slipscale.experiments.protocol_parts.base import Options, Protocol
    from slipscale.experiments.study.model import Study

PACKAGE = "slipscale.experiments.lab.console"
LANGUAGES = ("en", "fr")


@cache
def page_texts(language: str) -> Mapping[str, str]:
    """Return the page text in a language, by key."""
    source = files(PACKAGE).joinpath("texts", f"{language}.toml")
    texts = flatten(tomllib.loads(source.read_text(encoding="utf-8")))
    return {key: _typeset(text) for key, text in texts.items()}


@cache
def sentences(language: str) -> dict[str, str]:
    """Return Slipscale's English sentences and their translations, the most specific first.

    Other modules generate notices, replies, errors and descriptions in English. Such sentences are
    translated when a page is rendered.
    """
    known: dict[str, str] = {}
    for source in files(PACKAGE).joinpath("texts").iterdir():
        if source.name.endswith(f".{language}.toml"):
            known |= tomllib.loads(source.read_text(encoding="utf-8"))
    # Sentences that begin with a placeholder are tried last, because they match many others:
    # "{} is missing" also matches "line 4: key is missing".
    order = sorted(known, key=lambda each: (each.startswith("{}"), -len(each)))
    return {each: _typeset(known[each]) for each in order}


def _typeset(text: str) -> str:
    r"""Replace spaces around French punctuation with non-breaking spaces.

    >>> _typeset("prêt ? « oui »")
    'prêt\xa0? «\xa0oui\xa0»'
    """
    return re.sub(r" (?=[:;?!%»])|(?<=«) ", "\N{NO-BREAK SPACE}", text)


@cache
def _patterns(language: str) -> tuple[tuple[re.Pattern[str], str], ...]:
    """Return (pattern, translation) pairs for the sentences with placeholders."""
    return tuple(
        (re.compile(re.escape(each).replace(r"\{\}", "(.*?)")), text)
        for each, text in sentences(language).items()
        if "{}" in each
    )


# Separators, in English and in French, between sentences that are translated separately.
LINES = {"\n  ": "\n  ", "\n": "\n"}
JOINTS = {"; ": _typeset(" ; "), ". ": ". ", ": ": _typeset(" : ")}


@lru_cache(maxsize=2000)
def _translated(sentence: str, language: str) -> str:
    if text := sentences(language).get(sentence):
        return text
    if "\n" in sentence:
        return _each_translated(sentence, LINES, language)
    for pattern, text in _patterns(language):
        if found := pattern.fullmatch(sentence):
            return text.format(*(_translated(each, language) for each in found.groups()))
    return _each_translated(sentence, JOINTS, language)


def _each_translated(sentence: str, joints: Mapping[str, str], language: str) -> str:
    """Split a text at the first separator that yields a translatable part; translate all parts."""
    for joint, typeset in joints.items():
        parts = sentence.split(joint) if joint in sentence else []
        translated = [_translated(each, language) for each in parts]
        if translated != parts:  # texts from people keep their punctuation
            return typeset.join(translated)
    return sentence


@dataclass(frozen=True, slots=True)
class Words:
    """Page text in one language; call it with a key and values for the {placeholders}."""

    language: str

    def __call__(self, key: str, **blanks: object) -> str:
        """Return the text for a key, with its placeholders filled in."""
        return page_texts(self.language)[key].format(**blanks)

    def say(self, sentence: str) -> str:
        r"""Translate one of Slipscale's sentences into this language; return other text unchanged.

        Sentences that are joined by punctuation or line feeds are translated separately.

        >>> Words("fr").say("copied 2 runs to disk; excluded"), Words("en").say("saved: a.toml")
        ('2 passages copiés vers disk\xa0; exclu', 'saved: a.toml')
        """
        return _translated(sentence, self.language)

    def decimal(self, shown: str) -> str:
        """Format a number, with or without a unit, using this language's decimal mark."""
        mark = page_texts(self.language)["page.decimal"]
        return re.sub(r"(?<=\d)\.(?=\d)", mark, shown) if shown[:1].isdigit() else shown

    def exact(self, words: str) -> str:
        """Translate a whole sentence into this language; return unknown text unchanged."""
        return sentences(self.language).get(words, words)

    def task(self, options: Options, protocol: Protocol, study: Study) -> str:
        """Return a task's title; titles of protocols from other packages are not translated."""
        title = self.known(f"task_title.{options.protocol}", protocol.titled(study.quantity))
        words = study.words_of(self.language)
        return title.replace("{noun}", words.noun if words else study.quantity.judged)

    def known(self, key: str, otherwise: str) -> str:
        """Return the text for a key, or ``otherwise`` if there is none."""
        return page_texts(self.language).get(key, otherwise)


def preferred(accepted: str, chosen: str) -> str:
    """Return the reader's language: the language chosen on a page, otherwise the browser's.

    >>> preferred("de, fr;q=0.8, en;q=0.5", ""), preferred("fr", "en"), preferred("", "xx")
    ('fr', 'en', 'en')
    """
    if chosen in LANGUAGES:
        return chosen
    wanted = [part.split(";")[0].strip()[:2].lower() for part in accepted.split(",")]
    return next((code for code in wanted if code in LANGUAGES), LANGUAGES[0])
