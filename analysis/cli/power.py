"""Implement ``slipscale power``."""

from __future__ import annotations

import json
import math
import re
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipscale.analysis.cli.compare_protocols import (
    add_comparison,
    compare_conditions,
    compare_protocols,
)
from slipscale.analysis.cli.population_options import add_population, chosen_population
from slipscale.analysis.cli.progress_line import add_steps, telling
from slipscale.experiments.lab.defaults import here, say
from slipscale.faults import ANSWER_IS_NO, DONE, UserError

if TYPE_CHECKING:
    from slipscale.analysis.planning.power.answers import Assurance
    from slipscale.analysis.planning.power.design import Design
    from slipscale.analysis.planning.power.run_grid import Part

#: Option -> description, and default if neither the study nor the population sets the value.
AXES = {
    "participants": "numbers of participants to try (default: 6,8,10,12,16,20,24,32)",
    "repetitions": "ratings per surface (default: as in the study file)",
    "effect": "factor by which the effect is multiplied; 0.5 halves the differences between mean "
    "sensations (default: 1)",
    "lapses": "proportion of answers given at random (default: as in the population)",
    "dropout": "proportion of people who stop before the end (default: as in the population)",
    "exponent": "exponent of a power function that gives the mean sensation at amplitudes above "
    "0 µm (default: the population's curve)",
    "catch_steps": "number of catch steps in each descending-difference series; more catch "
    "steps give a more precise estimate of the false-alarm rate",
}
STUDIES = 1000
SIZES = ("6,8,10,12,16,20,24,32",)


