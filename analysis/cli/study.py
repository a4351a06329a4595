"""Implement ``slipscale study freeze``, and add it to the other ``slipscale study`` actions."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from slipscale.analysis.cli.population_options import add_population, chosen_population
from slipscale.experiments.cli import study
from slipscale.experiments.lab.defaults import here, say
from slipscale.faults import DONE, UserError, harmless

#: Multiples of the planned number of participants for which to compute power.
AROUND = (0.5, 0.75, 1.0, 1.25)


def add_study(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale study``."""
    commands = study.add_study(parser)
    freeze = commands.add_parser(
        "freeze",
        help="freeze a study and its analysis plan before data are collected",
        epilog="example: slipscale study freeze matching --out plan",
    )
    freeze.add_argument("study", metavar="STUDY", nargs="?", default=here().study, help=study.WHICH)
    freeze.add_argument(
        "--out",
        type=Path,
        metavar="BUNDLE",
        required=True,
        help="new folder, or new file that ends in .zip",
    )
    freeze.add_argument(
        "--power",
        type=Path,
        metavar="DIR",
        help="include a power analysis: the folder written by slipscale power --out",
    )
    freeze.add_argument(
        "--compute-power",
        type=int,
        metavar="STUDIES",
        help="compute and include the power for 1/2, 3/4, 1 and 5/4 of the planned participants, "
        "with N simulated studies each",
    )
    freeze.add_argument(
        "--notes",
        type=Path,
        metavar="FILE",
        help="include a text file with hypotheses and other statements that are not in the study "
        "file",
    )
    freeze.add_argument(
        "--stopping",
        metavar="TEXT",
        default="",
        help="rule for ending data collection (default: after the planned number of participants)",
    )
    freeze.add_argument(
        "--existing-data",
        metavar="TEXT",
        default="",
        help="which data already exist, and what you know about them; required by registries",
    )
    freeze.add_argument(
        "--sample-size",
        metavar="TEXT",
        default="",
        help="why the planned number of participants is enough; required by registries",
    )
    add_population(freeze)


def run_study(args: Namespace) -> int:
    """Freeze a study, or run another action of ``slipscale study``."""
    return _freeze(args) if args.what == "freeze" else study.run_study(args)


def _freeze(args: Namespace) -> int:
    """Write the frozen plan; print its path and SHA-256."""
    import tempfile

    from slipscale.analysis.preregistration.bundle import refuse_taken

    say(here())
    refuse_taken(args.out)
    if args.compute_power is None:
        return _written(args, args.power)
    if args.power:
        raise UserError(
            "--power and --compute-power both provide a power analysis; expected only one of them"
        )
    with tempfile.TemporaryDirectory(prefix="slipscale-") as temporary:
        folder = Path(temporary) / "power"
        _compute_power(args, folder)
        return _written(args, folder)


def _compute_power(args: Namespace, folder: Path) -> None:
    """Compute power for sample sizes around the planned one, as in ``slipscale power``."""
    from slipscale.analysis.cli.power import add_power, run_power
    from slipscale.analysis.planning.power.grid import FEWEST_PARTICIPANTS
    from slipscale.experiments.study.file import read_study
    from slipscale.faults.parser import Parser

    planned = read_study(args.study)[0].participants
    sizes = sorted({max(round(planned * part), FEWEST_PARTICIPANTS) for part in AROUND})
    words = [args.study, "--participants", ",".join(map(str, sizes)), "--out", str(folder)]
    words += ["--studies", str(args.compute_power)]
    words += ["--population", args.population] if args.population else []
    words += ["--from", str(args.dataset)] if args.dataset else []
    parser = Parser(prog="slipscale power")
    add_power(parser)
    run_power(parser.parse_args(words))


def _written(args: Namespace, power: Path | None) -> int:
    from datetime import UTC, datetime

    from slipscale.analysis.cli.progress_line import telling
    from slipscale.analysis.preregistration.bundle import write_bundle
    from slipscale.analysis.preregistration.freeze import Wanted, freeze

    population, fitted = chosen_population(args)
    with telling() as progress:
        progress("simulating and analysing the study once")
        plan, files = freeze(
            Wanted(
                study_name=args.study,
                population=population,
                stopping_rule=args.stopping,
                existing_data=args.existing_data,
                sample_size=args.sample_size,
                power=power,
                notes=args.notes,
            ),
            datetime.now(UTC),
        )
        write_bundle(args.out, files)
    for sentence in fitted.sentences if fitted else ():
        print(harmless(sentence))
    named = [file for file in plan.files if file.role == "named by the study"]
    for file in named:
        print(harmless(f"includes {file.path}, named by {file.named_by} in the study file"))
    print(f"frozen  {args.out}: {plan.participants} participants, {len(plan.files) + 1} files")
    print(f"SHA-256 {plan.digest}")
    return DONE


COMMANDS = {"study": (add_study, run_study)}
