"""Check the packages, programs, ports and folders that a command requires before it runs.

Devices may be specified on the command line, in the journal of a resumed run, in the laboratory
folder, in the study file or in the plate file.
"""

from __future__ import annotations

import os
import shutil
import sys
from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path

from slipscale.experiments.lab.defaults import here
from slipscale.faults import UserError
from slipscale.faults.extras import how_to_install

ANALYSIS = ("pandas", "pingouin", "statsmodels", "joblib")


@dataclass(frozen=True, slots=True)
class Need:
    """A requirement of a command, either always or only with a certain option.

    ``command`` includes the subcommand, if there is one. ``option`` is a key in the result of
    `options_of`, or "" if the requirement does not depend on an option. ``value`` is the option's
    value to which the requirement applies, or "" for any value. If the option is the SPEC of a
    device, ``value`` is the driver's name.
    """

    command: str
    modules: tuple[str, ...] = ()
    option: str = ""
    value: str = ""
    programs: tuple[str, ...] = ()

    def applies(self, options: Mapping[str, object]) -> bool:
        """Return whether the requirement applies to the given options."""
        given = options.get(self.option) if self.option else True
        if not self.value:
            return bool(given)
        values = [given] if isinstance(given, str) else given
        return isinstance(values, list | tuple) and any(
            str(each).partition(":")[0] == self.value for each in values
        )


#: Possible drivers for each option that takes a SPEC, with the module that each driver imports.
DRIVERS = {
    "plate": {"serial": "serial", "scpi": "pyvisa", "sound": "sounddevice"},
    "markers": {"lsl": "pylsl", "serial": "serial"},
    "position": {"lasers": "serial"},
    "force": {"load_cells": "serial", "daq": "nidaqmx"},
}
SESSIONS = ("run", "check", "next", "resume")
#: Options of each command that take a SPEC.
WITH_DEVICES = dict.fromkeys(SESSIONS, tuple(DRIVERS)) | dict.fromkeys(
    ("plate watch", "plate calibrate", "plate conform"), ("plate",)
)

NEEDS = (
    *(
        Need(name, ANALYSIS)
        for name in ("analyse", "export", "pilot", "power", "reproduce", "study freeze")
    ),
    Need("analyse", ("numpyro", "jax"), "bayesian"),
    Need("export", ("numpyro", "jax"), "bayesian"),
    Need("export", ("docx",), "forms", "word"),
    Need("export", ("weasyprint",), "forms", "pdf"),
    Need("export", ("pyreadstat",), "forms", "spss"),
    Need("power", ("distributed",), "scheduler"),
    Need("run", ("psychopy",)),
    Need("check", ("psychopy", "sounddevice")),
    Need("next", ("psychopy",)),
    Need("resume", ("psychopy",), "answered_by", "person"),
    Need("lab", ("starlette", "uvicorn")),
    Need("plate list", ("serial",)),
    Need("plate design", ("skfem",)),
    Need("plate emulate", option="firmware", programs=("cc",)),
    *(
        Need(command, (module,), option, driver)
        for command, options in WITH_DEVICES.items()
        for option in options
        for driver, module in DRIVERS[option].items()
    ),
)

#: Options for output folders or files of each command.
WRITES = {
    "analyse": ("out",),
    "export": ("out",),
    "pilot": ("out",),
    "power": ("out", "cache"),
    "reconstruct": ("out", "html"),
    "reproduce": ("out",),
    "run": ("out", "backup"),
    "next": ("out", "backup"),
    "resume": ("out", "backup"),
    "data merge": ("out",),
    "study freeze": ("out",),
    "study show": ("figure",),
    "study texts": ("out",),
    "plate calibrate": ("out",),
    "plate design": ("out",),
}


#: Output folder or file of each command if --out is omitted.
WITHOUT_OUT: dict[str, Callable[[Namespace], Path | None]] = {
    "analyse": lambda args: _folder_of(args.dataset),
    "pilot": lambda _: here().pilots,
    "run": lambda args: here().out(pilot=args.pilot),
    "next": lambda args: here().out(pilot=args.pilot),
    "resume": lambda args: args.journal,
}


def _folder_of(dataset: Path | Sequence[str]) -> Path:
    """Return the folder of a data set, or of the first of several tables."""
    first = dataset if isinstance(dataset, Path) else Path(dataset[0])
    return first if first.is_dir() else first.parent


