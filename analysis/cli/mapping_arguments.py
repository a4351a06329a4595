"""Declare the options that state what a table's columns mean."""

from __future__ import annotations

from argparse import Action, ArgumentParser, Namespace
from typing import TYPE_CHECKING

from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reading.meaning.mapping import TableMapping

#: Options that specify the columns of a table: option -> metavar, help text.
COLUMN_OPTIONS = {
    "participant": ("COLUMN", "column with the participant's label"),
    "stimulus": ("COLUMN:UNIT", "column with the stimulus, and its unit"),
    "response": ("COLUMN", "column with magnitude estimates"),
    "answer": ("COLUMN", "column with yes or no, instead of --response"),
    "yes_count": ("COLUMN", "column with the number of yes answers, instead of --answer"),
    "no_count": ("COLUMN", "column with the number of no (or wrong) answers"),
    "percent": ("COLUMN", "column with the percentage of yes answers, used with --n"),
    "n": (
        "COLUMN",
        "column with the total number of answers, or this number itself; used with counts",
    ),
    "reference": (
        "COLUMN",
        "column with the previous stimulus, used with --answer (if omitted, it is 0)",
    ),
    "first": ("COLUMN", "for pairs: column with the first item"),
    "second": ("COLUMN", "for pairs: column with the second item"),
    "chosen": (
        "COLUMN",
        "for choices in pairs: column with the chosen item (its name, left or right, or 1 or 2)",
    ),
    "dissimilarity": ("COLUMN", "for ratings of pairs: column with the dissimilarity"),
    "group": ("COLUMN", "column with the participant's group"),
    "factor": (
        "COLUMN",
        "column with a condition that varies within participants and is crossed with the stimuli",
    ),
    "session": ("COLUMN", "column with the session"),
    "run": ("COLUMN", "column with the run"),
    "block": ("COLUMN", "column with the block, if trial numbers restart in each block"),
    "trial": ("COLUMN", "column with the trial number"),
}
#: Options that specify the arrangement of answers: option -> metavar, help text.
SHAPE_OPTIONS = {
    "quadruple": ("A,B,C,D", "for difference scaling: columns of the pairs A, B and C, D"),
    "triad": ("A,B,C", "for difference scaling: columns of the steps from A to B and from B to C"),
    "rows_of": (
        "COLUMN=STIMULUS,ANSWER",
        "stimuli and answers are in separate rows, in which this column has these values",
    ),
}


class _Once(Action):
    """Reject an option that is given twice, whereas argparse would use the last value."""

    def __call__(
        self,
        parser: ArgumentParser,  # noqa: ARG002 - argparse's signature
        namespace: Namespace,
        values: object,
        option: str | None = None,
    ) -> None:
        if getattr(namespace, self.dest) is not None:
            raise UserError("{option} is given twice; expected only once", option=option)
        setattr(namespace, self.dest, values)


def add_mapping(parser: ArgumentParser) -> None:
    """Add the options that specify what a table's columns contain."""
    group = parser.add_argument_group(
        "your own data", "meaning of a table's columns; see docs/how-to/your-data.md"
    )
    for name, (metavar, text) in COLUMN_OPTIONS.items():
        option = f"--{name.replace('_', '-')}"
        group.add_argument(option, metavar=metavar, help=text, action=_Once)
    group.add_argument(
        "--in-unit",
        metavar="UNIT",
        help="unit for the report, which may differ from the unit of the data only in its prefix, "
        "such as mPa for data in µPa",
    )
    group.add_argument(
        "--levels",
        metavar="COLUMN=LEVEL",
        nargs="+",
        action=_Once,
        help="for a wide table: response columns and their levels; without =LEVEL, the number at "
        "the end of the column name is the level (p0,5 and p0.5 are 0.5)",
    )
    for name, (metavar, text) in SHAPE_OPTIONS.items():
        group.add_argument(f"--{name.replace('_', '-')}", metavar=metavar, help=text, action=_Once)
    group.add_argument(
        "--participant-from-name",
        metavar="PATTERN",
        nargs="?",
        const="",
        help="the participant is the part of the file names that differs, or the group in a "
        "regular expression, such as '^([^_]+)'; write the files before this option",
    )
    group.add_argument(
        "--people-in-columns",
        action="store_true",
        help="the first column contains the levels, and each other column one participant",
    )
    group.add_argument(
        "--matrix",
        choices=("wins", "similarities", "dissimilarities"),
        help="a square table of items: wins of the row over the column, similarities or "
        "dissimilarities",
    )
    group.add_argument(
        "--no-header",
        action="store_true",
        help="the table has no line with column names; the columns are called 1, 2, 3",
    )
    group.add_argument(
        "--only",
        metavar="COLUMN=VALUE",
        action="append",
        help="analyse only the rows in which this column has this value; if repeated for the same "
        "column, rows with any of the values; for several columns, rows that match all of them",
    )
    for name, meaning in (
        ("yes", "yes or correct (default: usual pairs of codes are recognised)"),
        ("no", "no or wrong (default: the one code that is left)"),
        ("missing", "that there is no answer; these trials are left out and counted"),
    ):
        group.add_argument(
            f"--{name}", metavar="CODE", nargs="+", help=f"codes in --answer that mean {meaning}"
        )
    group.add_argument(
        "--alternatives",
        type=int,
        choices=(2, 3),
        help=("number of alternatives in a forced choice; yes then means correct"),
    )
    group.add_argument(
        "--decimal",
        choices=(".", ","),
        help=("decimal mark, if it cannot be detected"),
    )
    group.add_argument(
        "--sheet", metavar="NAME", help="sheet of an Excel workbook, or variable in a MATLAB file"
    )
    group.add_argument(
        "--map",
        action="store_true",
        help=("save these options in analysis.toml next to the table"),
    )


def mapping_from(args: Namespace) -> TableMapping | None:
    """Return the mapping that the options define, or None if no such option is given.

    Raises
    ------
    UserError
        If the options contradict each other.
    """
    from slipscale.analysis.reading.meaning.keywords import mapping_of

    given = meanings_in(args)
    if not given and args.map:
        raise UserError(
            "--map: requires options that name the columns, such as --participant and --stimulus"
        )
    return mapping_of(given) if given else None


def meanings_in(args: Namespace) -> dict[str, object]:
    """Return the options that state the meaning of the columns, as keywords."""
    from slipscale.analysis.reading.meaning.keywords import MEANINGS

    return {
        name: value
        for name in MEANINGS
        if (value := getattr(args, name)) is not None and value is not False
    }
