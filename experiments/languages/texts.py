"""Load and check the texts that participants read.

Slipscale includes these texts in English and French. A study file can replace individual texts, or
add a language with a text for every key. If a later version of Slipscale adds keys and resumes a
run in such a language, it shows the English text for the new keys.
"""

from __future__ import annotations

import hashlib
import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from string import Formatter

from slipscale.experiments.languages.screen_room import not_drawn, too_long
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.stimuli.attributes import ATTRIBUTES, SLIPPERINESS, AttributeWords

Texts = Mapping[str, str]
ENGLISH = "en"
# Not translated, because the table [keys] of the study file sets these texts.
SET_BY_KEYS = ("window.go_on_key", "window.again_key", "window.touch")
# Code of a language (BCP 47), such as de, pt-BR or zh-Hant.
CODE = re.compile(r"[a-z]{2,3}(-[A-Za-z0-9]{2,8})*")
FEWEST_ANSWERS, NUMBER_KEYS = 2, 9  # number of answers, each with a number key
MOST_OPTIONS = 99  # a scrolling list has numbers of at most two digits


def languages() -> list[str]:
    """Return the codes of the shipped languages.

    To add a language, add a TOML file with all keys of ``en.toml`` next to this module.

    >>> "en" in languages()
    True
    """
    return list(_languages())


