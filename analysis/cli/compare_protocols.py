"""Compare protocols, or thresholds between a study's conditions, for ``slipscale power``."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from typing import TYPE_CHECKING

from slipscale.analysis.cli.population_options import chosen_population
from slipscale.faults import ANSWER_IS_NO, DONE, UserError

if TYPE_CHECKING:
    from slipscale.experiments.study.model import Study

#: Number of simulated studies per protocol: few, because answers are simulated step by step.
STUDIES = 50
WIDTH = 170
#: Default numbers of participants to compare.
SIZES = ("12",)
#: Options of ``power`` that cannot be combined with a comparison -> default value.
OTHERS = {
    **dict.fromkeys(("repetitions", "effect", "lapses", "dropout", "exponent")),
    **dict.fromkeys(("catch_steps", "order", "assurance", "cache", "shard", "scheduler")),
    "looks": 1,
}


def add_comparison(parser: ArgumentParser) -> None:
    """Add the options for comparing protocols."""
    parser.add_argument(
        "--protocols",
        metavar="STUDY",
        nargs="+",
        help="compare how precisely STUDY and these studies estimate an exponent or threshold, "
        "with the same people and duration",
    )
    parser.add_argument(
        "--minutes",
        type=float,
        metavar="M",
        help="duration per participant in minutes, with --protocols (default: as in STUDY)",
    )


def compare_protocols(args: Namespace) -> int:
    """Compare the precision of several studies and print the result."""
    from slipscale.analysis.planning.power.grid import values_of
    from slipscale.analysis.planning.protocols.output import (
        as_json,
        sentences,
        table,
        write_comparison,
    )
    from slipscale.analysis.planning.protocols.precision import protocol_precision
    from slipscale.analysis.planning.protocols.studies import filling, protocol_study

    _refuse_others(args, "--protocols")
    sizes = values_of("participants", args.participants or SIZES)
    population, fitted = chosen_population(args)
    known = [protocol_study(name) for name in dict.fromkeys([args.study, *args.protocols])]
    minutes = args.minutes or known[0].minutes(population)
    filled = [filling(study, minutes, population) for study in known]
    found = [
        row
        for study in filled
        for row in protocol_precision(
            study,
            sizes,
            studies=args.studies or STUDIES,
            seed=args.seed,
            population=population,
            jobs=args.jobs,
        )
    ]
    if args.json:
        print(json.dumps(as_json(found, minutes), indent=2))
    else:
        for line in fitted.sentences if fitted else ():
            print(line)
        _show(table(found), sentences(found, minutes, population.name))
    if args.out:
        figure = write_comparison(args.out, found, minutes)
        if not args.json:
            print(f"figure  {figure}")
    return DONE


def compare_conditions(args: Namespace, study: Study) -> int:
    """Print the power to detect differences in thresholds between the levels of factors."""
    from slipscale.analysis.planning.power.grid import values_of
    from slipscale.analysis.planning.protocols.conditions import (
        HEAD,
        cells,
        condition_power,
        enough,
        sentences,
    )
    from slipscale.analysis.planning.protocols.output import write_rows
    from slipscale.analysis.planning.protocols.studies import protocol_study
    from slipscale.experiments.participants.simulated_people.growth import people_for

    _refuse_others(args, "the thresholds of a study's conditions")
    population, fitted = chosen_population(args)
    people = people_for(study, population)
    found = condition_power(
        protocol_study(args.study),
        values_of("participants", args.participants or SIZES),
        studies=args.studies or STUDIES,
        seed=args.seed,
        population=people,
        alpha=args.alpha,
        jobs=args.jobs,
    )
    rows = list(map(cells, found))
    if args.json:
        print(json.dumps([dict(zip(HEAD, row, strict=True)) for row in rows], indent=2))
    else:
        texts = [
            [f"{each:.3g}" if isinstance(each, float) else str(each) for each in row]
            for row in rows
        ]
        notes = (*(fitted.sentences if fitted else ()), *sentences(found, people, args.target))
        _show([HEAD, *texts], notes)
    if args.out:
        write_rows(args.out, "conditions", HEAD, rows)
    sizes = enough(found, people, args.target).values()
    return DONE if sizes and all(sizes) else ANSWER_IS_NO


def _show(table: Sequence[Sequence[str]], sentences: Sequence[str]) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    head, *rows = table
    shown = Table(box=box.SIMPLE_HEAD)
    for title in head:
        shown.add_column(title, no_wrap=True)
    for row in rows:
        shown.add_row(*row)
    console = Console()
    # On a narrow terminal, lines wrap instead of truncating numbers.
    console.width = max(console.width, WIDTH)
    console.print(shown)
    for line in sentences:
        console.print(line, highlight=False, markup=False)


def _refuse_others(args: Namespace, what: str) -> None:
    """Reject options that would have no effect in a comparison."""
    given = [name for name, default in OTHERS.items() if getattr(args, name) != default]
    if given:
        raise UserError(
            "--{option} cannot be combined with {what}; expected only --participants, "
            "--minutes, --population, --studies and --seed",
            option=given[0].replace("_", "-"),
            what=what,
        )