def add_power(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale power``."""
    parser.add_argument(
        "study",
        metavar="STUDY",
        nargs="?",
        default=here().study,
        help="study file (TOML), or name of a study that comes with Slipscale",
    )
    grid = parser.add_argument_group(
        "the grid",
        "options that take a list of values, such as 8,12 or 1 0.5, or a range such as 8:40:4; "
        "every combination is simulated",
    )
    for axis, meaning in AXES.items():
        grid.add_argument(f"--{axis.replace('_', '-')}", metavar="VALUES", nargs="+", help=meaning)
    grid.add_argument(
        "--order",
        metavar="RULES",
        nargs="+",
        help=(
            "rules for the order of surfaces (default: as in the study file), for example "
            "blocked,simple,williams"
        ),
    )
    add_comparison(parser)
    add_population(parser)
    parser.add_argument(
        "--studies",
        type=int,
        metavar="N",
        help="number of simulated studies per condition (default: 1000, or 50 for protocols and "
        "for thresholds by condition)",
    )
    parser.add_argument(
        "--seed", type=int, default=2007, metavar="N", help="random seed (default: 2007)"
    )
    parser.add_argument(
        "--alpha", type=float, default=0.05, help=("significance level (default: 0.05)")
    )
    parser.add_argument("--target", type=float, default=0.8, help=("required power (default: 0.8)"))
    parser.add_argument(
        "--assurance",
        metavar="MEAN,SD",
        help=(
            "also report the expected power for an uncertain effect, which is normally "
            "distributed with this mean and SD"
        ),
    )
    parser.add_argument(
        "--looks",
        type=int,
        default=1,
        metavar="N",
        help="number of interim analyses, including the final one; the study stops at the first "
        "significant result (default: 1)",
    )
    parser.add_argument(
        "--spending",
        choices=("obrien-fleming", "pocock"),
        default="obrien-fleming",
        help="alpha spending function for interim analyses (default: obrien-fleming)",
    )
    parser.add_argument(
        "--jobs", type=int, default=1, metavar="N", help=("number of processes (default: 1)")
    )
    parser.add_argument(
        "--cache",
        type=Path,
        metavar="DIR",
        help="folder in which finished parts are stored and reused",
    )
    parser.add_argument(
        "--shard",
        metavar="K/N",
        help="compute the K-th of N parts and store it in --cache, for array jobs; the last part, "
        "or the same command without --shard, prints the result",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help=("address of a Dask scheduler (requires slipscale[cluster])"),
    )
    parser.add_argument(
        "--yes", action="store_true", help=("allow computations that take more than an hour")
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    add_steps(parser)
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder for a page, figures, CSV and JSON files"
    )


#: Option -> check of its value, and description of valid values.
EXPECTED: dict[str, tuple[Callable[[Any], bool], str]] = {
    "studies": (lambda n: n is None or n >= 1, "1 or more"),
    "minutes": (lambda each: each is None or 0 < each < math.inf, "a number above 0"),
    "seed": (lambda n: n >= 0, "0 or more"),
    "alpha": (lambda share: 0 < share < 1, "a proportion above 0 and below 1"),
    "target": (lambda share: 0 < share < 1, "a proportion above 0 and below 1"),
    "looks": (lambda n: 1 <= n <= 20, "1 to 20"),  # noqa: PLR2004
    "jobs": (lambda n: n >= 1 or n == -1, "1 or more, or -1 for all processors"),
}


def refuse_nonsense(args: Namespace) -> None:
    """Report all invalid options of ``slipscale power`` in a single error."""
    wrong = []
    for name, (meant, expected) in EXPECTED.items():
        value = getattr(args, name)
        if not meant(value):
            wrong.append(f"--{name} {value}: expected {expected}")
    if args.minutes and not args.protocols:
        wrong.append(f"--minutes {args.minutes:g}: expected --protocols as well")
    if wrong:
        raise UserError("; ".join(wrong))


def axes_of(args: Namespace, design: Design) -> dict[str, tuple[Any, ...]]:
    """Return the option values whose combinations are simulated, keyed by option."""
    from slipscale.analysis.planning.power.grid import orders_of, values_of

    if args.catch_steps is not None and design.steps is None:
        raise UserError(
            "--catch-steps {catch_steps}: {study} has no descending difference task; omit "
            "--catch-steps, or use another study",
            catch_steps=" ".join(args.catch_steps),
            study=design.name,
        )
    habits = design.population.habits
    default: dict[str, tuple[Any, ...]] = {
        "participants": values_of("participants", SIZES),
        "repetitions": (design.task.repetitions,),
        "effect": (1.0,),
        "lapses": (habits.lapses,),
        "dropout": (habits.dropout,),
        "exponent": (0.0,),
        "catch_steps": (None,),
    }
    found = {
        axis: default[axis] if (given := getattr(args, axis)) is None else values_of(axis, given)
        for axis in AXES
    }
    return {**found, "order": (None,) if args.order is None else orders_of(args.order)}


def part_of(text: str | None, cache: Path | None) -> Part:
    """Parse ``--shard``: the part of the grid to compute in this run."""
    from slipscale.analysis.planning.power.run_grid import Part

    if text is None:
        return Part()
    found = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text)
    if not found or not 1 <= int(found[1]) <= int(found[2]):
        raise UserError("--shard {text}: expected K/N with K from 1 to N, such as 3/20", text=text)
    if cache is None:
        raise UserError(
            "--shard {text}: expected --cache too, with one folder for all shards", text=text
        )
    return Part(number=int(found[1]), of=int(found[2]))


def assurance_of(text: str | None) -> Assurance | None:
    """Parse the option ``--assurance``, which gives the mean and SD of the effect."""
    from slipscale.analysis.planning.power.answers import Assurance

    if text is None:
        return None
    try:
        mean, sd = (float(part) for part in text.split(","))
    except ValueError:
        mean = sd = math.nan
    if not (math.isfinite(mean) and math.isfinite(sd) and mean >= 0 and sd > 0):
        raise UserError(
            "--assurance {text}: expected a mean and a positive SD, such as 1,0.4", text=text
        )
    return Assurance(mean=mean, sd=sd)


def run_power(args: Namespace) -> int:
    """Simulate all combinations of options; return 1 if no sample size reaches the target power."""
    from slipscale.analysis.planning.power.answers import as_json, fewest, largest_effect, rows
    from slipscale.analysis.planning.power.design import design_of, estimation_of
    from slipscale.analysis.planning.power.grid import conditions, without_effect
    from slipscale.analysis.planning.power.page import write_power
    from slipscale.analysis.planning.power.run_grid import missing, run_grid, shards
    from slipscale.analysis.planning.power.shard import Looks
    from slipscale.analysis.planning.power.shard_cache import ShardCache
    from slipscale.analysis.planning.power.terminal import print_power
    from slipscale.experiments.study.file import read_study

    refuse_nonsense(args)
    say(here())
    study, text = read_study(args.study)
    if args.protocols or (study.factors and not estimation_of(study)):
        return compare_protocols(args) if args.protocols else compare_conditions(args, study)
    args.studies = args.studies or STUDIES
    assurance = assurance_of(args.assurance)
    population, fitted = chosen_population(args)
    if population.behaviour:
        raise UserError(
            "--population {population}: power uses only the parameters of a population, not the"
            " code of '{behaviour}'; expected a population without behaviour, or use slipscale "
            "pilot",
            population=args.population,
            behaviour=population.behaviour,
        )
    design = design_of(study, text, population, args.alpha)
    grid = conditions(axes_of(args, design))
    beside = without_effect(grid)
    if assurance:
        from dataclasses import replace

        effects = [effect for effect, _ in assurance.effects(largest_effect(design))]
        beside += [replace(each, effect=effect) for each in grid for effect in effects]
    for each in grid:
        each.people(population)  # Rejects effects beyond the scale before the computation starts.
    looks = Looks(number=args.looks, spending=args.spending)
    every = shards(
        design,
        list(dict.fromkeys([*grid, *beside])),
        studies=args.studies,
        seed=args.seed,
        looks=looks,
    )
    cache = ShardCache(args.cache) if args.cache else None
    part = part_of(args.shard, args.cache)
    ask_for_long(args, missing(every, cache), part)
    with showing(enabled=not args.json, steps=args.steps) as progress:
        outcomes = run_grid(
            every,
            jobs=args.jobs,
            cache=cache,
            part=part,
            scheduler=args.scheduler,
            progress=progress,
        )
    if left := missing(every, cache) if part.of > 1 else []:
        print(
            f"part {part.number} of {part.of} is in {args.cache}; {len(left)} of {len(every)} "
            "shards, which belong to other parts, are still missing"
        )
        return DONE
    found = rows(design, grid, outcomes, looks=looks, assurance=assurance)
    if args.json:
        print(json.dumps(as_json(design, found, args.target), indent=2))
    else:
        for line in fitted.sentences if fitted else ():
            print(line)
        print_power(design, found, args.target)
    if args.out:
        page = write_power(args.out, design, found, args.target)
        if not args.json:
            print(f"page    {page}")
    return DONE if any(fewest(found, args.target).values()) else ANSWER_IS_NO


def ask_for_long(args: Namespace, left: list[Any], part: Part) -> None:
    """Reject computations of more than an hour unless ``--yes`` is given."""
    from slipscale.analysis.planning.power.run_grid import HOUR_S, estimated_s

    if args.yes or args.scheduler:
        return
    jobs = args.jobs
    if jobs == -1:
        from os import cpu_count

        jobs = cpu_count() or 1
    seconds = estimated_s(left, jobs * part.of)
    if seconds > HOUR_S:
        raise UserError(
            "{count} parts of {studies} studies per condition take about {seconds:.1f} hours "
            "here; add --yes to compute them, or use --jobs, a smaller grid or fewer --studies",
            count=len(left),
            studies=args.studies,
            seconds=seconds / HOUR_S,
        )


@contextmanager
def showing(*, enabled: bool, steps: bool = False) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar with the remaining time if stderr is a terminal.

    If ``steps`` is True, print one line per finished part (such as ``step: 3/24``) for other
    programs.
    """
    if steps:
        with telling(lines=True) as reporter:
            yield lambda done, of: reporter(f"{done}/{of}")
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    console = Console(stderr=True)
    columns = (
        TextColumn("simulated studies"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, disable=not (enabled and console.is_terminal)) as bar:
        task = bar.add_task("", total=None)
        yield lambda done, of: bar.update(task, completed=done, total=of)


COMMANDS = {"power": (add_power, run_power)}
