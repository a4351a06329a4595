"""Keys of a TOML text are found on their lines, however the text is laid out."""

from __future__ import annotations

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.faults.toml_lines import Lines

LAYOUTS = '''# a = 0
a = """
b = 1
[c]
"""  # closed
b = [ # a list
  1, [2,
  3], "x = ]",
  { c = 1, "d e" = '#' },
]
c.d."e.f" = 1979-05-27 07:32:00
[[tasks]]
x = 1.5
[[tasks]]
x = 2
[[tasks.steps]]
y = 1
[[tasks.steps]]
y = 2
[texts.en]
y = 3
'''


@pytest.mark.parametrize(
    "place, line",
    [
        (("a",), 2),
        (("b",), 6),
        (("b", 0), 7),
        (("b", 1, 1), 8),
        (("b", 2), 8),
        (("b", 3, "c"), 9),
        (("b", 3, "d e"), 9),
        (("b", 9), 6),
        (("c", "d", "e.f"), 11),
        (("c",), 11),
        (("tasks", 0, "x"), 13),
        (("tasks", 1, "x"), 15),
        (("tasks", 1, "missing"), 14),
        (("tasks", 1, "steps", 1, "y"), 19),
        (("texts", "en", "y"), 21),
        (("texts",), 20),
        (("texts", "fr"), 0),
        (("elsewhere",), 0),
        ((), 0),
    ],
)
def test_every_place_has_its_line_its_tables_or_that_of_what_it_holds(place, line):
    assert Lines(LAYOUTS).of(place) == line


def written(value) -> str:
    """Return a value as TOML, lists over several lines, tables inline."""
    if isinstance(value, dict):
        return "{" + ", ".join(f'"{key}" = {written(inner)}' for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[\n" + "".join(f"{written(inner)}, # ]\n" for inner in value) + "]"
    return {True: "true", False: "false"}.get(value, "'''[\n='''") if value is not None else "1.5"


def every_place(value, place=()):
    inner = value.items() if isinstance(value, dict) else enumerate(value)
    for key, each in inner:
        yield (*place, key), each
        if isinstance(each, dict | list):
            yield from every_place(each, (*place, key))


KEYS = st.text(alphabet="ab.[]{}=,#' ", max_size=3)
VALUES = st.recursive(
    st.sampled_from([True, False, None, "long"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3),
    max_leaves=8,
)


@given(VALUES.filter(lambda value: isinstance(value, dict)))
def test_every_place_of_any_structure_is_found_where_it_was_written(table):
    """What stands on the line of a place, read on its own, begins with what is there."""
    text = "".join(
        f"'{key}' = {written(each)}\n" if "'" not in key else f'"{key}" = {written(each)}\n'
        for key, each in table.items()
    )
    assert set(tomllib.loads(text)) == set(table)
    lines, rows = Lines(text), text.split("\n")
    for place, _ in every_place(table):
        row = rows[lines.of(place) - 1]
        if isinstance(place[-1], str):
            assert f'"{place[-1]}" = ' in row or f"'{place[-1]}' = " in row
    tops = [lines.of((key,)) for key in table]
    assert tops == sorted(set(tops))
