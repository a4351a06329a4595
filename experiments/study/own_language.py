"""Insert language files, which contain texts in additional languages, into a study's text.

Language files are inserted when a study is read, because journals contain only the study's text,
and must record what participants read. Slipscale ships only languages that its developers could
check, because participants cannot detect a bad translation.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import RootModel

from slipscale.experiments.languages.screen_room import room_of
from slipscale.experiments.languages.texts import (
    CODE,
    ENGLISH,
    Texts,
    blanks,
    flatten,
    languages,
    missing,
    shipped_texts,
    text_faults,
    to_translate,
    unlike,
    unshown,
)
from slipscale.experiments.protocol_parts.base import protocol_texts
from slipscale.experiments.protocol_parts.registry import load_protocol
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.toml_file import parse_toml
from slipscale.faults.toml_lines import Lines
from slipscale.faults.validation import Fault, complaint, sentences

if TYPE_CHECKING:
    from slipscale.experiments.study.model import Study

KEY = "texts_files"
#: Keys of texts that studies often replace.
EXAMPLES = (
    "session.welcome",
    "session.thanks",
    "magnitude_estimation.instructions",
    "magnitude_estimation.estimate",
)
MOST_NAMED = 6  # number of missing texts that a message lists


class _Table(RootModel[dict[str, Any]]):
    """A TOML table with arbitrary keys."""


def with_own_language(text: str, source: str, *, absent: bool = False) -> str:
    """Return the text of a study file with its language files inserted.

    Parameters
    ----------
    text : str
        The study file's text. Text that is not TOML or lists no language files is returned
        unchanged.
    source : str
        The study file's path; language files are located in the same folder.
    absent : bool
        Whether to ignore missing files.

    Raises
    ------
    UserError
        If a language file cannot be read, is invalid or defines an existing language.
    """
    if KEY not in text:
        return text
    try:
        table = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError):
        return text  # the study parser reports the error
    named = table.get(KEY)
    if not isinstance(table.get("texts", {}), dict):
        return text  # the study parser reports the error
    if not isinstance(named, list) or not all(isinstance(each, str) and each for each in named):
        return text
    import tomlkit

    document = tomlkit.parse(text)
    del document[KEY]
    whole = tomlkit.dumps(document)
    available = {*languages(), *(table.get("texts") or {})}
    for name in named:
        # The console page can set these names, and must not access files outside the folder.
        if Path(name).name != name or "\\" in name or not name.isprintable():
            raise UserError(
                "{source}: texts_files: {name}: expected the name of a file next to the study "
                "file, without a folder",
                source=source,
                name=repr(name),
            )
        path = Path(source).parent / name
        if absent and not path.exists():
            continue
        language, words = _read(path)
        if language in available:
            raise UserError(
                "{path}: language '{language}' already exists; expected another language (to "
                "replace individual texts of {languages}, use [texts] in the study file)",
                path=path,
                language=language,
                languages=", ".join(languages()),
            )
        available.add(language)
        whole += f"\n# The words of {path.name}.\n[texts.{_key(language)}]\n{_lines(words)}"
    try:
        tomllib.loads(whole)
    except tomllib.TOMLDecodeError:
        raise UserError(
            "{source}: [texts] cannot be combined with the texts of {languages}; expected tables "
            "such as [texts.en.session], not texts = {{...}}",
            source=source,
            languages=", ".join(named),
        ) from None
    return whole


def _read(path: Path) -> tuple[str, Texts]:
    """Read a language file, and return its language and all entries that are not empty."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise UserError(
            "{path}: cannot be read ({reason}); expected a file with the texts of a language, as "
            "written by slipscale study texts",
            path=path,
            reason=reason,
        ) from None
    table = dict(parse_toml(text, str(path), _Table).root)
    language = table.pop("language", None)
    words = {key: value for key, value in flatten(table).items() if value.strip()}
    faults: list[Fault] = []
    if not isinstance(language, str) or not CODE.fullmatch(language):
        faults.append((("language",), {"msg": "expected a language code, such as de or pt-BR"}))
    faults += [
        (tuple(key.split(".")), {"msg": "expected words in quotes"})
        for key, value in _leaves(table)
        if not isinstance(value, str)
    ]
    known = {key: words[key] for key in words if key in shipped_texts(ENGLISH)}
    wrong = (*text_faults(ENGLISH, known), *unlike(words, {}), *unshown(words))
    faults += [(tuple(key.split(".")), {"msg": message}) for key, message in wrong]
    if faults:
        raise complaint(str(path), sentences(faults, Lines(text).of))
    return str(language), words


