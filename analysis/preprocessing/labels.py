"""Define the order of labels in tables and figures."""

from __future__ import annotations


def numbers_first(label: object) -> tuple[bool, float, str]:
    """Return a sort key that puts numeric labels first, in numerical order.

    >>> sorted(["10", "b", "2.5", "a"], key=numbers_first)
    ['2.5', '10', 'a', 'b']
    """
    try:
        return False, float(str(label)), ""
    except ValueError:
        return True, 0.0, str(label)
