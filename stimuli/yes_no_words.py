"""Define the wording of reports on yes/no tasks, for plates and for other stimuli."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class YesNoWords:
    """Wording for a yes/no task, in which a trial is a step down (of a plate) or a single stimulus.

    ``trials``, ``down`` (trials with a change) and ``catch`` (trials without a change) each contain
    the singular and the plural. ``size`` is the variable on which the probability of "yes" depends,
    and ``each`` is the name of a single value of it. ``at`` is the phrase before the value at which
    sensitivity is reported.
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
