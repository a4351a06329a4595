"""Define the order of labels in tables and figures."""

from __future__ import annotations

import re

NUMBER = re.compile(r"\d+(?:\.\d+)?")


def numbers_first(label: object) -> tuple[bool, float, str]:
    """Return a sort key that puts numeric labels first, in numerical order.

    >>> sorted(["10", "b", "2.5", "a"], key=numbers_first)
    ['2.5', '10', 'a', 'b']
    """
    try:
        return False, float(str(label)), ""
    except ValueError:
        return True, 0.0, str(label)


def padded(label: str) -> str:
    """Pad the numbers in a label with zeros, so that sorting puts 80 before 320.

    >>> sorted(["f-320", "f-80"], key=padded)
    ['f-80', 'f-320']
    """
    return NUMBER.sub(lambda number: f"{float(number[0]):020.6f}", label)
