"""Words for yes/no tasks: steps down for a plate, single stimuli for other data."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class YesNoWords:
    """Words for a yes/no task: for a plate, steps down; otherwise, single stimuli.

    ``trials``, ``down`` (with a change) and ``catch`` (without) are singular and plural. "Yes"
    depends on ``size`` and is listed for ``each``; its sensitivity is listed by ``kind``, ``at`` a
    value.
    """

    size: str
    name: str = "yes and no"
    task: str = "yes and no"
    trials: tuple[str, str] = ("trial", "trials")
    down: tuple[str, str] = ("stimulus", "stimuli")
    catch: tuple[str, str] = ("catch trial", "catch trials")
    each: str = "level"
    kind: str = "level"
    at: str = "at"


STEPS = YesNoWords(
    name="descending difference",
    task="the descending difference",
    trials=("step", "steps"),
    down=("step down", "steps down"),
    catch=("catch step", "catch steps"),
    each="step down",
    size="the size of the step",
    kind="step size",
    at="for steps of",
)
