"""Define which options describe which layout of a table.

A layout is recognised by the options that only it has. To support another layout, add a line to
`RULES`, and a line to `slipscale.analysis.reading.foreign.layouts.table.LAYOUTS`.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

#: Options that describe the context of an answer.
CONTEXT = frozenset({"participant", "group", "factor", "session", "run", "block", "trial"})
#: Options that describe codes.
CODES = frozenset({"yes", "no", "missing", "alternatives"})
_OF_PAIRS = frozenset({"participant", "session", "run", "trial", "group"})
_CODED = CODES - {"alternatives"}
_WHY = {
    "trial": "a trial number requires one response per row",
    "group": "expected one row per answer, with the group in a column",
    "factor": "select one condition at a time with --only",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """The options that describe a layout.

    Parameters
    ----------
    name : str
        Noun phrase for messages.
    marks : frozenset
        Options of which one is given for this layout; empty for the last rule.
    needs : tuple of frozenset
        Possible combinations of options, without those of `CONTEXT` and `CODES`.
    may : frozenset
        Options of `CONTEXT` and `CODES` that are possible.
    expected : str
        The combinations in words.
    """

    name: str
    marks: frozenset[str]
    needs: tuple[frozenset[str], ...]
    may: frozenset[str]
    expected: str

    def fault(self, given: Collection[str]) -> str:
        """Return why the given options cannot describe this layout, or "" if they can."""
        others = frozenset(given) & (CONTEXT | CODES)
        if frozenset(given) - others not in self.needs:
            found = ", ".join(map(_option, given)) or "none"
            return f"{self.name} needs {self.expected}; found {found}"
        for wrong in sorted(others - self.may):
            why = _WHY.get(wrong, "codes and alternatives belong to a column of answers (--answer)")
            return f"{self.name} cannot have {_option(wrong)}; {why}"
        return ""


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _ways(*ways: str) -> tuple[frozenset[str], ...]:
    return tuple(frozenset(way.split()) for way in ways)


#: The first rule with a given mark applies.
RULES = (
    Rule(
        name="a square table",
        marks=frozenset({"matrix"}),
        needs=_ways("matrix"),
        may=frozenset({"participant", "session", "run"}),
        expected="--matrix alone, or with --participant",
    ),
    Rule(
        name="a table of quadruples or triads",
        marks=frozenset({"quadruple", "triad"}),
        needs=_ways("quadruple answer", "triad answer"),
        may=_OF_PAIRS | _CODED,
        expected="--quadruple A,B,C,D or --triad A,B,C, with --answer",
    ),
    Rule(
        name="a table of pairs",
        marks=frozenset({"first", "second", "dissimilarity", "chosen"}),
        needs=_ways("first second dissimilarity", "first second chosen"),
        may=_OF_PAIRS | {"missing"},
        expected="--first and --second, with --dissimilarity or --chosen",
    ),
    Rule(
        name="a table with people in columns",
        marks=frozenset({"people_in_columns"}),
        needs=_ways("people_in_columns", "people_in_columns n"),
        may=frozenset({"alternatives"}),
        expected="--people-in-columns, and --n if the cells are numbers of yes answers",
    ),
    Rule(
        name="a wide table",
        marks=frozenset({"levels"}),
        needs=_ways("levels", "levels n"),
        may=CONTEXT - {"trial"} | {"alternatives"},
        expected="--levels, and --n if the cells are numbers of yes answers",
    ),
    Rule(
        name="a table of counts",
        marks=frozenset({"yes_count", "no_count", "percent", "n"}),
        needs=_ways(
            *(
                f"stimulus {counted}{reference}"
                for counted in ("yes_count n", "no_count n", "yes_count no_count", "percent n")
                for reference in ("", " reference")
            )
        ),
        may=CONTEXT - {"trial"} | {"alternatives"},
        expected=(
            "--stimulus with two of --yes-count, --no-count and --n, or with --percent and --n"
        ),
    ),
    Rule(
        name="a table of answers",
        marks=frozenset({"answer"}),
        needs=_ways(
            *(
                f"stimulus answer{reference}{rows}"
                for reference in ("", " reference")
                for rows in ("", " rows_of")
            )
        ),
        may=CONTEXT | CODES,
        expected="--stimulus and --answer, and perhaps --reference",
    ),
    Rule(
        name="a table of magnitude estimates",
        marks=frozenset(),
        needs=_ways("stimulus response", "stimulus response rows_of"),
        may=CONTEXT,
        expected=(
            "--stimulus and --response (or --answer, or --yes-count and --n, for yes and no); a "
            "wide table needs --levels"
        ),
    ),
)


def rule_of(given: Collection[str]) -> Rule:
    """Return the rule of the layout that the given options describe."""
    return next(rule for rule in RULES if not rule.marks or not rule.marks.isdisjoint(given))
