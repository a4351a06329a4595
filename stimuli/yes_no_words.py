"""Define words for yes/no tasks with a plate and with other stimuli."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class YesNoWords:
    """Words for a yes/no task with steps down (for a plate) or with single stimuli.

    ``trials``, ``down`` (trials with a change) and ``catch`` (trials without) are given in singular
    and plural. The probability of "yes" depends on ``size`` and is listed for ``each``. Sensitivity
    is listed ``at`` a value.
    """

    size: str
    name: str = "yes and no"
    task: str = "yes and no"
    trials: tuple[str, str] = ("trial", "trials")
    down: tuple[str, str] = ("stimulus", "stimuli")
    catch: tuple[str, str] = ("catch trial", "catch trials")
    each: str = "level"
    at: str = "at"


STEPS = YesNoWords(
    name="descending difference",
    task="the descending difference",
    trials=("step", "steps"),
    down=("step down", "steps down"),
    catch=("catch step", "catch steps"),
    each="step down",
    size="the size of the step",
    at="for steps of",
)
