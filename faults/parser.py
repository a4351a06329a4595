"""Parse command lines, report errors as single sentences, and add options to all commands."""

from __future__ import annotations

from argparse import SUPPRESS, Action, ArgumentError, ArgumentParser, _SubParsersAction
from collections.abc import Sequence
from importlib import import_module
from typing import Any, NoReturn

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.suggestions import did_you_mean, expected_one_of

EXPECTED: dict[object, str] = {int: "expected a whole number", float: "expected a number"}
REQUIRED = "the following arguments are required: "
UNKNOWN = "unrecognized arguments: "
SHORT = {"-n": "--participants"}  # what other programs call otherwise
LABEL = "--participant"  # the option whose value is often given alone


class Parser(ArgumentParser):
    """Argument parser that reports errors as single sentences.

    Subcommands use the same parser class. ``loads`` is None, or the name of a module and of a
    command in the module's ``COMMANDS``. The module is imported on first use.
    """

    loads: tuple[str, str] | None = None
    _words: list[str]

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        # `slipscale.commands` reads this option before the command line is parsed.
        self.add_argument(
            "--verbose",
            action="store_true",
            default=SUPPRESS,
            help="report on standard error which files are read, what is chosen and how long "
            "each step takes; show the traceback of every error",
        )

    def load(self, words: Sequence[str] = ()) -> None:
        """Import the module of this command and the modules of the subcommands in ``words``."""
        if self.loads:
            (module, name), self.loads = self.loads, None
            fill, call = import_module(module).COMMANDS[name]
            fill(self)
            self.set_defaults(call=call)
        for action in self._actions:
            if isinstance(action, _SubParsersAction) and words and words[0] in action.choices:
                action.choices[words[0]].load(words[1:])

    @property
    def subcommands(self) -> tuple[str, ...]:
        """Names of the subcommands, if the command has any."""
        found = (each for each in self._actions if isinstance(each, _SubParsersAction))
        return tuple(name for action in found for name in action.choices)

    def parse_known_args(self, args: Any = None, namespace: Any = None, **options: Any) -> Any:
        """Load the command, parse its arguments, and reject unknown options."""
        self.load()
        self._words = list(args or ())
        found = super().parse_known_args(args, namespace, **options)
        if found[1]:
            self.error(UNKNOWN + " ".join(found[1]))
        return found

    def error(self, message: str) -> NoReturn:
        """Raise `UserError` with argparse's message, rewritten as one sentence."""
        if message.startswith(REQUIRED):
            # If an option is missing, another option is probably misspelt.
            message = self._misspelt() or self._missing(message.removeprefix(REQUIRED).split(", "))
        elif message.startswith(UNKNOWN):
            word = message.removeprefix(UNKNOWN).split(" ")[0]
            message = self._misspelt() or Message("unexpected argument '{word}'", word=word)
        raise UserError(
            "{message}; for help: {prog} --help",
            message=message.removeprefix("argument "),
            prog=self.prog,
        )

    def _misspelt(self) -> str:
        """Return the error message for the first unknown option, or an empty string."""
        known = [*self._option_string_actions]
        for option in (word for word in self._words if word[:1] == "-" and word[1:].isalpha()):
            if option not in known:
                start = SHORT.get(option, f"-{option}")
                long = next((each for each in known if each.startswith(start)), "")
                return Message(
                    "unknown option {option}{meant}",
                    option=option,
                    meant=Message(" (did you mean '{meant}'?)", meant=long) if long else "",
                )
        for option in (word.partition("=")[0] for word in self._words if word.startswith("--")):
            if option != "--" and not any(each.startswith(option) for each in known):
                return Message(
                    "unknown option {option}{meant}",
                    option=option,
                    meant=did_you_mean(option, known),
                )
        return ""

    def _missing(self, names: list[str]) -> str:
        for action in self._actions:
            if isinstance(action, _SubParsersAction) and action.metavar in names:
                return Message(
                    "expected a subcommand: {choices}", choices=", ".join(action.choices)
                )
        expected = []
        for action in self._actions:
            name = "/".join(action.option_strings) or str(action.metavar or action.dest)
            if name in names:
                value = f" {action.metavar or action.dest.upper()}" if action.option_strings else ""
                meaning = f" ({action.help})" if action.help else ""
                expected.append(f"{action.option_strings[0] if value else name}{value}{meaning}")
        verb = "is" if len(names) == 1 else "are"
        if names == [LABEL] and len(self._words) == 1:
            return Message(
                "{label} is missing; did you mean {command} {label} {word}?",
                label=LABEL,
                command=self.prog,
                word=self._words[0],
            )
        return f"{' and '.join(names)} {verb} missing; expected {', '.join(expected)}"

    def _get_value(self, action: Action, arg_string: str) -> object:
        try:
            return super()._get_value(action, arg_string)
        except ArgumentError as error:
            # Slipscale's converters raise a ValueError that contains the expected format.
            expected = EXPECTED.get(action.type) or str(error.__context__)
            raise ArgumentError(action, f"'{arg_string}', {expected}") from None

    def _check_value(self, action: Action, value: object) -> None:
        if action.choices is None or value in action.choices:
            return
        if isinstance(action, _SubParsersAction):
            alone = "" if action.required else f", or {self.prog} alone"
            expected = expected_one_of(value, action.choices)
            self.error(f"unknown subcommand '{value}', {expected}{alone}")
        raise ArgumentError(action, f"'{value}', {expected_one_of(value, action.choices)}")
