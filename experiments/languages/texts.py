"""The texts that a participant reads: shipped in English and French, replaceable in the study file.

A study may add a language, with a text for every key. If a later version of Slipscale resumes a run
of such a study, it shows the English text for any new key.
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
from slipscale.stimuli.attributes import ATTRIBUTES, SLIPPERINESS, AttributeWords

Texts = Mapping[str, str]
ENGLISH = "en"
# Not translated: set by the study's [keys].
SET_BY_KEYS = ("window.go_on_key", "window.again_key", "window.touch")
# A language's code, as in HTML and elsewhere (BCP 47): de, pt-BR, zh-Hant.
CODE = re.compile(r"[a-z]{2,3}(-[A-Za-z0-9]{2,8})*")
FEWEST_ANSWERS, NUMBER_KEYS = 2, 9  # answers of a choice: one number key per answer
MOST_OPTIONS = 99  # options of a scrolling list: two-digit numbers


def languages() -> list[str]:
    """Return the codes of the shipped languages, one TOML file each, next to this module.

    To add a language, add a file with every key of ``en.toml``; a test compares the keys.

    >>> "en" in languages()
    True
    """
    return list(_languages())


@cache
def _languages() -> tuple[str, ...]:
    # Cached: every run of a pilot looks it up, and languages do not change while a program runs.
    names = (entry.name for entry in files("slipscale.experiments").joinpath("languages").iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml")))


def flatten(table: Mapping[str, object], prefix: str = "") -> dict[str, str]:
    """Flatten a nested table to one level, with keys joined by dots.

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
    """Return all texts of a language, with a study's own texts in place of the shipped ones.

    Parameters
    ----------
    language : str
        Code of a shipped language.
    replacements : Mapping, optional
        Texts that replace the shipped ones, nested or with dotted keys.
    brought : Mapping, optional
        Texts that the run's protocols add to the shipped ones.
    words : AttributeWords, optional
        The words of what is judged; default: those of slipperiness.

    Raises
    ------
    UserError
        If the language does not exist, or a replacement would fail during a session.
    """
    if language not in _languages() and not replacements:
        raise UserError(f"language '{language}': expected one of {', '.join(languages())}")
    if not replacements and not brought:
        return shipped_texts(language, words)
    faults = text_faults(language, replacements or {}, brought)
    if faults:
        sentences = (f"texts.{language}.{key}: {sentence}" for key, sentence in faults)
        raise UserError("; ".join(sentences))
    known = words or ATTRIBUTES[SLIPPERINESS].get(language, ATTRIBUTES[SLIPPERINESS][ENGLISH])
    own = {key: known.fill(text) for key, text in flatten(replacements or {}).items()}
    return shipped_texts(language, words) | dict(brought or {}) | own


@cache
def shipped_texts(language: str, words: AttributeWords | None = None) -> dict[str, str]:
    """Return the texts of a shipped language; all callers share the result, so do not modify it.

    For other languages these are the English texts, which the study's own texts replace. Without
    ``words``, the texts are about slipperiness.
    """
    known = language if language in _languages() else ENGLISH
    source = files("slipscale.experiments").joinpath("languages", f"{known}.toml")
    judged = words or ATTRIBUTES[SLIPPERINESS][known]
    return flatten(tomllib.loads(judged.fill(source.read_text(encoding="utf-8"))))


def text_faults(
    language: str, replacements: Mapping[str, object], brought: Texts | None = None
) -> list[tuple[str, str]]:
    """Return the key and error message for each study text that would fail in a session."""
    shipped, own = shipped_texts(language) | dict(brought or {}), flatten(replacements)
    known = {key: text for key, text in own.items() if key in shipped}
    return [
        *((key, _unknown(key, shipped)) for key in own if key not in shipped),
        *_blank_faults(known, shipped),
        *_key_faults(shipped | known),
    ]


