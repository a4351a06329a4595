"""Suggest corrections for misspelt words."""

from __future__ import annotations

from collections.abc import Iterable

from slipscale.faults.message import Message

# Maximum number of words listed in an error message.
MOST_LISTED = 24


def nearest(word: object, known: Iterable[str]) -> str | None:
    """Return the known word that is most similar to a misspelt word, or None.

    >>> nearest("pilto", ["run", "pilot"]), nearest("zzz", ["run", "pilot"])
    ('pilot', None)
    """
    from difflib import get_close_matches

    spelt = {each.casefold(): each for each in known}
    found = get_close_matches(str(word).casefold(), spelt, n=1)
    return spelt[found[0]] if found else None


def did_you_mean(word: object, known: Iterable[str], *, start: str = "") -> str:
    """Return a suggestion in parentheses, or an empty string if no known word is similar.

    ``start`` is inserted before the suggested word, for example the name of a command.

    >>> did_you_mean("pilto", ["run", "pilot"])
    " (did you mean 'pilot'?)"
    """
    found = nearest(word, known)
    if not found or found == word:
        return ""
    return Message(" (did you mean '{meant}'?)", meant=start + found)


def expected_one_of(word: object, known: Iterable[str]) -> str:
    """List the expected words, and suggest the one that is most similar to the given word.

    >>> expected_one_of("alice", ["bob", "alicia"])
    "expected one of bob, alicia (did you mean 'alicia'?)"
    """
    listed = list(known)
    words = ", ".join(listed[:MOST_LISTED]) + (", ..." if len(listed) > MOST_LISTED else "")
    return Message("expected one of {words}{meant}", words=words, meant=did_you_mean(word, listed))