def check(name: str, args: Namespace) -> None:
    """Check the requirements of a command.

    Parameters
    ----------
    name : str
        Name of the command.
    args : Namespace
        Parsed arguments; ``what`` is the subcommand.

    Raises
    ------
    UserError
        If a package or program is missing, a port cannot be opened, or a folder cannot be written.
    """
    what = getattr(args, "what", None)
    command = f"{name} {what}" if what else name
    options = options_of(command, args)
    needs = [need for need in NEEDS if need.command == command and need.applies(options)]
    wrong = list(_missing_packages(module for need in needs for module in need.modules))
    wrong += [
        f"needs the program '{program}'; install it, or add its folder to PATH"
        for need in needs
        for program in need.programs
        if shutil.which(program) is None
    ]
    wrong += _forbidden_ports(command, options)
    for where, path in _written(command, args, options):
        if fault := unwritable(path):
            wrong.append(f"{where}: {fault}")
    if wrong:
        raise UserError("; ".join(wrong))


def options_of(command: str, args: Namespace) -> dict[str, object]:
    """Return the options of a command, including defaults that are not on the command line.

    For commands that use devices, options missing from the command line are taken from the first of
    these sources that contains them: the interrupted run, the laboratory folder, the study, the
    plate file.

    Raises
    ------
    UserError
        If the laboratory folder's settings or the journal cannot be read.
    """
    options = asdict(here()) if command in WITH_DEVICES else {}
    if command == "resume" and args.journal and args.journal.is_file():
        from slipscale.experiments.journal import plan_and_progress as progress
        from slipscale.experiments.running.contact_sources import of_records

        records = progress.read_plan(args.journal)[1]
        options |= {
            **asdict(of_records(records)),
            "plate": progress.last_plate(records),
            "markers": progress.last_markers(records),
            "answered_by": progress.answered_by(records),
        }
    options |= {name: value for name, value in vars(args).items() if value}
    if command in SESSIONS and command != "resume":
        options |= _sources(options)
    return options


def _sources(options: Mapping[str, object]) -> dict[str, object]:
    """Return the SPECs of a session's sensors, including those in the study or plate file."""
    from slipscale.experiments.running import contact_sources as contact
    from slipscale.experiments.study.file import read_study
    from slipscale.hardware.address import plate_file_of, with_plate_file

    named = {kind: str(options[kind]) for kind in ("position", "force") if options.get(kind)}
    specs = contact.ContactSpecs(**named)
    with suppress(UserError):  # The command itself reports errors in these files.
        study, _ = read_study(str(options["study"]))
        specs = specs.otherwise(contact.of_study(study))
        plate = plate_file_of(with_plate_file(str(options["plate"]), study.plate.file))
        specs = specs.otherwise(contact.of_plate(plate))
    return asdict(specs)


def _forbidden_ports(command: str, options: Mapping[str, object]) -> Iterator[str]:
    """Yield a sentence for each port that the user has no permission to open."""
    for option in WITH_DEVICES.get(command, ()):
        given = options.get(option)
        specs = [given] if isinstance(given, str) else given
        for spec in specs if isinstance(specs, list | tuple) else ():
            driver, _, address = str(spec).partition(":")
            port = Path(address.partition(",")[0])
            serial = DRIVERS[option].get(driver) == "serial"
            if serial and port.exists() and not os.access(port, os.R_OK | os.W_OK):
                from slipscale.hardware.errors import NoPermission

                remedy = NoPermission.remedy.rstrip(".")
                yield f"--{option} {spec}: no permission to open {port}. {remedy}"


def _written(
    command: str, args: Namespace, options: Mapping[str, object]
) -> Iterator[tuple[str, Path]]:
    """Yield the name in messages and the path of each output of a command."""
    for option in WRITES.get(command, ()):
        if given := options.get(option):
            yield f"--{option} {given}" if option in args else str(given), Path(str(given))
        elif option == "out" and command in WITHOUT_OUT and (path := WITHOUT_OUT[command](args)):
            yield str(path), path


def _missing_packages(modules: Iterable[str]) -> list[str]:
    """Return one sentence for each extra with missing packages."""
    sentences: dict[str, str] = {}
    for module in modules:
        if not is_installed(module):
            sentence = how_to_install(module) or f"needs the package '{module}'"
            sentences.setdefault(sentence.rpartition("; ")[2], sentence)
    return list(sentences.values())


def is_installed(module: str) -> bool:
    """Return whether a module is installed, without importing it."""
    from importlib.util import find_spec

    return sys.modules.get(module) is not None or find_spec(module) is not None


def unwritable(path: Path) -> str:
    """Return the reason why a path cannot be written, or an empty string if it can be written.

    The nearest existing folder is checked, because missing folders are created later.
    """
    folder = path
    try:
        while not folder.exists() and folder != folder.parent:
            folder = folder.parent
    except OSError as error:
        return f"cannot be reached ({error.strerror}); name another folder"
    if folder != path and not folder.is_dir():
        return f"{folder} is a file; name a folder"
    if folder.is_symlink() and ("annex", "objects") in pairwise(folder.readlink().parts):
        return f"{folder} is locked by git-annex; unlock it first: git annex unlock {folder}"
    if not os.access(folder, os.W_OK):
        return f"no permission to write to {folder}; change its permissions, or name another folder"
    return ""
