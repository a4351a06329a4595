"""Define words for reports on yes/no tasks, which depend on whether a plate makes the stimuli."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class YesNoWords:
    """Wording for a yes/no task.

    Each trial presents a step in amplitude (if a plate produces the stimuli) or a single stimulus.
    ``trials``, ``down`` (trials with a change) and ``catch`` (trials without a change) each contain
    the singular and the plural. ``size`` is a noun for the variable on which the probability of
    "yes" depends, and ``each`` is a noun for one of its values. ``at`` introduces the value for
    which sensitivity is reported, as in "for steps of 0.5 µm".
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
