"""Define the space for each text on the screen, and check that texts fit and can be drawn.

Space is measured in lines and in letters of average width.
"""

from __future__ import annotations

import textwrap
import unicodedata
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import chain


@dataclass(frozen=True, slots=True)
class Room:
    """Space that is available for a text on the screen.

    Parameters
    ----------
    where : str
        Description for translators.
    letters : int
        Number of letters per line at the smallest font size.
    lines : int
        Number of lines.
    """

    where: str
    letters: int
    lines: int


LETTER_KEY = Room("the letter on a key, not a word", 1, 1)
KEY_NAME = Room("the name of a key, within a sentence", 24, 1)
TITLE = Room("the one-line title of a screen", 44, 1)
PAGE = Room("a page that participants read at their own pace", 90, 19)
PROMPT = Room("a question or instruction, in large letters", 62, 4)
OPTION = Room("an answer, next to its key", 60, 1)
OPTIONS = Room("answers, separated by |, below or next to their keys", 160, 1)
UNDER_KEY = Room("one or two words below a key", 22, 3)
FOOT = Room("a line of small print at the bottom of a screen", 72, 2)
WORD = Room("a few words shown briefly", 40, 3)
BANNER = Room("the one-line strip at the top of a pilot's screens", 90, 1)

# The space for each pattern of text keys; the first matching pattern applies.
ROOMS: tuple[tuple[str, Room], ...] = (
    ("window.yes_key", LETTER_KEY),
    ("window.no_key", LETTER_KEY),
    ("window.again_key", LETTER_KEY),
    ("window.go_on_key", KEY_NAME),
    ("window.key_*", KEY_NAME),
    ("window.go_on", KEY_NAME),
    ("window.decimal", LETTER_KEY),
    ("window.say_number", WORD),
    ("window.pilot", BANNER),
    ("window.back_touch", UNDER_KEY),
    ("window.yes", UNDER_KEY),
    ("window.no", UNDER_KEY),
    ("window.turn_up", UNDER_KEY),
    ("window.turn_down", UNDER_KEY),
    ("window.feel_again", UNDER_KEY),
    ("window.stop_yes", UNDER_KEY),
    ("window.stop_no", UNDER_KEY),
    ("window.stop", PROMPT),
    ("window.focus", PROMPT),
    ("window.release_keys", PROMPT),
    ("window.*", FOOT),
    ("session.consent_yes", OPTION),
    ("session.consent_no", OPTION),
    ("session.consent_question", PROMPT),
    ("session.consent", PAGE),
    ("session.welcome", PAGE),
    ("session.rest", PROMPT),
    ("session.hold", PROMPT),
    ("headphones.ear_*", OPTION),
    ("headphones.level_*", OPTION),
    ("headphones.listen", WORD),
    ("headphones.tones", OPTIONS),
    ("headphones.again", PAGE),
    ("forced_choice.*", WORD),
    ("matching.feel_again", PAGE),
    ("*title", TITLE),
    ("*instructions*", PAGE),
    ("*options", OPTIONS),
    ("comparing.steps", OPTIONS),
    ("session.*", PAGE),
    ("*.practice", PAGE),
    ("*.main", PAGE),
    ("*", PROMPT),
)

# Hexadecimal code points that Noto Sans (the window's font, 2.013) can draw, for scripts written
# from left to right in separate letters: Latin, Greek, Cyrillic, and symbols.
DRAWN = (
    "20-7E A0-2FF 370-377 37A-37F 384-38A 38C 38E-3A1 3A3-3E1 3F0-482 48A-52F 1E00-1F15 1F18-1F1D "
    "1F20-1F45 1F48-1F4D 1F50-1F57 1F59 1F5B 1F5D 1F5F-1F7D 1F80-1FB4 1FB6-1FC4 1FC6-1FD3 "
    "1FD6-1FDB 1FDD-1FEF 1FF2-1FF4 1FF6-1FFE 2000-200A 2010-2029 202F-205F 2070-2071 2074-208E "
    "2090-209C 20A0-20C0 2100-215F 2183-2184 2189 2212 2C60-2C7F A722-A7CA"
)
LETTERS = frozenset(
    chr(point)
    for point in chain.from_iterable(
        range(int(first, 16), int(last or first, 16) + 1)
        for first, _, last in (part.partition("-") for part in DRAWN.split())
    )
)
FROM_THE_RIGHT = ("R", "AL")
# Fonts that contain a letter, keyed by the first word of the letter's Unicode name.
FONTS = {
    "ARABIC": "Noto Sans Arabic",
    "HEBREW": "Noto Sans Hebrew",
    "CJK": "Noto Sans CJK",
    "HIRAGANA": "Noto Sans CJK JP",
    "KATAKANA": "Noto Sans CJK JP",
    "HANGUL": "Noto Sans CJK KR",
    "DEVANAGARI": "Noto Sans Devanagari",
    "BENGALI": "Noto Sans Bengali",
    "TAMIL": "Noto Sans Tamil",
    "THAI": "Noto Sans Thai",
    "ARMENIAN": "Noto Sans Armenian",
    "GEORGIAN": "Noto Sans Georgian",
    "ETHIOPIC": "Noto Sans Ethiopic",
}
MOST_SHOWN = 8


def room_of(key: str) -> Room:
    """Return the screen space available for the text with a given key.

    >>> room_of("matching.title").where
    'the one-line title of a screen'
    """
    return next(room for pattern, room in ROOMS if fnmatchcase(key, pattern))


def not_drawn(text: str) -> str:
    """Return the reason why a text cannot be drawn, or an empty string if it can.

    >>> not_drawn("Größe?"), not_drawn("שלום")[:23]
    ('', 'it is written from righ')
    """
    if any(unicodedata.bidirectional(each) in FROM_THE_RIGHT for each in text):
        return (
            "it is written from right to left, which the participant's screen cannot display"
            f"{_fonts(text)}"
        )
    # A letter and its accent are merged if Unicode has a single character for them.
    signs = unicodedata.normalize("NFC", text)
    strange = dict.fromkeys(each for each in signs if each not in LETTERS and each != "\n")
    if not strange:
        return ""
    shown = ", ".join(f"{each!r} (U+{ord(each):04X})" for each in list(strange)[:MOST_SHOWN])
    return (
        f"the participant's screen cannot display {shown}; it supports Latin, Greek and Cyrillic "
        "letters"
        f"{_fonts(signs)}"
    )


def _fonts(text: str) -> str:
    """Return a note that lists fonts for the scripts of a text that the screen cannot display."""
    scripts = [unicodedata.name(each, "").split(" ")[0].split("-")[0] for each in text]
    names = dict.fromkeys(FONTS[script] for script in scripts if script in FONTS)
    return f" (fonts that contain these letters: {', '.join(names)})" if names else ""


def too_long(key: str, text: str) -> str:
    """Return an error message if a text is too long for the screen, otherwise an empty string."""
    room = room_of(key)
    lines = [
        line
        for paragraph in text.strip().split("\n")
        for line in textwrap.wrap(paragraph, room.letters) or [""]
    ]
    if len(lines) <= room.lines and all(len(line) <= room.letters for line in lines):
        return ""
    fits = f"{room.lines} lines of {room.letters}" if room.lines > 1 else f"{room.letters}"
    return f"it is too long for its place ({room.where}); about {fits} characters fit"
