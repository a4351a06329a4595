"""Implement ``slipscale analyse``."""

from __future__ import annotations

import json
import logging
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.analysis.cli.asking import asking
from slipscale.analysis.cli.mapping_arguments import add_mapping, mapping_from, meanings_in
from slipscale.analysis.cli.progress_line import add_steps, telling
from slipscale.experiments.lab.defaults import dataset_default, here, say
from slipscale.faults import ANSWER_IS_NO, DONE, UserError, harmless
from slipscale.figure_style.paper import STYLES, paper_style

if TYPE_CHECKING:
    from slipscale.analysis.preregistration.bundle import Bundle
    from slipscale.analysis.tasks.kind import Analysis


DESCRIPTION = "description.json"
LOG = logging.getLogger(__name__)


def add_analyse(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale analyse``."""
    add_data(parser)
    parser.add_argument(
        "--out",
        metavar="DIR",
        help=("folder for the results (default: DATASET/derivatives/slipscale)"),
    )
    parser.add_argument(
        "--json", action="store_true", help="print Table III, or the description, as JSON"
    )
    parser.add_argument(
        "--describe",
        action="store_true",
        help="only describe a table: its columns, the proposed options, and how many answers, "
        "people and levels they give; with --out, write description.json there (exit status 1 if "
        "the table cannot be read with the options)",
    )
    parser.add_argument(
        "--figures",
        nargs="+",
        choices=("svg", "png", "pdf"),
        default=(),
        metavar="FORMAT",
        help="figure formats in addition to svg: png, pdf or both (default: svg, and fig15.png)",
    )
    parser.add_argument(
        "--width",
        metavar="WIDTH",
        help="also write figures for a paper to the folder figures of the results: SVG, PDF and "
        "PNG (600 dpi) with this width, such as 8.9cm or 3.5in, and text of 7 to 9 pt",
    )
    parser.add_argument(
        "--style",
        choices=tuple(STYLES),
        help="also write figures for a paper in the style ieee (8.9 cm wide) or apa (8.25 cm wide, "
        "without grid lines); --width replaces the width",
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

    rules, axes = get_args(Normalisation), get_args(Axis)
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
        # The beginning of a name is enough: "log".
        type=lambda word: next((each for each in axes if word and each.startswith(word)), word),
        choices=axes,
        help="axis of all threshold curves (default: as in the study file, otherwise logarithmic "
        "for forced choice and linear for yes-no answers and comparisons)",
    )
    parser.add_argument(
        "--bayesian",
        action="store_true",
        help="also fit a hierarchical Bayesian power function with individual exponents, which "
        "takes half a minute and requires pip install 'slipscale[bayes]'",
    )


def paths_of(args: Namespace) -> list[Path]:
    """Return the paths of the data set."""
    given = args.dataset
    return [Path(path) for path in (given if isinstance(given, list) else [given])]


def analysed(args: Namespace, progress: Callable[[str], None]) -> Analysis:
    """Read and analyse the data specified by the options."""
    from slipscale.analysis.load import load
    from slipscale.analysis.pipeline import analyse
    from slipscale.analysis.preprocessing.sessions import only_session
    from slipscale.analysis.reading.foreign.proposal import proposal_for
    from slipscale.analysis.reading.meaning import mapping as mappings
    from slipscale.analysis.reading.own_results import OwnResults

    progress("reading the data")
    paths = paths_of(args)
    LOG.info("reading %s", ", ".join(map(str, paths)))
    mapping = mapping_from(args)
    try:
        data = load(paths, mapping, task=args.task)
    except OwnResults:
        raise
    except UserError:
        unstated = mapping is None or set(meanings_in(args)) == {"sheet"}
        if unstated and (found := proposal_for(paths, args.sheet)) is not None:
            print(harmless(str(found)))
            raise found.refusal from None
        raise
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
    """Analyse a data set; print Table III and the output paths. Or only describe a table."""
    return _describe(args) if args.describe else asking(args, _run)


def _describe(args: Namespace) -> int:
    from slipscale.analysis.cli.describing import describe
    from slipscale.analysis.writing.output_folder import make_folder
    from slipscale.experiments.dataset.files import write_file

    found = describe(paths_of(args), meanings_in(args))
    data = found.as_json()
    if args.out:
        make_folder(Path(args.out))
        write_file(Path(args.out, DESCRIPTION), data)
    print(json.dumps(data, indent=2) if args.json else harmless(str(found)))
    return ANSWER_IS_NO if found.fault else DONE


def _run(args: Namespace) -> int:
    from slipscale.analysis.preregistration.bundle import read_bundle
    from slipscale.analysis.reporting.terminal import (
        print_answers,
        print_table3,
    )
    from slipscale.analysis.writing.output_folder import default_folder

    say(here())
    bundle = read_bundle(args.plan) if args.plan else None
    paper = paper_style(args.width, args.style)
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
        from slipscale.analysis.reporting.files import FOR_PAPER, write_analysis

        report = write_analysis(analysis, out, progress, formats=args.figures, paper=paper)
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
        if paper is not None:
            print(f"figures for a paper: {report.parent / FOR_PAPER}")
    return tell_plan(analysis) or (ANSWER_IS_NO if data.left_out else DONE)


def held_against(bundle: Bundle, analysis: Analysis, args: Namespace) -> Analysis:
    """Compare an analysis with a frozen plan; return the analysis with its deviations."""
    from slipscale.analysis.preregistration.check import check_plan
    from slipscale.analysis.reading.meaning.keywords import MEANINGS

    named = ("in_session", "task", *MEANINGS)
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
