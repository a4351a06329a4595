"""Ask in a terminal what the columns of a table mean, and run a command with the answers."""

from __future__ import annotations

import re
import shlex
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from slipscale.faults import UserError, harmless

if TYPE_CHECKING:
    from slipscale.analysis.reading.foreign.described_columns import Column
    from slipscale.analysis.reading.foreign.proposal import Proposal

#: Kinds of answers: text of the choice, and the options that name its columns.
KINDS = (
    ("estimates (numbers)", ("response",)),
    ("yes or no, or right or wrong", ("answer",)),
    ("numbers of yes answers and of all answers", ("yes_count", "n")),
)
NAMES = {
    "stimulus": "the levels",
    "response": "the estimates",
    "answer": "the answers",
    "yes_count": "the numbers of yes answers",
    "n": "the numbers of all answers",
}
#: Options of layouts without levels that have a unit.
NO_UNIT = ("matrix", "first", "quadruple", "triad")

Ask = Callable[[str], str]


def asking(args: Namespace, run: Callable[[Namespace], int]) -> int:
    """Run a command; in a terminal, ask for the meaning of the columns if no option states it."""
    from slipscale.analysis.reading.foreign.proposal import (
        SHEET,
        Unstated,
        as_options,
        described,
    )

    try:
        return run(args)
    except Unstated as needed:
        if not (sys.stdin.isatty() and sys.stdout.isatty()):
            raise
        proposal = needed.proposal
        if proposal.sheets and proposal.questions[0].option == SHEET:
            place = _chosen("Which sheet contains the data?", proposal.sheets, input)
            proposal = described(proposal.paths, proposal.sheets[place]) or proposal
        given = meanings(proposal, input)
        for name, value in given.items():
            setattr(args, name, value)
        args.map = _is_yes(input("Save these options in analysis.toml for next time? [Y/n] "))
        words = shlex.join(["slipscale", "analyse", *map(str, needed.proposal.paths)])
        print(harmless(f"{words} {shlex.join(as_options(given))}"))
        return run(args)


def meanings(proposal: Proposal, ask: Ask) -> dict[str, object]:
    """Return the options of a proposal, with the answers to its questions.

    Parameters
    ----------
    proposal : Proposal
    ask : callable
        Function that shows a prompt and returns the reply, such as `input`.
    """
    from slipscale.analysis.reading.foreign.proposal import RESULTS, coded_answer

    given = dict(proposal.given)
    for question in proposal.questions:
        if question.option == RESULTS:
            del given["response"]
            kind = _chosen("What do the answers consist of?", [text for text, _ in KINDS], ask)
            for name in KINDS[kind][1]:
                given[name] = _column(name, question.candidates, ask)
        elif question.option != "yes":
            given[question.option] = _column(
                question.option, question.candidates or proposal.columns, ask
            )
    given.pop("yes", None)
    if coded := coded_answer(proposal.columns, given):
        given |= _codes(coded, ask)
    forced = {"answer", "yes_count", "percent"}.intersection(given) or "n" in given
    if forced and not {"first", "quadruple", "triad"}.intersection(given):
        reply = ask("Alternatives in a forced choice: 2 or 3 [not a forced choice]: ").strip()
        if reply in ("2", "3"):
            given["alternatives"] = int(reply)
    if not set(NO_UNIT).intersection(given):
        unit = ask("Unit of the levels [none]: ").strip()
        named = str(given.get("stimulus", "level"))
        given["stimulus"] = f"{named}:{unit}" if unit else named
    return given


def _column(option: str, candidates: Sequence[Column], ask: Ask) -> str:
    found = _chosen(f"Which column contains {NAMES[option]}?", [str(c) for c in candidates], ask)
    return candidates[found].name


def _chosen(question: str, choices: Sequence[str], ask: Ask) -> int:
    """Return the place of the chosen text; the reply is its number, or the beginning of it."""
    listed = "\n".join(f"  {place}  {text}" for place, text in enumerate(choices, 1))
    prompt = harmless(f"{question}\n{listed}\n") + "Number or name [1]: "
    while True:
        reply = ask(prompt).strip()
        if not reply:
            return 0
        if reply.isdigit() and 1 <= int(reply) <= len(choices):
            return int(reply) - 1
        named = [place for place, text in enumerate(choices) if text.startswith(reply)]
        if len(named) == 1:
            return named[0]
        prompt = f"expected a number from 1 to {len(choices)}, or a name: "


def _codes(column: Column, ask: Ask) -> dict[str, object]:
    """Return the meaning of the codes of an answer."""
    known = list(column.values)
    found: dict[str, object] = {}
    for name, question in (
        ("yes", f"Codes in {column.name}: {', '.join(known)}.\nWhich mean yes or correct? "),
        ("missing", "Which mean that there is no answer? [none] "),
    ):
        prompt = harmless(question)
        while True:
            reply = [word for word in re.split(r"[,\s]+", ask(prompt)) if word]
            wrong = [word for word in reply if word not in known]
            if not wrong and (reply or name == "missing"):
                break
            prompt = harmless(f"expected codes from: {', '.join(known)}: ")
        if reply:
            found[name] = reply
            known = [code for code in known if code not in reply]
    if not known:
        raise UserError(
            "column {column}: no code is left for no or wrong; expected at least one",
            column=column.name,
        )
    return found | {"no": known}


def _is_yes(reply: str) -> bool:
    return reply.strip().casefold() in ("", "y", "yes")