def unshown(own: Texts) -> Iterator[tuple[str, str]]:
    """Yield the key and error message for each text that its screen cannot show."""
    for key, text in own.items():
        # The length of texts from external protocols is not checked.
        long = too_long(key, text) if key in shipped_texts(ENGLISH) else ""
        if sentence := not_drawn(text) or long:
            yield key, sentence


def missing(own: Texts, brought: Texts) -> list[str]:
    """Return the keys for which a study's added language has no text, in the English order.

    Parameters
    ----------
    own : Mapping
        The language's texts by dotted key; an empty text counts as missing.
    brought : Mapping
        Texts that the study's protocols add, in English or another language.
    """
    return [key for key in to_translate(brought) if not own.get(key, "").strip()]


def to_translate(brought: Texts) -> dict[str, str]:
    """Return the English texts that a study's added language must translate."""
    english = {**shipped_texts(ENGLISH), **brought}
    return {key: text for key, text in english.items() if key not in SET_BY_KEYS}


def unlike(own: Texts, brought: Texts) -> Iterator[tuple[str, str]]:
    """Yield the key and error message for each text that lacks the English placeholders or answers.

    A replacement within a language may omit a placeholder; a translation omits it only by mistake.
    """
    for key, english in to_translate(brought).items():
        if not (text := own.get(key, "")):
            continue
        if lost := (blanks(english) or set()) - (blanks(text) or set()):
            yield key, f"{', '.join(f'{{{name}}}' for name in sorted(lost))} is missing"
        if " | " in english and len(answers(text)) != len(answers(english)):
            yield key, f"expected {len(answers(english))} answers separated by |"


def texts_hash(texts: Texts) -> str:
    """Return the SHA-256 of all texts that a participant could read, in hexadecimal."""
    return hashlib.sha256(json.dumps(dict(sorted(texts.items()))).encode()).hexdigest()


def _unknown(key: str, shipped: Texts) -> str:
    """Return the error message for an unknown key."""
    near = get_close_matches(key, shipped, n=3) or sorted(shipped)
    return f"unknown text; expected a text such as {', '.join(near)}"


def blanks(text: str) -> set[str] | None:
    """Return the names in a text's {braces}; None if the braces are unbalanced.

    >>> blanks("{done} of {total}") == {"done", "total"}, blanks("50 % {")
    (True, None)
    """
    try:
        parts = list(Formatter().parse(text))
    except ValueError:
        return None
    return {f"{name}{f':{form}' if form else ''}" for _, name, form, _ in parts if name is not None}


def answers(text: str) -> list[str]:
    """Return the answers listed in a text.

    >>> answers("not sure | sure")
    ['not sure', 'sure']
    """
    return [word.strip() for word in text.split("|")]


def _blank_faults(own: Texts, shipped: Texts) -> Iterator[tuple[str, str]]:
    """Yield the key and error message for each text with {braces} that nothing fills in."""
    for key, text in own.items():
        found, known = blanks(text), blanks(shipped[key]) or set()
        if found is None or not found <= known:
            filled = ", ".join(f"{{{name}}}" for name in sorted(known)) or "none"
            yield key, f"its braces cannot be filled in; available: {filled}"


def _key_faults(texts: Texts) -> Iterator[tuple[str, str]]:
    """Yield the key and error message for invalid keys, decimal signs and lists of answers."""
    yes, no = texts["window.yes_key"].casefold(), texts["window.no_key"].casefold()
    if len(yes) != 1 or len(no) != 1 or yes == no or not (yes + no).isalpha():
        yield "window", f"yes_key '{yes}' and no_key '{no}': expected two different letters"
    if texts["window.decimal"] not in (".", ","):
        yield "window.decimal", "expected a point or a comma"
    key = "descending_difference.confidence_options"
    words = answers(texts[key])
    fits = FEWEST_ANSWERS <= len(words) <= NUMBER_KEYS
    if not fits or "" in words or len(set(words)) < len(words):
        yield key, (f"expected {FEWEST_ANSWERS} to {NUMBER_KEYS} different answers separated by |")
