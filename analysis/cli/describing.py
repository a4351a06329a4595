"""Describe a table instead of analysing it: its columns, proposed options and their consequence.

The console shows the description as a page; for its entries, see `Description.as_json`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from slipscale.analysis.load import load
from slipscale.analysis.reading.cells import cell
from slipscale.analysis.reading.foreign.proposal import (
    OWN,
    RESULTS,
    SHEET,
    Proposal,
    coded_answer,
    described,
)
from slipscale.analysis.reading.meaning.keywords import mapping_of, name_and_unit
from slipscale.analysis.reading.meaning.mapping import Columns
from slipscale.faults import UserError
from slipscale.faults.message import output

#: Number of rows that are shown.
SHOWN = 5
#: Columns with levels, in the trials of the kinds of task.
LEVELS = frozenset({"level", "level_before", "track_level"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Amounts:
    """What the analysis would contain: numbers of answers, people and levels (0 for items)."""

    answers: int
    people: int
    levels: int

    def __str__(self) -> str:
        """Return the amounts in words."""
        return f"answers: {self.answers}; people: {self.people}; levels: {self.levels}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Description:
    """A table, options for it, and their consequence.

    Parameters
    ----------
    proposal : Proposal
        The table, with the options that apply: the user's, or the proposed ones.
    amounts : Amounts or None
        The consequence of the options; None if they are incomplete, or the table cannot be read
        with them.
    fault : str
        Why the table cannot be read with these options; empty if it can.
    """

    proposal: Proposal
    amounts: Amounts | None = None
    fault: str = ""

    @property
    def given(self) -> dict[str, object]:
        """The options that apply, without names for what is unknown."""
        unknown = {question.option for question in self.proposal.questions}
        unknown |= {"response"} if RESULTS in unknown else set()
        return {key: value for key, value in self.proposal.given.items() if key not in unknown}

    @property
    def codes(self) -> list[str]:
        """Codes in the column of answers, if their meaning has to be stated."""
        coded = coded_answer(self.proposal.columns, self.given)
        return list(coded.values) if coded else []

    def __str__(self) -> str:
        """Return the description, the command, and the consequence or what is missing."""
        consequence = self.fault or (str(self.amounts) if self.amounts else "")
        parts = (str(self.proposal), self.proposal.command, consequence)
        return "\n".join(part for part in parts if part)

    def as_json(self) -> dict[str, object]:
        """Return the description as data.

        The entries ``roles`` (option -> column), ``unit``, ``codes`` (code -> option),
        ``alternatives`` and ``layout`` (other options) are the options that apply. The entries
        ``open`` and ``candidates`` are the options that the table does not reveal, with the columns
        that they could name.
        """
        proposal, given = self.proposal, self.given
        frame = proposal.frame.head(SHOWN)
        name, unit = name_and_unit(str(given.get("stimulus", "")))
        known = {column.name for column in proposal.columns}
        roles = {key: value for key, value in given.items() if key in Columns.model_fields}
        stated = {
            code: option
            for option in ("yes", "no", "missing")
            for code in _codes(given.get(option))
        }
        beside_codes = {"yes", "no", "missing", "alternatives", SHEET}
        amounts = self.amounts
        return {
            "name": proposal.tables[0].name,
            "program": proposal.program,
            "files": len(proposal.tables),
            "sheets": proposal.sheets,
            "sheet": proposal.given.get(SHEET, ""),
            "rows": len(proposal.frame),
            "columns": [
                {
                    "name": column.name,
                    "values": column.values,
                    "distinct": column.distinct,
                    "missing": column.missing,
                    "range": column.range,
                    "head": [cell(value) for value in frame[column.name].fillna("")],
                }
                for column in proposal.columns
            ],
            "own": set(OWN) <= known,
            "roles": {k: v for k, v in (roles | {"stimulus": name}).items() if v in known},
            "unit": unit,
            "codes": {code: stated.get(code, "") for code in self.codes},
            "alternatives": given.get("alternatives"),
            "layout": {
                key: value
                for key, value in given.items()
                if key not in roles and key not in beside_codes
            },
            "open": [question.option for question in proposal.questions],
            "candidates": {
                question.option: [column.name for column in question.candidates]
                for question in proposal.questions
            },
            "amounts": amounts
            and {"answers": amounts.answers, "people": amounts.people, "levels": amounts.levels},
            "fault": output(self.fault),
            "command": proposal.command,
        }


def describe(paths: Sequence[Path], given: Mapping[str, object]) -> Description:
    """Describe a table, and apply the given options or, without any, the proposed ones.

    Raises
    ------
    UserError
        If there is no table, or it cannot be read with any options.
    """
    sheet = given.get(SHEET)
    proposal = described(paths, str(sheet) if sheet else None)
    if proposal is None:
        raise UserError(
            "{path}: no table found; expected a table, or a folder of tables, to describe",
            path=paths[0],
        )
    if set(given) - {SHEET} or set(OWN) <= set(proposal.frame.columns):
        proposal = replace(proposal, given=given, questions=())
    if proposal.questions:
        return Description(proposal=proposal)
    try:
        data = load(paths, mapping_of(proposal.given) if proposal.given else None)
    except UserError as error:
        return Description(proposal=proposal, fault=str(error))
    different = [rows[name].nunique() for rows in data.tasks for name in LEVELS.intersection(rows)]
    levels = max(different, default=0)
    amounts = Amounts(answers=len(data), people=len(data.people), levels=levels)
    return Description(proposal=proposal, amounts=amounts)


def _codes(given: object) -> list[str]:
    return [given] if isinstance(given, str) else [*given] if isinstance(given, list) else []
