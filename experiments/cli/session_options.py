"""Options that commands for sessions and pilots share, and the settings that they define."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.experiments.lab.defaults import here

if TYPE_CHECKING:
    from slipscale.experiments.running.contact_sources import ContactSpecs


def add_plate(parser: ArgumentParser) -> None:
    """Add the option that selects the plate."""
    default = here()
    whence = "the laboratory folder's" if default.file else "mock, which makes the run a pilot"
    parser.add_argument(
        "--plate",
        metavar="SPEC",
        default=default.plate,
        help=f"mock, serial:PORT or scpi:RESOURCE (default: {whence})",
    )


def add_setting(parser: ArgumentParser) -> None:
    """Add the options for a session's equipment other than the plate."""
    default = here()
    add_contact(parser)
    parser.add_argument(
        "--windowed",
        action="store_true",
        default=default.windowed,
        help="run in a window instead of full screen",
    )
    parser.add_argument(
        "--screen",
        type=int,
        default=default.screen,
        metavar="N",
        help=f"the participant's monitor (default: {default.screen})",
    )

    parser.add_argument(
        "--backup",
        type=Path,
        default=default.backup,
        metavar="DIR",
        help="folder on another disk to which the journal is copied at the end",
    )
    parser.add_argument(
        "--markers",
        action="append",
        metavar="SPEC",
        help="send event markers to recorders: lsl, lsl:NAME, serial:PORT or "
        "parallel:ADDRESS; may be repeated",
    )


def add_contact(parser: ArgumentParser) -> None:
    """Add the options that select the finger sensors."""
    parser.add_argument(
        "--position",
        metavar="SPEC",
        help="the finger-position sensor: mouse:mm_per_pixel=X, lasers:PORT, scripted:FILE, "
        "simulated or none (default: the laboratory folder's setting, otherwise the study's)",
    )
    parser.add_argument(
        "--force",
        metavar="SPEC",
        help="the finger-force sensor: load_cells:PORT, daq:..., ati:HOST,..., simulated or "
        "none (default: the laboratory folder's setting, otherwise the study's)",
    )


def contact_specs(args: Namespace) -> ContactSpecs:
    """Return the finger sensors given on the command line, or else in the laboratory folder."""
    return named_contact(args).otherwise(_folders_contact())


def named_contact(args: Namespace) -> ContactSpecs:
    """Return the finger sensors given on the command line, without defaults."""
    from slipscale.experiments.running.contact_sources import ContactSpecs

    return ContactSpecs(position=args.position, force=args.force)


def simulated_contact(args: Namespace) -> ContactSpecs:
    """Return the finger sensors for a pilot; those set in the laboratory folder are simulated."""
    from slipscale.experiments.running.contact_sources import simulated

    return named_contact(args).otherwise(simulated(_folders_contact()))


def _folders_contact() -> ContactSpecs:
    from slipscale.experiments.running.contact_sources import ContactSpecs

    defaults = here()
    return ContactSpecs(position=defaults.position, force=defaults.force)


def add_study(parser: ArgumentParser) -> None:
    """Add the argument that selects the study."""
    default = here().study
    parser.add_argument(
        "study",
        metavar="STUDY",
        nargs="?",
        default=default,
        help=f"a TOML file, or the name of a study that comes with Slipscale (default: {default})",
    )


def add_participant(parser: ArgumentParser, *, required: bool) -> None:
    """Add the options that select the participant, session and run."""
    add_study(parser)
    parser.add_argument(
        "--participant",
        required=required,
        metavar="01",
        help="the participant label: letters and digits, never a name",
    )
    parser.add_argument(
        "--session",
        default="",
        metavar="01",
        help="session label, if the study has several sessions",
    )
    parser.add_argument("--run", default="01", metavar="01", help="run number (default: 01)")
    default = here()
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help=f"folder of the data set (default: {default.out(pilot=False)}; for pilots "
        f"{default.out(pilot=True)})",
    )


def add_language(parser: ArgumentParser) -> None:
    """Add the option that selects the participants' language."""
    parser.add_argument(
        "--language",
        metavar="CODE",
        default=here().language,
        help="language of the text shown to participants (default: the study's language)",
    )


def add_unblind(parser: ArgumentParser) -> None:
    """Add the option that shows the amplitude."""
    parser.add_argument("--unblind", action="store_true", help="show the amplitude to the operator")
