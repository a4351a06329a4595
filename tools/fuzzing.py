"""Texts as people, editors and broken disks leave them: for the fuzz tests of every parser.

A file of ours is changed in a few places: a value, a key, a line, a character, its encoding. How
many texts a test tries is ``SLIPSCALE_FUZZ``: a campaign tries 100,000, and then each may take at
most 2 s of the processor and 500 MB.
"""

from __future__ import annotations

import os
import re
import signal
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

CAMPAIGN = os.environ.get("SLIPSCALE_FUZZ")
MOST_S = 2.0
MOST_BYTES = 500 * 2**20
# A line of TOML, or of JSON as we write it.
ENTRY = re.compile(r'(?P<key>\s*["\w.-]+\s*[=:]\s*)(?P<value>.+?)(?P<end>,?)')

# What stands in the place of a value: nothing, too much, another type, what only looks right.
ODD = (
    *('""', "[]", "{}", "[[]]", "[{}]", "true", "nan", "-inf", "inf", "0", "-0.0", "-1", "1e308"),
    *("-1e308", "1e-320", "1e999", "10000000000000000000000000", "9" * 400, "9" * 5000, "1e-9"),
    *("1979-05-27", "07:32:00", "'1,5'", '"1"', '"a b"', '"\\u001b[2J"', '"\\u0000"', '"../x"'),
    *('"é\u0301\u202e"', '"' + "x" * 20_000 + '"', "[1, 2, 3]", '["a", "a"]', '{ en = "a" }'),
    *("[0.0, 0.0]", "[1e308, 2.0]", "[" * 5000 + "]" * 5000, "'''", "999999999", "1_000_000"),
    *("0x7fffffffffffffff", "[nan, 1.0]", "{ x = { x = { x = 1 } } }", '["\\n"]'),
)
NUMBERS = st.one_of(
    st.integers().map(str),
    st.integers(-3, 300).map(str),
    st.floats(width=32, allow_nan=False, allow_infinity=False).map(repr),
)
ENCODINGS = ("utf-8",) * 6 + ("utf-8-sig", "utf-16", "cp1252", "latin-1")


def campaign(quick: int) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Return Hypothesis' settings: so many texts, or as many as a campaign wants."""
    return settings(
        max_examples=int(CAMPAIGN or quick),
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )


@contextmanager
def bounded() -> Iterator[None]:
    """Fail, in a campaign, where one text takes more time or memory than any may.

    Raises
    ------
    AssertionError
        It did.
    """
    if not CAMPAIGN:
        yield
        return
    import resource  # noqa: PLC0415 - POSIX only, as campaigns are

    def too_long(*_: object) -> None:
        raise AssertionError(f"more than {MOST_S} s of the processor for one text")

    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    held = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    # Not the machine's memory, but a MemoryError, ends what asks for too much.
    resource.setrlimit(resource.RLIMIT_AS, (held + 2 * MOST_BYTES, hard))
    handler = signal.signal(signal.SIGPROF, too_long)
    signal.setitimer(signal.ITIMER_PROF, MOST_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, handler)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
    more = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
    if more > MOST_BYTES:
        raise AssertionError(f"{more / 2**20:.0f} MB for one text")


@st.composite
def changed_lines(draw: st.DrawFn, text: str, cells: str = "") -> str:
    """Return a text with some of its lines changed.

    Parameters
    ----------
    text : str
        As it should be.
    cells : str
        What parts cells, in a table; in a TOML file nothing does.
    """
    lines = text.splitlines()
    for _ in range(draw(st.integers(1, 4))):
        if not lines:
            break
        at = draw(st.integers(0, len(lines) - 1))
        how = draw(
            st.sampled_from(("value", "value", "value", "key", "drop", "again", "cut", "in"))
        )
        if how == "value":
            lines[at] = draw(_value_changed(lines, at, cells))
        elif how == "key":
            lines[at] = draw(st.sampled_from(("x", "", "[", "[[", "\x00", '"'))) + lines[at]
        elif how == "drop":
            del lines[at]
        elif how == "again":
            lines.insert(draw(st.integers(0, len(lines))), lines[at])
        elif how == "cut":
            lines[at] = lines[at][: draw(st.integers(0, len(lines[at])))]
        else:
            place = draw(st.integers(0, len(lines[at])))
            lines[at] = lines[at][:place] + draw(st.text(max_size=6)) + lines[at][place:]
    return draw(st.sampled_from(("\n", "\n", "\n", "\r\n", "\r"))).join(lines) + "\n"


@st.composite
def _value_changed(draw: st.DrawFn, lines: list[str], at: int, cells: str) -> str:
    odd = draw(st.one_of(st.sampled_from(ODD), NUMBERS))
    if cells:
        row = lines[at].split(cells)
        row[draw(st.integers(0, len(row) - 1))] = odd
        return cells.join(row)
    found = ENTRY.fullmatch(lines[at])
    if not found:
        return f"x = {odd}"
    others = [other["value"] for line in lines if (other := ENTRY.fullmatch(line))]
    value = draw(st.one_of(st.just(odd), st.sampled_from(others)))
    return f"{found['key']}{value}{found['end']}"


@st.composite
def changed_file(draw: st.DrawFn, text: str, cells: str = "") -> bytes:
    """Return a text with some of its lines changed, in some encoding, perhaps cut short."""
    content = draw(changed_lines(text, cells)).encode(draw(st.sampled_from(ENCODINGS)), "replace")
    if draw(st.integers(0, 19)) == 0:
        content = content[: draw(st.integers(0, len(content)))]
    return content