@cache
def _languages() -> tuple[str, ...]:
    # Cached, because every run of a pilot needs it, and the files do not change.
    names = (entry.name for entry in files("slipscale.experiments").joinpath("languages").iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml")))


def flatten(table: Mapping[str, object], prefix: str = "") -> dict[str, str]:
    """Flatten a nested table, joining keys with dots.

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


def load_texts(
    language: str,
    replacements: Mapping[str, object] | None = None,
    brought: Texts | None = None,
    words: AttributeWords | None = None,
) -> Texts:
    """Return all texts in a language, after replacing shipped texts with the study's texts.

    Parameters
    ----------
    language : str
        Code of the language, such as ``en``.
    replacements : Mapping, optional
        Texts that replace shipped texts, with nested or dotted keys.
    brought : Mapping, optional
        Texts added by the protocols of the run.
    words : AttributeWords, optional
        Wording for the judged attribute (default: slipperiness).

    Raises
    ------
    UserError
        If the language does not exist, or a replacement text is invalid.
    """
    if language not in _languages() and not replacements:
        raise UserError(
            "unknown language '{language}': expected one of {languages}",
            language=language,
            languages=", ".join(languages()),
        )
    if not replacements and not brought:
        return shipped_texts(language, words)
    faults = text_faults(language, replacements or {}, brought)
    if faults:
        sentences = (f"texts.{language}.{key}: {sentence}" for key, sentence in faults)
        raise UserError("; ".join(sentences))
    known = words or ATTRIBUTES[SLIPPERINESS].get(language, ATTRIBUTES[SLIPPERINESS][ENGLISH])
    own = {key: known.fill(text) for key, text in flatten(replacements or {}).items()}
    return _Complete(language, shipped_texts(language, words) | dict(brought or {}) | own)


class _Complete(dict[str, str]):
    """Texts of a language; a text that a package's protocol lacks is named in a sentence."""

    def __init__(self, language: str, texts: Texts) -> None:
        super().__init__(texts)
        self._language = language

    def __missing__(self, key: str) -> str:
        raise UserError("text '{key}' is missing in '{language}'", key=key, language=self._language)


@cache
def shipped_texts(language: str, words: AttributeWords | None = None) -> dict[str, str]:
    """Return the texts of a shipped language. Do not modify this dictionary; all callers share it.

    If the language is not shipped, return the English texts, which the study's own texts replace.
    Without ``words``, the texts are about slipperiness.
    """
    known = language if language in _languages() else ENGLISH
    source = files("slipscale.experiments").joinpath("languages", f"{known}.toml")
    judged = words or ATTRIBUTES[SLIPPERINESS][known]
    return flatten(tomllib.loads(judged.fill(source.read_text(encoding="utf-8"))))


def text_faults(
    language: str, replacements: Mapping[str, object], brought: Texts | None = None
) -> list[tuple[str, str]]:
    """Return the key and an error message for each invalid text in a study."""
    shipped, own = shipped_texts(language) | dict(brought or {}), flatten(replacements)
    known = {key: text for key, text in own.items() if key in shipped}
    return [
        *((key, _unknown(key, shipped)) for key in own if key not in shipped),
        *_blank_faults(known, shipped),
        *_key_faults(shipped | known),
    ]


def unshown(own: Texts) -> Iterator[tuple[str, str]]:
    """Yield the key and an error message for each text that does not fit or cannot be drawn."""
    for key, text in own.items():
        # The length of texts from other packages is not checked.
        long = too_long(key, text) if key in shipped_texts(ENGLISH) else ""
        if sentence := not_drawn(text) or long:
            yield key, sentence


def missing(own: Texts, brought: Texts) -> list[str]:
    """Return the keys that have no text in a language added by a study, in the English order.

    Parameters
    ----------
    own : Mapping
        Texts of the language, keyed by dotted key; empty texts count as missing.
    brought : Mapping
        Texts added by the study's protocols, in English or another language.
    """
    return [key for key in to_translate(brought) if not own.get(key, "").strip()]


def to_translate(brought: Texts) -> dict[str, str]:
    """Return the English texts that must be translated for a language added by a study."""
    english = {**shipped_texts(ENGLISH), **brought}
    return {key: text for key, text in english.items() if key not in SET_BY_KEYS}


def unlike(own: Texts, brought: Texts) -> Iterator[tuple[str, str]]:
    """Yield the key and an error message for each translation that lacks placeholders or answers.

    Only translations are checked: a text that replaces a shipped text may omit placeholders.
    """
    for key, english in to_translate(brought).items():
        if not (text := own.get(key, "")):
            continue
        if lost := (blanks(english) or set()) - (blanks(text) or set()):
            yield (
                key,
                Message(
                    "{lost} is missing", lost=", ".join(f"{{{name}}}" for name in sorted(lost))
                ),
            )
        if " | " in english and len(answers(text)) != len(answers(english)):
            yield (
                key,
                Message("expected {count} answers separated by |", count=len(answers(english))),
            )


def texts_hash(texts: Texts) -> str:
    """Return the SHA-256 hash of all texts, in hexadecimal."""
    return hashlib.sha256(json.dumps(dict(sorted(texts.items()))).encode()).hexdigest()


def _unknown(key: str, shipped: Texts) -> str:
    near = get_close_matches(key, shipped, n=3) or sorted(shipped)
    return Message("unknown text key; expected a key such as {near}", near=", ".join(near))


def blanks(text: str) -> set[str] | None:
    """Return the placeholder names in a text, or None if its braces are unbalanced.

    >>> blanks("{done} of {total}") == {"done", "total"}, blanks("50 % {")
    (True, None)
    """
    try:
        parts = list(Formatter().parse(text))
    except ValueError:
        return None
    return {f"{name}{f':{form}' if form else ''}" for _, name, form, _ in parts if name is not None}


def answers(text: str) -> list[str]:
    """Split a text at each ``|``, and return the list of answers.

    >>> answers("not sure | sure")
    ['not sure', 'sure']
    """
    return [word.strip() for word in text.split("|")]


def _blank_faults(own: Texts, shipped: Texts) -> Iterator[tuple[str, str]]:
    """Yield the key and an error message for each text with unknown or incomplete placeholders."""
    for key, text in own.items():
        found, known = blanks(text), blanks(shipped[key]) or set()
        if found is None or not found <= known:
            filled = ", ".join(f"{{{name}}}" for name in sorted(known)) or "none"
            yield (
                key,
                (
                    Message(
                        "contains unknown placeholders or unbalanced braces; available "
                        "placeholders: {filled}",
                        filled=filled,
                    )
                ),
            )


def _key_faults(texts: Texts) -> Iterator[tuple[str, str]]:
    """Check yes/no letters, decimal signs and answer lists; yield keys and error messages."""
    yes, no = texts["window.yes_key"].casefold(), texts["window.no_key"].casefold()
    if len(yes) != 1 or len(no) != 1 or yes == no or not (yes + no).isalpha():
        yield (
            "window",
            Message(
                "yes_key '{yes}' and no_key '{no}': expected two different letters", yes=yes, no=no
            ),
        )
    if texts["window.decimal"] not in (".", ","):
        yield "window.decimal", "expected a point or a comma"
    key = "descending_difference.confidence_options"
    words = answers(texts[key])
    fits = FEWEST_ANSWERS <= len(words) <= NUMBER_KEYS
    if not fits or "" in words or len(set(words)) < len(words):
        yield (
            key,
            (
                Message(
                    "expected {fewest_answers} to {number_keys} different answers separated by |",
                    fewest_answers=FEWEST_ANSWERS,
                    number_keys=NUMBER_KEYS,
                )
            ),
        )
