"""What a participant reads: shipped in English and French, replaceable in the study file.

A study may bring a language of its own: then it has a text for every key. Its English texts are
what a newer Slipscale shows for a key that came later, where it goes on with a run of before.
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
from typing import Any

from slipscale.experiments.languages.screen_room import not_drawn, too_long
from slipscale.faults import UserError

Texts = Mapping[str, str]
ENGLISH = "en"
# No words: what the study's [keys] say.
SET_BY_KEYS = ("window.go_on_key", "window.again_key", "window.touch")
# A language's code, as in HTML and elsewhere (BCP 47): de, pt-BR, zh-Hant.
CODE = re.compile(r"[a-z]{2,3}(-[A-Za-z0-9]{2,8})*")
FEWEST_ANSWERS, NUMBER_KEYS = 2, 9  # of a choice: each answer is a number key
MOST_OPTIONS = 99  # of a list that scrolls: a number of two digits


def languages() -> list[str]:
    """Return the codes of the shipped languages: one TOML file each, beside this module.

    A language is added by a file with every key of ``en.toml``; a test compares the keys.

    >>> "en" in languages()
    True
    """
    return list(_languages())


@cache
def _languages() -> tuple[str, ...]:
    # Looked up at every run of a pilot; no language comes while a program runs.
    names = (entry.name for entry in files("slipscale.experiments").joinpath("languages").iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml")))


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


def load_texts(
    language: str,
    replacements: Mapping[str, Any] | None = None,
    brought: Texts | None = None,
) -> Texts:
    """Return all texts of a language, with a study's own in place of the shipped ones.

    Parameters
    ----------
    language : str
        A shipped language's code.
    replacements : Mapping, optional
        Texts that replace the shipped ones, nested or with dotted keys.
    brought : Mapping, optional
        Texts that the run's protocols bring, beside the shipped ones.

    Raises
    ------
    UserError
        No such language, or a replacement that would fail in the middle of a session.
    """
    if language not in _languages() and not replacements:
        raise UserError(f"language '{language}': expected one of {', '.join(languages())}")
    if not replacements and not brought:
        return shipped_texts(language)
    faults = text_faults(language, replacements or {}, brought)
    if faults:
        told = (f"texts.{language}.{key}: {sentence}" for key, sentence in faults)
        raise UserError("; ".join(told))
    return shipped_texts(language) | dict(brought or {}) | flatten(replacements or {})


@cache
def shipped_texts(language: str) -> dict[str, str]:
    """Return the texts of a shipped language as they come: for reading, everybody has the same.

    Of any other language they are the English ones, which a study's own take the place of.
    """
    known = language if language in _languages() else ENGLISH
    source = files("slipscale.experiments").joinpath("languages", f"{known}.toml")
    return flatten(tomllib.loads(source.read_text(encoding="utf-8")))


def text_faults(
    language: str, replacements: Mapping[str, Any], brought: Texts | None = None
) -> list[tuple[str, str]]:
    """Return each text of a study's own that would fail in a session: its key, and a sentence."""
    shipped, own = shipped_texts(language) | dict(brought or {}), flatten(replacements)
    known = {key: text for key, text in own.items() if key in shipped}
    return [
        *((key, _unknown(key, shipped)) for key in own if key not in shipped),
        *_blank_faults(known, shipped),
        *_key_faults(shipped | known),
    ]


def unshown(own: Texts) -> Iterator[tuple[str, str]]:
    """Yield key and sentence for each text that its screen cannot show."""
    for key, text in own.items():
        # How long a protocol from elsewhere makes its texts is its own affair.
        long = too_long(key, text) if key in shipped_texts(ENGLISH) else ""
        if sentence := not_drawn(text) or long:
            yield key, sentence


def missing(own: Texts, brought: Texts) -> list[str]:
    """Return the keys that a language of a study's own has no text for, in the English order.

    Parameters
    ----------
    own : Mapping
        Its texts, by dotted key; an empty one is none.
    brought : Mapping
        What the study's protocols bring, in English or another language.
    """
    return [key for key in to_translate(brought) if not own.get(key, "").strip()]


def to_translate(brought: Texts) -> dict[str, str]:
    """Return the English texts that a language of a study's own has others for."""
    english = {**shipped_texts(ENGLISH), **brought}
    return {key: text for key, text in english.items() if key not in SET_BY_KEYS}


def unlike(own: Texts, brought: Texts) -> Iterator[tuple[str, str]]:
    """Yield key and sentence for each text that says less than the English one does.

    A replacement within a language may leave out a number; a translation loses it by mistake.
    """
    for key, english in to_translate(brought).items():
        if not (text := own.get(key, "")):
            continue
        if lost := (blanks(english) or set()) - (blanks(text) or set()):
            yield key, f"{', '.join(f'{{{name}}}' for name in sorted(lost))} is missing in it"
        if " | " in english and len(answers(text)) != len(answers(english)):
            yield key, f"expected {len(answers(english))} answers with | between"


def texts_hash(texts: Texts) -> str:
    """Return the SHA-256 of all texts that a participant could read, in hexadecimal."""
    return hashlib.sha256(json.dumps(dict(sorted(texts.items()))).encode()).hexdigest()


def _unknown(key: str, shipped: Texts) -> str:
    """Return the sentence about a text that there is not."""
    near = get_close_matches(key, shipped, n=3) or sorted(shipped)
    return f"there is no such text; there are: {', '.join(near)}"


def blanks(text: str) -> set[str] | None:
    """Return the names in a text's {braces}; None where the braces do not fit together.

    >>> blanks("{done} of {total}") == {"done", "total"}, blanks("50 % {")
    (True, None)
    """
    try:
        parts = list(Formatter().parse(text))
    except ValueError:
        return None
    return {f"{name}{f':{form}' if form else ''}" for _, name, form, _ in parts if name is not None}


def answers(text: str) -> list[str]:
    """Return the answers that a text lists.

    >>> answers("not sure | sure")
    ['not sure', 'sure']
    """
    return [word.strip() for word in text.split("|")]


def _blank_faults(own: Texts, shipped: Texts) -> Iterator[tuple[str, str]]:
    """Yield key and sentence for each text with {braces} that nothing will fill in."""
    for key, text in own.items():
        found, known = blanks(text), blanks(shipped[key]) or set()
        if found is None or not found <= known:
            filled = ", ".join(f"{{{name}}}" for name in sorted(known)) or "none"
            yield key, f"its braces cannot be filled in; those there are: {filled}"


def _key_faults(texts: Texts) -> Iterator[tuple[str, str]]:
    """Yield key and sentence where an answer that is given by a key has no key of its own."""
    yes, no = texts["window.yes_key"].casefold(), texts["window.no_key"].casefold()
    if len(yes) != 1 or len(no) != 1 or yes == no or not (yes + no).isalpha():
        yield "window", f"yes_key '{yes}' and no_key '{no}': expected two different letters"
    if texts["window.decimal"] not in (".", ","):
        yield "window.decimal", "expected a point or a comma"
    key = "descending_difference.confidence_options"
    words = answers(texts[key])
    fits = FEWEST_ANSWERS <= len(words) <= NUMBER_KEYS
    if not fits or "" in words or len(set(words)) < len(words):
        yield key, f"expected {FEWEST_ANSWERS} to {NUMBER_KEYS} different answers, with | between"
