"""Page text in the reader's language."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

from slipscale.experiments.languages.texts import flatten
from slipscale.faults.message import Message

if TYPE_CHECKING:
    from slipscale.experiments.protocol_parts.base import Options, Protocol
    from slipscale.experiments.study.model import Study

#: Folder with one file per language; adding a language is adding a file.
CATALOGUES = files("slipscale.experiments.lab.console").joinpath("texts")
ENGLISH = "en"


@dataclass(frozen=True, slots=True)
class Catalogue:
    """The texts of one language.

    Parameters
    ----------
    texts : Mapping
        Page texts by key. English replaces missing texts.
    messages : Mapping
        Translations of `Message` templates and of Slipscale's other texts, by their English text.
    """

    texts: Mapping[str, str]
    messages: Mapping[str, str]


@cache
def languages() -> tuple[str, ...]:
    """Return the codes of all languages, English first."""
    found = sorted(each.name.removesuffix(".toml") for each in CATALOGUES.iterdir())
    return (ENGLISH, *(code for code in found if code != ENGLISH))


@cache
def catalogue(language: str) -> Catalogue:
    """Read the catalogue of a language."""
    source = CATALOGUES.joinpath(f"{language}.toml")
    content = tomllib.loads(source.read_text(encoding="utf-8"))
    messages = content.pop("messages", {})
    english = {} if language == ENGLISH else catalogue(ENGLISH).texts
    texts = {key: _typeset(text) for key, text in flatten(content).items()}
    return Catalogue({**english, **texts}, {key: _typeset(text) for key, text in messages.items()})


def _typeset(text: str) -> str:
    r"""Replace spaces around French punctuation with non-breaking spaces.

    >>> _typeset("prêt ? « oui »")
    'prêt\xa0? «\xa0oui\xa0»'
    """
    return re.sub(r" (?=[:;?!%»])|(?<=«) ", "\N{NO-BREAK SPACE}", text)


@dataclass(frozen=True, slots=True)
class Words:
    """Page text in one language; call it with a key and values for the {placeholders}."""

    language: str

    def __call__(self, key: str, **blanks: object) -> str:
        """Return the text for a key, with its placeholders filled in."""
        return catalogue(self.language).texts[key].format(**blanks)

    def say(self, text: str) -> str:
        r"""Return a message, or a text of Slipscale, in this language; other text is unchanged.

        >>> copied = Message("copied {count} runs to {folder}", count=2, folder="disk")
        >>> Words("fr").say(copied), Words("fr").say("excluded"), Words("fr").say("torn glove")
        ('2 passages copiés vers disk', 'exclu', 'torn glove')
        """
        messages = catalogue(self.language).messages
        if not isinstance(text, Message) or not text.values:
            return messages.get(text, text)
        # A value in quotation marks is a name, such as a key of a file, which has no translation.
        values = {
            k: self.say(v) if isinstance(v, str) and f"'{{{k}}}'" not in text.template else v
            for k, v in text.values.items()
        }
        return messages.get(text.template, text.template).format(**values)

    def decimal(self, shown: str) -> str:
        """Format a number, with or without a unit, using this language's decimal mark."""
        mark = catalogue(self.language).texts["page.decimal"]
        return re.sub(r"(?<=\d)\.(?=\d)", mark, shown) if shown[:1].isdigit() else shown

    def task(self, options: Options, protocol: Protocol, study: Study) -> str:
        """Return a task's title; titles of protocols from other packages are not translated."""
        title = self.known(f"task_title.{options.protocol}", protocol.titled(study.quantity))
        words = study.words_of(self.language)
        return title.replace("{noun}", words.noun if words else study.quantity.judged)

    def known(self, key: str, otherwise: str) -> str:
        """Return the text for a key, or ``otherwise`` if there is none."""
        return catalogue(self.language).texts.get(key, otherwise)


def preferred(accepted: str, chosen: str) -> str:
    """Return the reader's language: the language chosen on a page, otherwise the browser's.

    >>> preferred("de, fr;q=0.8, en;q=0.5", ""), preferred("fr", "en"), preferred("", "xx")
    ('fr', 'en', 'en')
    """
    if chosen in languages():
        return chosen
    wanted = [part.split(";")[0].strip()[:2].lower() for part in accepted.split(",")]
    return next((code for code in wanted if code in languages()), ENGLISH)
