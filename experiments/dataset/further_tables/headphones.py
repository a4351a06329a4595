"""Read the result of a run's headphone test from its journal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from slipscale.experiments.journal.record import Record
from slipscale.experiments.steps.replies import NO_SOUND
from slipscale.experiments.study.headphone_test import (
    AGAIN,
    DECISION,
    HEADPHONES,
    NOISE,
    TONE,
    HeadphoneTest,
)


def headphone_result(records: list[Record], test: HeadphoneTest) -> dict[str, object]:
    """Return the result of the last attempt, with the operator's decision.

    The entry ``result`` is "passed", "failed", "not done" (with the reason), or "broken off" if the
    test was not completed.
    """
    reasons = [record.data["reason"] for record in records if record.kind == NO_SOUND]
    attempts: list[dict[str, object]] = [{}]
    right: dict[int, int] = {}
    for step, value in _answers(records):
        name, attempt = step["name"], len(attempts)
        attempts[-1][name] = value
        if name.startswith(TONE):
            right[attempt] = right.get(attempt, 0) + (value == step["played"]["sound"]["quiet"])
        if name == DECISION and value == AGAIN:
            attempts.append({})
    last = attempts[-1]
    if NO_SOUND in last.values():
        return {"result": "not done", "reason": reasons[-1], "attempts": len(attempts)}
    decisions = {name: value for name, value in last.items() if not name.startswith(TONE)}
    heard, correct = len(last) - len(decisions), right.get(len(attempts), 0)
    ears = all(decisions.get(f"{NOISE}_{ear}", ear) == ear for ear in ("left", "right"))
    result = "passed" if correct >= test.needed and ears else "failed"
    return {
        "result": result if heard == test.trials else "broken off",
        "attempts": len(attempts),
        "right": correct,
        "trials": heard,
        "needed": test.needed,
        **decisions,
    }


def _answers(records: list[Record]) -> Iterator[tuple[dict[str, Any], Any]]:
    """Yield each question of the headphone test together with its answer."""
    step: dict[str, object] = {}
    for record in records:
        if record.kind == "begin":
            step = record.data["what"]
        elif record.kind == "done" and step.get("task") == HEADPHONES:
            yield step, record.data["answer"]["value"]
