"""Run the command line, and import each command only when it is called.

The module of a command contains a dict ``COMMANDS``, which maps the name of the command to a pair
of functions ``(add_arguments, run)``. The function ``add_arguments`` adds arguments to a parser.
The function ``run`` takes the parsed arguments and returns the exit status.
"""

from __future__ import annotations

import os
import sys

from slipscale import __version__
from slipscale.faults import (
    ANSWER_IS_NO,
    DONE,
    INTERRUPTED,
    RIG_FAULT,
    USER_FAULT,
    RigError,
    UserError,
    harmless,
)

TYPE_CHECKING = False  # importing typing takes milliseconds
if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Callable

    from slipscale.faults.parser import Parser

# Module, description and example of each command, by group.
GROUPS: dict[str, dict[str, tuple[str, str, str]]] = {
    "Sessions": {
        "check": (
            "slipscale.experiments.cli.sessions",
            "check study, plate, display, sound and disk before the participant arrives",
            "slipscale check matching --windowed",
        ),
        "run": (
            "slipscale.experiments.cli.sessions",
            "run a participant's session in PsychoPy",
            "slipscale run matching --participant 01 --windowed",
        ),
        "resume": (
            "slipscale.experiments.cli.sessions",
            "resume an interrupted run; without a journal, list the interrupted runs",
            "slipscale resume",
        ),
        "note": (
            "slipscale.experiments.cli.lab",
            "write an operator's note into the running session's journal",
            "slipscale note plate cleaned",
        ),
    },
    "Data and results": {
        "analyse": (
            "slipscale.analysis.cli.analyse",
            "compute tables, figures and the report of a data set",
            "slipscale analyse data",
        ),
        "export": (
            "slipscale.analysis.cli.export",
            "write the report for Word, PDF and R",
            "slipscale export data --out export",
        ),
        "data": (
            "slipscale.experiments.cli.data",
            "build, verify and merge data sets, and withdraw participants",
            "slipscale data verify data",
        ),
        "reproduce": (
            "slipscale.analysis.cli.reproduce",
            "compare the paper's tables and figures with ours",
            "slipscale reproduce table3",
        ),
        "reconstruct": (
            "slipscale.analysis.cli.reconstruct",
            "find every raw data set consistent with a published table",
            "slipscale reconstruct biet2007_table3",
        ),
    },
    "Planning": {
        "pilot": (
            "slipscale.analysis.cli.pilot",
            "simulate a whole study without a plate or screen, then analyse it",
            "slipscale pilot matching --participants 4",
        ),
        "power": (
            "slipscale.analysis.cli.power",
            "compute how many participants a study needs",
            "slipscale power --participants 6,12 --studies 20",
        ),
        "study": (
            "slipscale.analysis.cli.study",
            "study files: new, show, validate, freeze, texts, schema",
            "slipscale study validate matching",
        ),
    },
    "Rig and laboratory": {
        "setup": (
            "slipscale.experiments.cli.setup",
            "install what sessions require, without 1 GB that PsychoPy brings and nobody uses",
            "slipscale setup session",
        ),
        "plate": (
            "slipscale.experiments.cli.plate",
            "the plate: list, new, sign, calibrate, watch, emulate, conform, design",
            "slipscale plate watch mock --seconds 1",
        ),
        "lab": (
            "slipscale.experiments.cli.lab",
            "open the console of a laboratory folder (created by lab init)",
            "slipscale lab init our-lab --study matching",
        ),
        "next": (
            "slipscale.experiments.cli.lab",
            "in a laboratory folder: run the next participant's session",
            "slipscale next --pilot",
        ),
        "participants": (
            "slipscale.experiments.cli.lab",
            "in a laboratory folder: list the participants and show who is next",
            "slipscale participants",
        ),
    },
}
COMMANDS = {name: row for group in GROUPS.values() for name, row in group.items()}
WITH_SUBCOMMANDS = ("data", "lab", "plate", "setup", "study")


