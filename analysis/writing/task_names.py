"""Format task names for the report, including the label and the condition.

A task is identified by its label in file names, followed by ``_factor-level`` for each factor of
the study. The label is omitted if it is the name of an installed protocol or the beginning of one,
because the title then contains the same information. The label is also omitted if the task is a
table of answers from another laboratory.
"""

from __future__ import annotations

import re
from functools import cache

from slipscale.analysis.reading.foreign.layouts.answers import ANSWERS
from slipscale.analysis.writing.factor_words import factor_level, factor_name
from slipscale.experiments.protocol_parts.registry import protocol_names

#: One factor and its level; names of factors contain no hyphen.
CONDITION = re.compile(r"_([^-]+?)-(.+?)(?=_[^_-][^-]*-|$)")


def task_name(title: str, task: str) -> str:
    """Format a task's title, label and condition.

    >>> task_name("Category scale", "categoryscale_frequency_hz-20_hand-left")
    'Category scale, frequency 20 Hz, hand left'
    >>> task_name("Triads", "triads"), task_name("Matching", "my_table")
    ('Triads (triads)', 'Matching (my_table)')
    """
    label, _, conditions = task.partition("_") if "-" in task else (task, "", "")
    usual = label.startswith(ANSWERS) or any(name.startswith(label) for name in _protocols())
    named = title if usual else f"{title} ({label})"
    levels = CONDITION.findall(f"_{conditions}")
    in_words = (f"{factor_name(factor)} {factor_level(factor, level)}" for factor, level in levels)
    return ", ".join([named, *in_words])


@cache
def _protocols() -> tuple[str, ...]:
    return tuple(name.replace("_", "") for name in protocol_names())
