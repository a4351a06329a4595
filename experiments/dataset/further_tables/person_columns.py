"""Define the columns in the tables for participants, sessions and questionnaires."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from slipscale.experiments.dataset.schema import COMPLETE, MODE, RUN, SESSION
from slipscale.experiments.steps.columns import Column


def session_columns() -> dict[str, Column]:
    """Return the columns that follow `SESSION` in a participant's sessions.tsv, in order."""
    return {
        "acq_time": Column(
            value=lambda _: None,
            kind="text",
            description="Start time of the session's first run, in UTC; n/a for a pilot",
        ),
        COMPLETE: Column(
            value=lambda _: None,
            kind="label",
            description="Whether every run of the session was completed",
            levels={"yes": "complete", "no": "interrupted, or still running"},
        ),
    }


def questionnaire_columns(
    items: Mapping[str, tuple[str, Mapping[str, str]]], visits: Collection[str] = ()
) -> dict[str, Column]:
    """Return the columns that follow `PARTICIPANT` in a questionnaire's table, in order.

    Parameters
    ----------
    items : Mapping
        For each item code, the item's text and a mapping from answer codes to their labels.
    visits : collection of str
        Names of the columns, if any, that identify the session and the run.
    """
    which = {
        SESSION: "Session in which the question was asked",
        RUN: "Run of the session in which the question was asked",
    }
    return {
        name: Column(value=lambda _: None, kind="label", description=meaning)
        for name, meaning in which.items()
        if name in visits
    } | {
        name: Column(
            value=lambda _: None, kind="label", description=f"Item: {words}", levels=levels
        )
        for name, (words, levels) in items.items()
    }


def person_columns(questions: Mapping[str, Mapping[str, str]] | None = None) -> dict[str, Column]:
    """Return the columns that follow `PARTICIPANT` in participants.tsv, in order.

    Parameters
    ----------
    questions : Mapping
        Labels of the answer codes of each question about the participant, keyed by the name of the
        question. The labels are empty if the answer is a number.
    """
    answers = {
        name: Column(
            value=lambda _: None,
            kind="label",
            description=f"Answer to the question '{name}'",
            levels=levels,
        )
        for name, levels in (questions or {}).items()
    }
    return answers | {
        MODE: Column(
            value=lambda _: None,
            kind="label",
            description="Whether the answers come from a participant's run or a pilot run",
            levels={
                "participant": "a person's answers, to be analysed",
                "pilot": (
                    "a pilot run: simulated, or completed by a person who tried out the study"
                ),
            },
        ),
        COMPLETE: Column(
            value=lambda _: None,
            kind="label",
            description="Whether every run was completed",
            levels={"yes": "complete", "no": "interrupted, or still running"},
        ),
    }