def usage() -> str:
    """Return the help text of ``slipscale``."""
    lines = ["usage: slipscale COMMAND [ARGUMENT ...]", ""]
    lines += ["Laboratory software for ultrasonic tactile plates."]
    for title, group in GROUPS.items():
        lines += ["", f"{title}:"]
        lines += [f"  {name:<12} {purpose}" for name, (_, purpose, _) in group.items()]
    lines += ["", "slipscale COMMAND --help shows the options of a command and an example."]
    lines += [
        "With --verbose, a command reports its steps; slipscale --version prints the version."
    ]
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : list of str, optional
        Command line without the program's name. By default, ``sys.argv[1:]`` is used, and a signal
        ends the process with status 130 at any time.

    Returns
    -------
    int
        Exit status: 0 success, 1 negative result, 2 wrong input, 3 rig failure, 130 interruption.
    """
    if "_ARGCOMPLETE" in os.environ:
        complete()
    if arguments is not None:
        return _answer(arguments)
    _start_in_utf_8()
    # With more BLAS threads, fits with small matrices need twice the processor time.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from slipscale.faults.lasting_output import last

    last()
    ended = _signals_end()
    try:
        status = _answer(sys.argv[1:])
        ended.append("over")
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception:
        if not ended:
            raise
        return INTERRUPTED  # A library turned the KeyboardInterrupt into another exception.
    return status


def _start_in_utf_8() -> None:
    """Start again in Python's UTF-8 mode if files would be read in another encoding.

    PsychoPy reads its own files in the encoding of the terminal, which keeps it.
    """
    import locale

    encoding = locale.getencoding()
    in_utf_8 = sys.flags.utf8_mode or encoding.lower() in {"utf-8", "utf8"}
    if in_utf_8 or sys.platform == "win32" or os.environ.get("PYTHONUTF8") == "1":
        return
    os.environ["PYTHONUTF8"] = "1"
    os.environ.setdefault("PYTHONIOENCODING", encoding)
    os.execv(sys.executable, [sys.executable, *sys.orig_argv[1:]])  # noqa: S606 - this command


def _signals_end() -> list[str]:
    """Let the first signal raise KeyboardInterrupt, and any later signal end the process.

    After the command has finished, any signal ends the process.
    """
    import signal

    from slipscale.hardware.signals import ENDINGS, note_signal

    ended: list[str] = []

    def end(number: int, _frame: object) -> None:
        if ended:
            os._exit(INTERRUPTED)
        ended.append("by a signal")
        raise note_signal(number)

    for name in ENDINGS:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) != signal.SIG_IGN:  # ignored under nohup
            signal.signal(number, end)
    return ended


def _answer(words: list[str]) -> int:
    """Run a command line, report errors, and return the exit status."""
    if wrong := next((word for word in words if not _readable(word)), None):
        sentence = f"{wrong!a}: the name is not UTF-8; rename the file, then repeat the command"
        return _failed(words[0], sentence, USER_FAULT)
    status = dispatch(words)
    if sys.stdout is not None:  # None: closed from the beginning
        sys.stdout.flush()
    if lost := getattr(sys.stdout, "lost", ""):
        return _failed(
            words[0], f"the output could not be written ({lost})", status or ANSWER_IS_NO
        )
    return status


def _readable(word: str) -> bool:
    try:
        word.encode()
    except UnicodeEncodeError:
        return False
    return True


def dispatch(words: list[str]) -> int:
    """Call a command, or handle options that need no command, and return the exit status."""
    if not words:
        print(usage(), file=sys.stderr)
        return USER_FAULT
    if words[0] in ("-h", "--help", "help"):
        print(usage())
        return DONE
    if words[0] in ("-V", "--version"):
        print(f"slipscale {__version__}")
        return DONE
    if words[0] not in COMMANDS:
        message = f"slipscale: {_unknown(words)}; for help: slipscale --help"
        print(harmless(message), file=sys.stderr)
        return USER_FAULT
    return call(words[0], words[1:])


def _unknown(words: list[str]) -> str:
    """Return why a command line without a command is refused, and what it probably meant."""
    from slipscale.faults.suggestions import did_you_mean

    if words[0].startswith("-") and (later := [word for word in words if word in COMMANDS]):
        rest = [word for word in words if word != later[0]]
        return f"the command comes first: slipscale {' '.join([later[0], *rest])}"
    parents = [name for name in WITH_SUBCOMMANDS if words[0] in load_command(name)[0].subcommands]
    if parents:
        meant = " or ".join(f"slipscale {name} {words[0]}" for name in parents)
        return f"'{words[0]}' is a subcommand: {meant}"
    return f"unknown command '{words[0]}'{did_you_mean(words[0], COMMANDS, start='slipscale ')}"


def complete() -> None:
    """Print possible completions of the command line for a shell, and exit."""
    from argcomplete import autocomplete

    from slipscale.faults.parser import Parser

    parser = Parser(prog="slipscale")
    commands = parser.add_subparsers()
    for name, (module, purpose, _) in COMMANDS.items():
        commands.add_parser(name, help=purpose).loads = (module, name)
    # argcomplete only uses arguments that were added before parsing.
    parser.load(os.environ.get("COMP_LINE", "").split()[1:])
    autocomplete(parser)


def load_command(name: str) -> tuple[Parser, Callable[[Namespace], int]]:
    """Return the parser of a command, and the function that runs it."""
    # Imported late, to keep `slipscale --help` fast.
    from importlib import import_module

    from slipscale.faults.parser import Parser

    module, purpose, example = COMMANDS[name]
    parser = Parser(
        prog=f"slipscale {name}",
        description=purpose[0].upper() + purpose[1:],
        epilog=f"example: {example}",
    )
    add_arguments, run = import_module(module).COMMANDS[name]
    add_arguments(parser)
    return parser, run


def call(name: str, words: list[str]) -> int:
    """Load and run a command, and report user errors and rig errors in one sentence."""
    verbose = "--verbose" in words
    try:
        parser, run = load_command(name)
        if verbose:
            _report_steps()
        args = parser.parse_args(words)
        from slipscale.requirements import check

        check(name, args)
        return int(run(args))
    except ModuleNotFoundError as error:
        from slipscale.faults.extras import how_to_install

        if (sentence := how_to_install(error.name or "")) is None:
            raise
        return _failed(name, sentence, USER_FAULT, verbose=verbose)
    except (UserError, RigError) as error:
        status = USER_FAULT if isinstance(error, UserError) else RIG_FAULT
        return _failed(name, str(error), status, verbose=verbose)
    except OSError as error:
        # Commands name the file and a remedy; this is for a disk that fails in the middle of one.
        fault = UserError(
            "{name}: cannot be read or written ({reason}); check the disk, then repeat the command",
            name=error.filename or "a file",
            reason=error.strerror or repr(error),
        )
        return _failed(name, str(fault), USER_FAULT, verbose=verbose)
    except KeyboardInterrupt:
        return _failed(name, "interrupted", INTERRUPTED)
    except EOFError:
        sentence = "the input ended before the question was answered, so nothing was begun"
        return _failed(name, sentence, INTERRUPTED, verbose=verbose)
    finally:
        if verbose:
            from logging import getLogger

            getLogger(__name__).info("%s ended", name)
            getLogger("slipscale").handlers = []  # later commands in this process add their own


def _failed(name: str, sentence: str, status: int, *, verbose: bool = False) -> int:
    """Print why a command failed (if ``verbose``, with the traceback), and return the status."""
    if verbose:
        from traceback import print_exc

        print_exc()
    from slipscale.faults.message import report

    report("error", sentence, f"slipscale {name}: {harmless(sentence)}")
    return status


def _report_steps() -> None:
    """Write Slipscale's log to standard error, with the time since the start."""
    import logging

    class Seconds(logging.Formatter):
        def format(self, record: logging.LogRecord) -> str:
            words = harmless(record.getMessage())
            return f"{record.relativeCreated / 1000:7.2f} s  {record.name}: {words}"

    handler = logging.StreamHandler()
    handler.setFormatter(Seconds())
    logger = logging.getLogger("slipscale")
    logger.handlers = [handler]
    logger.setLevel(logging.INFO)
