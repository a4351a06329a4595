"""The command-line reference, generated from the commands' parsers."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from functools import cache, partial
from importlib import import_module

from slipscale import commands
from slipscale.hardware.cli import plate
from tools.site.tables import code, table

INTRODUCTION = """# Command line

This page shows the `--help` text of each command. The exit status is 0 for success, 1 if the
command ran but the answer is no, 2 if the input is wrong, 3 if the rig failed, and 130 if the
command was interrupted.
"""


@cache
def parsers() -> dict[str, argparse.ArgumentParser]:
    """Return the parser of each command, keyed by its name, such as ``"slipscale plate list"``."""
    return dict(_walk())


def _walk() -> Iterator[tuple[str, argparse.ArgumentParser]]:
    for name in commands.COMMANDS:
        parser, _ = commands.load_command(name)
        yield parser.prog, parser
        for action in parser._actions:  # noqa: SLF001 - argparse shows its parts nowhere else
            if isinstance(action, argparse._SubParsersAction):  # noqa: SLF001
                helps = {choice.dest: choice.help for choice in action._choices_actions}  # noqa: SLF001
                for word, part in action.choices.items():
                    part.description = part.description or helps[word]
                    yield part.prog, part
    for word, (module, purpose) in plate.SUBCOMMANDS.items():
        # Subcommands of `slipscale plate` add their arguments only when they are called.
        part = argparse.ArgumentParser(prog=f"slipscale plate {word}", description=purpose)
        import_module(module).COMMANDS[word][0](part)
        yield part.prog, part


def arguments(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """Return a parser's own arguments, without ``--help`` and subcommands."""
    kinds = (argparse._HelpAction, argparse._SubParsersAction)  # noqa: SLF001
    return [
        action
        for action in parser._actions  # noqa: SLF001
        if not isinstance(action, kinds) and action.nargs != argparse.REMAINDER
    ]


def pages() -> dict[str, str]:
    """Return the page."""
    sections = [section(prog, parser) for prog, parser in parsers().items()]
    return {"reference/commands.md": "\n\n".join([INTRODUCTION, *sections]) + "\n"}


def section(prog: str, parser: argparse.ArgumentParser) -> str:
    """Return the section of a command: description, usage and arguments."""
    parser.formatter_class = partial(argparse.HelpFormatter, width=88)
    purpose = parser.description or ""
    lines = [
        f"{'##' if prog.count(' ') == 1 else '###'} {prog}",
        f"{purpose[0].upper()}{purpose[1:].rstrip('.')}.",
        f"```text\n{parser.format_usage().strip()}\n```",
    ]
    if rows := [row(parser, action) for action in arguments(parser)]:
        lines.append(table(["argument", "meaning", "default"], rows))
    return "\n\n".join(lines)


def row(parser: argparse.ArgumentParser, action: argparse.Action) -> list[str]:
    """Return the table row of an argument."""
    names = ", ".join(action.option_strings)
    value = "" if action.nargs == 0 else str(action.metavar or action.dest.upper())
    if action.choices and not names:
        value = str(action.metavar or " | ".join(map(str, action.choices)))
    meaning = parser._get_formatter()._expand_help(action) if action.help else ""  # noqa: SLF001
    none = action.default in (None, False, "", argparse.SUPPRESS)
    told = "default" in meaning or none or action.required
    default = "" if told else code(action.default)
    if action.required and names:
        default = "must be given"
    return [code(f"{names} {value}".strip()), meaning, default]