def _leaves(table: Mapping[str, object], prefix: str = "") -> Iterator[tuple[str, object]]:
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def check_words(study: Study, source: str) -> None:
    """Raise `UserError` unless every text in a study can be shown on the screen.

    Check only studies that are about to run. The study in a journal keeps its texts, even if a
    later version of Slipscale adds or removes texts.
    """
    faults = [
        (("texts", language, *filter(None, key.split("."))), {"msg": sentence})
        for language, table in study.texts.items()
        for key, sentence in _faults(study, language, flatten(table), source)
    ]
    if faults:
        raise complaint(source, sentences(faults, lambda _: 0))


def _faults(study: Study, language: str, own: Texts, source: str) -> Iterator[tuple[str, str]]:
    """Yield a key and an error for each invalid text; the key is empty if texts are missing."""
    yield from unshown(own)
    if language in languages():
        return
    brought = brought_texts(study, language)
    yield from text_faults(language, own, brought)
    yield from unlike(own, brought)
    if lacking := missing(own, brought):
        named = ", ".join(lacking[:MOST_NAMED])
        more = f" and {len(lacking) - MOST_NAMED} more" if len(lacking) > MOST_NAMED else ""
        remedy = Message(
            "slipscale study texts {source} --language {language} --out FILE writes all texts",
            source=source,
            language=language,
        )
        yield (
            "",
            (
                Message(
                    "{count} texts are missing: {keys}{more}; {remedy}, including the existing "
                    "ones",
                    count=len(lacking),
                    keys=named,
                    more=more,
                    remedy=remedy,
                )
            ),
        )


def brought_texts(study: Study, language: str) -> dict[str, str]:
    """Return the texts of a study's protocols in a language; untranslated texts are in English."""
    brought: dict[str, str] = {}
    for task in study.tasks:
        brought |= protocol_texts(load_protocol(task.protocol), language)
    return brought


def check_own_code(language: str) -> None:
    """Raise `UserError` if a language code is invalid, or if Slipscale includes the language."""
    if not CODE.fullmatch(language):
        raise UserError(
            "--language {language}: expected a language code, such as de or pt-BR",
            language=language,
        )
    if language in languages():
        raise UserError(
            "--language {language}: this is a shipped language; to replace individual texts, name "
            "their keys under [texts.{language}] in the study file, such as {keys}; slipscale lab "
            "shows the key of every text on the study's screens",
            language=language,
            keys=", ".join(EXAMPLES),
        )


def with_room_for(text: str, source: str, language: str) -> str:
    """Return a study's complete text, with a table (empty if necessary) for a language."""
    whole = with_own_language(text, source, absent=True)
    if language not in parse_toml(whole, source, _Table).root.get("texts", {}):
        whole += f"\n[texts.{_key(language)}]\n"
    return whole


def template(study: Study, language: str) -> str:
    """Return a template for a language file: each key with its English text and screen position.

    The template includes existing translations.
    """
    own = flatten(study.texts.get(language, {}))
    english = to_translate(brought_texts(study, language))
    lines = [
        f"# The participant's texts in the language '{language}'. Write each translation between",
        "# the quotes after its key; keep the words in {braces}, which are replaced by values.",
        "# Above each key: the English text, and its place on the screen.",
        f"language = {json.dumps(language)}",
    ]
    section = ""
    for key, text in english.items():
        table, _, name = key.rpartition(".")
        if table != section:
            section = table
            lines += ["", f"[{section}]"]
        lines += ["", *(f"# {line}".rstrip() for line in text.strip().split("\n"))]
        filled = f" {{{'}, {'.join(sorted(found))}}}" if (found := blanks(text)) else ""
        lines.append(f"# ({room_of(key).where}{'; filled in:' if filled else ''}{filled})")
        lines.append(f"{_key(name)} = {_quoted(own.get(key, ''))}")
    return "\n".join(lines) + "\n"


def _lines(words: Texts) -> str:
    return "".join(
        f"{'.'.join(_key(part) for part in key.split('.'))} = {_quoted(text)}\n"
        for key, text in words.items()
    )


def _key(part: str) -> str:
    return part if re.fullmatch("[A-Za-z0-9_-]+", part) else json.dumps(part)


def _quoted(text: str) -> str:
    """Return a text as a TOML string, which unlike JSON also escapes the character U+007F."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
