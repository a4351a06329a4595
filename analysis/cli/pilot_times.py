"""Implement ``slipscale pilot --times N``: simulate a study N times to show how results vary."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.analysis.cli.population_options import chosen_population
from slipscale.experiments.lab.defaults import here, say
from slipscale.faults import DONE, UserError

if TYPE_CHECKING:
    from slipscale.analysis.planning.distribution.distribution import Distribution

#: Options of a single pilot that do not apply to repeated simulations.
OF_ONE = ("position", "force")
MOST = 1_000_000
#: Subfolder of the pilot folder for simulated distributions.
FOLDER = "distributions"


def add_times(parser: ArgumentParser) -> None:
    """Add the options for repeated simulations."""
    group = parser.add_argument_group(
        "many studies", "show how much the results may vary; see docs/how-to/planning.md"
    )
    group.add_argument(
        "--times",
        type=int,
        metavar="N",
        help="simulate the study N times, and report the median and the 5th and 95th percentiles "
        "of each result, and how often each conclusion holds (default for --out: a new folder in "
        "distributions/ in the pilot folder)",
    )
    group.add_argument(
        "--jobs",
        type=int,
        metavar="N",
        help="with --times, number of processes; -1 means one per processor (default: 1)",
    )
    group.add_argument(
        "--yes",
        action="store_true",
        help=("with --times, allow computations that take more than an hour"),
    )


def refuse_without_times(args: Namespace) -> None:
    """Reject the options for repeated simulations if only one study is simulated."""
    for name in ("jobs", "yes"):
        if getattr(args, name):
            raise UserError(
                "--{name} applies only to repeated simulations; add --times N", name=name
            )


def run_times(args: Namespace) -> int:
    """Simulate a study many times; print and save the distribution of its results."""
    jobs = 1 if args.jobs is None else args.jobs
    _refuse(args, jobs)
    from slipscale.analysis.cli.power import showing
    from slipscale.analysis.planning.distribution.distribution import distribution
    from slipscale.analysis.planning.distribution.many_studies import ManyStudies, results

    defaults = here()
    say(defaults)
    population, fitted = chosen_population(args)
    studies = ManyStudies(
        study_name=args.study,
        population=population,
        participants=args.participants,
        language=args.language,
        seed=args.seed,
    )
    studies.check()
    folder = _folder(args.out, defaults.pilots)
    found = []
    with showing(enabled=True) as show:
        for each in results(studies, args.times, jobs=jobs, patient=args.yes):
            found.append(each)
            show(len(found), args.times)
    for sentence in fitted.sentences if fitted else ():
        print(sentence)
    return _tell(distribution(studies, found), folder)


def _tell(found: Distribution, folder: Path) -> int:
    # Matplotlib takes a second to import, so the import is delayed until a figure is drawn.
    from slipscale.analysis.planning.distribution.files import write_distribution
    from slipscale.analysis.planning.distribution.terminal import print_distribution

    page = write_distribution(folder, found)
    print_distribution(found)
    print(f"page    {page}")
    return DONE


def _folder(out: Path | None, pilots: Path) -> Path:
    """Return the output folder, after checking that it contains no other files."""
    from slipscale.analysis.planning.distribution.files import claim
    from slipscale.experiments.running.pilot import next_folder

    folder = out or next_folder(pilots / FOLDER)
    claim(folder)
    return folder


def _refuse(args: Namespace, jobs: int) -> None:
    """Reject invalid options before slow imports."""
    if not 1 <= args.times <= MOST:
        raise UserError("--times {times}: expected 1 to {most}", times=args.times, most=MOST)
    if jobs != -1 and jobs < 1:
        raise UserError("--jobs {jobs}: expected 1 or more, or -1 for one per processor", jobs=jobs)
    if args.plate != "mock":
        raise UserError(
            "--plate {plate}: with --times, every simulated study uses a mock plate without "
            "faults; omit --plate, or --times",
            plate=args.plate,
        )
    for name in OF_ONE:
        if getattr(args, name):
            raise UserError(
                "--{name} {number}: with --times, every simulated study uses the value in the "
                "study file; omit --{name}, or --times",
                name=name,
                number=getattr(args, name),
            )
