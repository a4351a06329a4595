"""The command ``slipscale power``."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from analysis.cli.progress_line import telling
from experiments.lab.defaults import here, say
from faults import ANSWER_IS_NO, DONE

if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace
    from collections.abc import Callable


#: Participants of the smallest study whose power is asked for.
FEWEST = 3


def add_power(parser: ArgumentParser) -> None:
    """Fill the parser of ``slipscale power``."""
    parser.add_argument(
        "study",
        metavar="STUDY",
        nargs="?",
        default=here().study,
        help="a TOML file or a shipped study's name, for its amplitudes and repetitions",
    )
    parser.add_argument(
        "--sizes",
        metavar="N",
        type=int,
        nargs="+",
        default=[6, 8, 10, 12, 16, 20, 24, 32],
        help="numbers of participants to try (default: 6 to 32)",
    )
    parser.add_argument(
        "--repetitions", type=int, metavar="N", help="ratings a surface (default: the study's)"
    )
    parser.add_argument(
        "--studies",
        type=int,
        default=1000,
        metavar="N",
        help="simulated studies for each number (default: 1000)",
    )
    parser.add_argument(
        "--seed", type=int, default=2007, metavar="N", help="of the simulation (default: 2007)"
    )
    parser.add_argument("--alpha", type=float, default=0.05, help="level of tests, default: 0.05")
    parser.add_argument("--target", type=float, default=0.8, help="power asked for, default: 0.8")
    parser.add_argument(
        "--trial-to-trial",
        type=float,
        metavar="SHARE",
        help="share of the variance that repetitions average out (default: the population's)",
    )
    parser.add_argument("--json", action="store_true", help="print the table as JSON")


#: Option of ``power``: whether its values can be meant, and what was expected.
EXPECTED: dict[str, tuple[Callable[[Any], bool], str]] = {
    "sizes": (lambda sizes: min(sizes) >= FEWEST, f"{FEWEST} participants or more"),
    "repetitions": (lambda n: n is None or n >= 1, "1 or more"),
    "studies": (lambda n: n >= 1, "1 or more"),
    "seed": (lambda n: n >= 0, "0 or more"),
    "alpha": (lambda share: 0 < share < 1, "a share above 0 and below 1"),
    "target": (lambda share: 0 < share < 1, "a share above 0 and below 1"),
}


def refuse_nonsense(args: Namespace) -> None:
    """Refuse every value of ``power`` that cannot be meant, all in one sentence."""
    from faults import UserError  # noqa: PLC0415

    wrong = []
    for name, (meant, expected) in EXPECTED.items():
        value = getattr(args, name)
        if not meant(value):
            shown = " ".join(str(one) for one in value) if isinstance(value, list) else value
            wrong.append(f"--{name} {shown}: expected {expected}")
    if wrong:
        raise UserError("; ".join(wrong))


def run_power(args: Namespace) -> int:
    """Simulate studies of several sizes; 1 where none reaches the power asked for."""
    from analysis.planning.power import fewest, power_curve  # noqa: PLC0415
    from analysis.planning.terminal import print_power  # noqa: PLC0415
    from experiments.participants.population import Population  # noqa: PLC0415
    from experiments.study.file import read_study  # noqa: PLC0415
    from faults import UserError  # noqa: PLC0415

    refuse_nonsense(args)
    say(here())
    study, _ = read_study(args.study)
    estimation = [task for task in study.tasks if task.protocol == "magnitude_estimation"]
    if not estimation:
        raise UserError(f"{study.name}: no magnitude_estimation among its tasks; nothing to plan")
    repetitions = args.repetitions or int(getattr(estimation[0], "repetitions", 1))
    try:
        population = (
            Population()
            if args.trial_to_trial is None
            else Population(trial_to_trial=args.trial_to_trial)
        )
    except ValueError as error:
        raise UserError(
            f"--trial-to-trial {args.trial_to_trial}: expected a share from 0 to "
            f"{1 - Population().shared:g}, what the part shared by all amplitudes leaves"
        ) from error
    with telling() as progress:
        curve = power_curve(
            study.amplitudes_um_pp,
            sorted(set(args.sizes)),
            repetitions=repetitions,
            studies=args.studies,
            seed=args.seed,
            alpha=args.alpha,
            primary=study.analysis.primary,
            population=population,
            progress=progress,
        )
    enough = fewest(curve, args.target)
    if args.json:
        rows = [
            {
                "participants": point.participants,
                "omnibus": point.omnibus,
                "steps": [
                    {"from_um_pp": low, "to_um_pp": high, "power": share}
                    for (low, high), share in point.steps.items()
                ],
                "exponent_half_width": point.exponent_half_width,
            }
            for point in curve
        ]
        print(
            json.dumps(
                {
                    "enough": enough,
                    "target": args.target,
                    "primary": study.analysis.primary,
                    "sizes": rows,
                },
                indent=2,
            )
        )
    else:
        print_power(curve, args.target, enough, repetitions, primary=study.analysis.primary)
    return ANSWER_IS_NO if enough is None else DONE


COMMANDS = {"power": (add_power, run_power)}
