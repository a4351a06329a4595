"""Change a valid file in a few places, as people, editors and damaged disks do.

Changes affect a value, a number, a key, a line, a character or the encoding. The same state of the
random generator gives the same changes.
"""

from __future__ import annotations

import re
from random import Random

# A line of TOML, or of JSON in Slipscale's layout.
ENTRY = re.compile(r'(?P<key>\s*["\w.-]+\s*[=:]\s*)(?P<value>.+?)(?P<end>,?)')
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")

# Replacements for values: empty, too large or long, of another type, or almost valid.
ODD = (
    *('""', "[]", "{}", "[[]]", "[{}]", "true", "nan", "-inf", "inf", "0", "-0.0", "-1", "1e308"),
    *("-1e308", "1e-320", "1e999", "10000000000000000000000000", "9" * 400, "9" * 5000, "1e-9"),
    *("1979-05-27", "07:32:00", "'1,5'", '"1"', '"a b"', '"\\u001b[2J"', '"\\u0000"', '"../x"'),
    *('"é\u0301\u202e"', '"' + "x" * 20_000 + '"', "[1, 2, 3]", '["a", "a"]', '{ en = "a" }'),
    *("[0.0, 0.0]", "[1e308, 2.0]", "[" * 5000 + "]" * 5000, "'''", "999999999", "1_000_000"),
    *("0x7fffffffffffffff", "[nan, 1.0]", "{ x = { x = { x = 1 } } }", '["\\n"]', "null"),
)
# Replacements for numbers: small or extreme ones.
ODD_NUMBERS = ("0", "1", "2", "-1", "1e-9", "0.001", "1e6", "1e9", "1e26", "1e308", "nan", "300")
ENCODINGS = ("utf-8",) * 20 + ("utf-8-sig", "utf-8-sig", "utf-16", "cp1252", "latin-1")
LINE_ENDS = ("\n",) * 8 + ("\r\n", "\r")
# Characters to insert: quotation marks, bidirectional marks, and non-characters.
SIGNS = "\"'\\[]{}#=,;.\t\r\n\x00\x1b\x7f\u00a0\u0301\u202e\u2028\ufeff\ufffdéµ０½\U0001f590"
CHANGES = ("value",) * 6 + ("number",) * 8 + ("drop",) * 2 + ("key", "again", "cut", "in")
# Mostly one change, because most code stops at the first error.
HOW_MANY = (1, 1, 1, 1, 1, 2, 2, 3, 4)
# One in CUT_SHORT files is truncated.
CUT_SHORT = 40


def changed_file(random: Random, text: str, cells: str = "") -> bytes:
    """Change lines of a text, encode it, mostly in UTF-8, and truncate it in rare cases.

    Parameters
    ----------
    random : Random
    text : str
        The valid text.
    cells : str
        Separator of cells, for a table; empty for a TOML file.
    """
    content = changed_lines(random, text, cells).encode(random.choice(ENCODINGS), "replace")
    if random.randrange(CUT_SHORT) == 0:
        content = content[: random.randint(0, len(content))]
    return content


def changed_lines(random: Random, text: str, cells: str = "") -> str:
    """Return a text with one to four lines changed; see `changed_file`."""
    lines = text.splitlines()
    for _ in range(random.choice(HOW_MANY)):
        if not lines:
            break
        at = random.randrange(len(lines))
        how = random.choice(CHANGES)
        if how == "value":
            lines[at] = _value_changed(random, lines, at, cells)
        elif how == "number":
            lines[at] = number_changed(random, lines[at])
        elif how == "key":
            lines[at] = random.choice(("x", "", "[", "[[", "\x00", '"')) + lines[at]
        elif how == "drop":
            del lines[at]
        elif how == "again":
            lines.insert(random.randint(0, len(lines)), lines[at])
        elif how == "cut":
            lines[at] = lines[at][: random.randint(0, len(lines[at]))]
        else:
            place = random.randint(0, len(lines[at]))
            lines[at] = lines[at][:place] + characters(random) + lines[at][place:]
    return random.choice(LINE_ENDS).join(lines) + "\n"


def characters(random: Random, most: int = 6) -> str:
    """Return random characters: printable ASCII, special characters, or any others."""
    return "".join(
        random.choice((chr(random.randint(32, 126)), random.choice(SIGNS), _any(random)))
        for _ in range(random.randint(0, most))
    )


def number(random: Random) -> str:
    """Return a number in a form that may occur in a file."""
    return random.choice(
        (
            str(random.randint(-3, 300)),
            str(random.randint(-(2**70), 2**70)),
            f"{random.uniform(-10, 10):.3g}",
            repr(random.choice((1, -1)) * 10 ** random.uniform(-40, 38)),
        )
    )


def number_changed(random: Random, line: str) -> str:
    """Change one number of a line; lines without numbers are unchanged."""
    found = list(NUMBER.finditer(line))
    if not found:
        return line
    one = random.choice(found)
    new = random.choice((random.choice(ODD_NUMBERS), number(random), f"-{one[0]}", f"{one[0]}0"))
    return line[: one.start()] + new + line[one.end() :]


def _any(random: Random) -> str:
    point = random.randrange(0x110000 - 0x800)
    return chr(point if point < 0xD800 else point + 0x800)


def _value_changed(random: Random, lines: list[str], at: int, cells: str) -> str:
    odd = random.choice(ODD) if random.randrange(2) else number(random)
    if cells:
        row = lines[at].split(cells)
        row[random.randrange(len(row))] = odd
        return cells.join(row)
    found = ENTRY.fullmatch(lines[at])
    if not found:
        return f"x = {odd}"
    if random.randrange(2):
        others = [other["value"] for line in lines if (other := ENTRY.fullmatch(line))]
        odd = random.choice(others)
    return f"{found['key']}{odd}{found['end']}"
