"""Implement ``slipscale analyse``."""

from __future__ import annotations

import logging
import sys
from argparse import Action, ArgumentParser, Namespace
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.analysis.cli.progress_line import add_steps, telling
from slipscale.experiments.lab.defaults import dataset_default, here, say
from slipscale.faults import ANSWER_IS_NO, DONE, UserError, harmless

if TYPE_CHECKING:
    from slipscale.analysis.preregistration.bundle import Bundle
    from slipscale.analysis.tasks.kind import Analysis


LOG = logging.getLogger(__name__)
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


def add_analyse(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale analyse``."""
    add_data(parser)
    parser.add_argument(
        "--out",
        metavar="DIR",
        help=("folder for the results (default: DATASET/derivatives/slipscale)"),
    )
    parser.add_argument("--json", action="store_true", help="print Table III as JSON")
    parser.add_argument(
        "--figures",
        nargs="+",
        choices=("svg", "png", "pdf"),
        default=(),
        metavar="FORMAT",
        help="figure formats in addition to svg: png, pdf or both (default: svg, and fig15.png)",
    )
    parser.add_argument(
        "--plan",
        type=Path,
        metavar="BUNDLE",
        help="compare data and analysis with a plan that slipscale study freeze has frozen, and "
        "report all deviations (exit status 1 if there are any)",
    )
    add_steps(parser)
    add_mapping(parser)


def add_data(parser: ArgumentParser) -> None:
    """Add the arguments for the data and the analysis method."""
    from typing import get_args

    from slipscale.experiments.study.analysis_choices import Axis, Normalisation

    rules = get_args(Normalisation)
    parser.add_argument(
        "dataset",
        metavar="DATASET",
        help="folder of a data set; or tables with the same columns, or a folder of them: CSV, "
        "TSV, Excel, SPSS, MATLAB, jsPsych, Qualtrics, E-Prime; or - for standard input",
        **dataset_default() | {"nargs": "*" if here().file else "+"},
    )
    parser.add_argument(
        "--in-session",
        metavar="LABEL",
        help="analyse only one session (default: all sessions combined)",
    )
    parser.add_argument(
        "--task",
        metavar="LABEL",
        help="label of the task to analyse, if a study has several tasks with magnitude "
        "estimation or descending difference (default: the first), or if a BIDS folder has several "
        "tasks",
    )
    parser.add_argument(
        "--normalise",
        metavar="RULE",
        choices=rules,
        help=f"rule for normalising estimates to a common scale: {', '.join(rules)}",
    )
    parser.add_argument(
        "--equivalence",
        metavar="RATIO",
        type=float,
        help="ratio of geometric means within which two amplitudes count as equal (default: as in "
        "the study file, otherwise 1.25)",
    )
    parser.add_argument(
        "--axis",
        choices=get_args(Axis),
        help="axis of all threshold curves (default: as in the study file, otherwise logarithmic "
        "for forced choice and linear for yes-no answers and comparisons)",
    )
    parser.add_argument(
        "--bayesian",
        action="store_true",
        help="also fit a hierarchical Bayesian power function with individual exponents, which "
        "takes half a minute and requires pip install 'slipscale[bayes]'",
    )


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


def paths_of(args: Namespace) -> list[Path]:
    """Return the paths of the data set."""
    given = args.dataset
    return [Path(path) for path in (given if isinstance(given, list) else [given])]


def analysed(args: Namespace, progress: Callable[[str], None]) -> Analysis:
    """Read and analyse the data specified by the options."""
    from slipscale.analysis.cli.mapping_options import mapping_from
    from slipscale.analysis.load import load
    from slipscale.analysis.pipeline import analyse
    from slipscale.analysis.preprocessing.sessions import only_session
    from slipscale.analysis.reading import mapping as mappings

    progress("reading the data")
    paths = paths_of(args)
    LOG.info("reading %s", ", ".join(map(str, paths)))
    mapping = mapping_from(args)
    data = load(paths, mapping, task=args.task)
    if args.in_session:
        data = only_session(data, args.in_session)
    if args.map and mapping is not None:
        mappings.write_mapping(mapping, paths[0])
    return analyse(
        data,
        normalise=args.normalise,
        equivalence_ratio=args.equivalence,
        axis=args.axis,
        bayesian=args.bayesian,
        progress=progress,
    )


def run_analyse(args: Namespace) -> int:
    """Analyse a data set; print Table III and the output paths."""
    from slipscale.analysis.preregistration.bundle import read_bundle
    from slipscale.analysis.reporting.terminal import (
        print_answers,
        print_table3,
    )
    from slipscale.analysis.writing.output_folder import default_folder

    say(here())
    bundle = read_bundle(args.plan) if args.plan else None
    with telling(lines=args.steps) as progress:
        analysis = analysed(args, progress)
        if bundle is not None:
            analysis = held_against(bundle, analysis, args)
        data = analysis.dataset
        out = Path(args.out) if args.out else default_folder(data, paths_of(args)[0])
        if args.in_session and not args.out:
            out /= f"ses-{args.in_session}"  # separate from the results for all sessions
        if args.task and not args.out:
            out /= f"task-{args.task}"
        # Imported late, because importing Matplotlib takes a second.
        from slipscale.analysis.reporting.files import write_analysis

        report = write_analysis(analysis, out, progress, formats=args.figures)
    for sentence in analysis.problems:
        print(harmless(f"note: {sentence}"), file=sys.stderr)
    if args.json:
        print(
            data.quantity.columns(analysis.table3).to_json(
                orient="records", indent=2, double_precision=15
            )
        )
    else:
        print_table3(analysis)
        # Table III is the main result of magnitude estimation.
        print_answers(analysis, outside_only=analysis.prepared is not None)
        print(f"report: {report}")
    return tell_plan(analysis) or (ANSWER_IS_NO if data.left_out else DONE)


def held_against(bundle: Bundle, analysis: Analysis, args: Namespace) -> Analysis:
    """Compare an analysis with a frozen plan; return the analysis with its deviations."""
    from slipscale.analysis.cli.mapping_options import OTHERS
    from slipscale.analysis.preregistration.check import check_plan

    named = (*COLUMN_OPTIONS, "in_session", "task", *OTHERS)
    given = [f"--{name.replace('_', '-')}" for name in named if getattr(args, name)]
    return replace(analysis, plan=check_plan(bundle, analysis, given))


def tell_plan(analysis: Analysis) -> int:
    """Print all deviations from a plan; return exit status 1 if there are any, otherwise 0."""
    from slipscale.analysis.reporting.sections.plan import summary

    if analysis.plan is None:
        return DONE
    # Deviations are printed to stderr, because stdout may contain JSON.
    print(harmless(f"plan: {summary(analysis)}"), file=sys.stderr)
    for each in analysis.plan.deviations:
        print(harmless(f"deviation ({each.kind}): {each.what}"), file=sys.stderr)
    return ANSWER_IS_NO if analysis.plan.deviations else DONE


COMMANDS = {"analyse": (add_analyse, run_analyse)}
