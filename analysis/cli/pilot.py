"""Implement ``slipscale pilot``: simulate a study, then analyse it."""

from __future__ import annotations

import shlex
from argparse import ArgumentParser, Namespace
from pathlib import Path

from slipscale.analysis.cli.pilot_times import add_times, refuse_without_times, run_times
from slipscale.analysis.cli.population_options import add_population, chosen_population
from slipscale.experiments.cli.session_options import add_contact, add_study, simulated_contact
from slipscale.experiments.lab.defaults import here, say
from slipscale.faults import DONE

PLATE = "mock"


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale pilot``."""
    add_study(parser)
    parser.add_argument(
        "--participants",
        type=int,
        metavar="N",
        help=("number of participants (default: as in the study file)"),
    )
    parser.add_argument(
        "--seed",
        type=int,
        metavar="N",
        help=("random seed for orders and answers (default: as in the study file)"),
    )
    default = here()
    parser.add_argument(
        "--language",
        metavar="CODE",
        default=default.language,
        help="language of the screens (default: as in the study file)",
    )
    add_population(parser)
    parser.add_argument(
        "--plate",
        default=PLATE,
        metavar="SPEC",
        help="specification of the mock plate, with its options (default: mock)",
    )
    add_contact(parser)
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help=f"folder for the data set (default: a new folder in {default.pilots}/)",
    )
    add_times(parser)


def run(args: Namespace) -> int:
    """Run and analyse a pilot, and print its Table III next to the published one."""
    if args.times is not None:
        return run_times(args)
    refuse_without_times(args)
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    from slipscale.experiments.running.pilot import next_folder, pilot_plans, run_pilot

    defaults = here()
    say(defaults)
    population, fitted = chosen_population(args)
    plans = pilot_plans(
        args.study,
        participants=args.participants,
        seed=args.seed,
        language=args.language,
        population=population,
    )
    folder = args.out or next_folder(defaults.pilots)
    console, progress_console = Console(), Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    try:
        with Progress(*columns, console=progress_console) as progress:
            bar = progress.add_task("simulated participants", total=len(plans))
            run_pilot(
                folder,
                plans,
                spec=args.plate,
                contact=simulated_contact(args),
                tell=lambda _: progress.advance(bar),
            )
            work = progress.add_task("analysis", total=None)
            # Imported late: importing pandas, SciPy and Matplotlib takes a moment.
            from slipscale.analysis.pipeline import OutsideTasks, analyse
            from slipscale.analysis.reporting.files import write_analysis
            from slipscale.analysis.reporting.terminal import (
                print_answers,
                print_table3,
            )
            from slipscale.analysis.writing.output_folder import default_folder

            try:
                analysis = analyse(folder)
            except OutsideTasks as nothing:
                progress.update(work, total=1, completed=1)
                sentences = ("Simulated study: no person took part.", f"data set  {folder}")
                for sentence in (*sentences, f"The data were not analysed: {nothing}"):
                    console.print(sentence, markup=False, highlight=False, soft_wrap=True)
                return DONE
            report = write_analysis(analysis, default_folder(analysis.dataset, folder))
            progress.update(work, total=1, completed=1)
    except KeyboardInterrupt:
        # Printed on one line so that it can be copied, and without markup because paths may contain
        # markup characters.
        command = repeated(args, folder)
        console.print(f"Nothing is lost. To continue: {command}", markup=False, soft_wrap=True)
        raise
    console.print("\n[bold]Simulated study: no person took part.[/]")
    for sentence in fitted.sentences if fitted else ():
        console.print(sentence, markup=False, highlight=False)
    print_table3(analysis, console)
    print_answers(analysis, console)
    written = [("report", report)]
    if analysis.prepared is not None:
        written.insert(0, ("figure", report.parent / "fig15.svg"))
    for name, path in written:
        console.print(f"{name}  {path}", highlight=False, markup=False, soft_wrap=True)
    return DONE


def repeated(args: Namespace, folder: Path) -> str:
    """Return the full command for completing an interrupted pilot."""
    given = {
        "--participants": args.participants,
        "--seed": args.seed,
        "--language": args.language,
        "--population": args.population,
        "--from": args.dataset,
        "--plate": None if args.plate == PLATE else args.plate,
        "--position": args.position,
        "--force": args.force,
        "--out": folder,
    }
    words = [str(word) for pair in given.items() if pair[1] is not None for word in pair]
    return shlex.join(["slipscale", "pilot", args.study, *words])


COMMANDS = {"pilot": (add_arguments, run)}
