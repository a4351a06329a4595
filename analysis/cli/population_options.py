"""Define the options for the simulated population, which `pilot` and `power` share."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.planning.fitted_population import FittedPopulation
    from slipscale.experiments.participants.simulated_people.population import Population


def add_population(parser: ArgumentParser) -> None:
    """Add ``--population`` and ``--from``."""
    parser.add_argument(
        "--population",
        metavar="NAME",
        help="simulated people: biet2007 (default), realistic (with human habits), a TOML file, "
        "or a population from an installed package",
    )
    parser.add_argument(
        "--from",
        dest="dataset",
        type=Path,
        metavar="DATASET",
        help=(
            "simulate people who resemble a data set's participants, and report which parameters "
            "were fitted and which were assumed"
        ),
    )


def chosen_population(args: Namespace) -> tuple[Population, FittedPopulation | None]:
    """Return the simulated population and, if it was fitted to data, details of the fit."""
    from slipscale.experiments.participants.simulated_people.population import (
        Population,
        read_population,
    )

    if args.dataset is None:
        return read_population(args.population) if args.population else Population(), None
    if args.population:
        raise UserError(
            "--population and --from both define the simulated people; expected only one of them"
        )
    from slipscale.analysis.pipeline import analyse
    from slipscale.analysis.planning.fitted_population import fit_population

    fitted = fit_population(analyse(args.dataset))
    return fitted.population, fitted
