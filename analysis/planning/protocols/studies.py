"""Define the studies whose protocols are compared: estimated quantity, length and duration.

In each study, the first task that yields an exponent or a threshold is compared. This task's number
of trials is chosen so that the study takes the given time. Other tasks are unchanged.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import tomlkit

from slipscale.analysis.tasks.thresholds.reading import COMPARISON, FORCED_CHOICE
from slipscale.experiments.participants.simulated_people.bare_run import BareStep, bare_run
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.protocol_parts.base import Options, Protocol
from slipscale.experiments.protocol_parts.registry import load_protocol
from slipscale.experiments.protocols.magnitude_estimation import MagnitudeEstimation
from slipscale.experiments.running.pilot import pilot_plans
from slipscale.experiments.running.timeline import MINUTE_S, SETTLING_S
from slipscale.experiments.steps.steps import Present
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.experiments.study.file import parse_study, read_study
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError

#: Options that determine a task's number of trials, in order of preference.
AMOUNTS = ("repetitions", "most_trials")
EXPONENT, DETECTION, DIFFERENCE = "exponent", "detection threshold", "difference threshold"
#: Columns of level and answer in tasks with ratio judgements.
RATIO = ("comparison_level", "ratio")
#: Number of simulated people whose median time is a study's duration.
TIMED = 24


@dataclass(frozen=True, slots=True, kw_only=True)
class ProtocolStudy:
    """A study and one of its tasks; the number of trials of this task can be set.

    Parameters
    ----------
    name : str
        Path of the file, or name of a study that comes with Slipscale.
    own_name : str
        The study's name in its file. Seeds depend on this name and not on the file's location.
    text : str
        Text of the study file with the chosen number of trials.
    place : int
        Index of the task in the study, counted from 0.
    task, title : str
        Label of the task, and title of its protocol.
    quantity : str
        The estimated quantity.
    marks : tuple of str or None
        Columns for level and answer in the task's table; None for magnitude estimation.
    amount : str
        The option that sets the number of trials.
    number : int
        Value of that option.
    """

    name: str
    own_name: str
    text: str
    place: int
    task: str
    title: str
    quantity: str
    marks: tuple[str, str] | None
    amount: str
    number: int

    @property
    def choices(self) -> AnalysisChoices:
        """The study's analysis choices, such as the axis of threshold curves."""
        return parse_study(self.text, self.name).analysis

    def with_number(self, number: int) -> ProtocolStudy:
        """Return a copy of the study in which the option that sets the trials has a new value."""
        document = tomlkit.parse(self.text)
        tasks = document["tasks"]
        if not isinstance(tasks, list):
            raise TypeError(type(tasks).__name__)
        tasks[self.place][self.amount] = number
        return replace(self, number=number, text=tomlkit.dumps(document))

    def plans(self, participants: int, seed: int, population: Population) -> list[RunPlan]:
        """Return the runs for one simulated study."""
        plans = pilot_plans(
            self.name, participants=participants, seed=seed, language=None, population=population
        )
        return [replace(plan, study_text=self.text) for plan in plans]

    def minutes(self, population: Population) -> float:
        """Return the participants' median total duration over all runs, in minutes."""
        people: dict[str, float] = {}
        for plan in self.plans(TIMED, seed_of(self.own_name, 0), population):
            taken = minutes_of(bare_run(plan, population))
            people[plan.participant] = people.get(plan.participant, 0.0) + taken
        return float(np.median(list(people.values())))


def protocol_study(name: str) -> ProtocolStudy:
    """Read a study, and select the task whose precision is compared with other studies.

    Raises
    ------
    UserError
        If no task both yields an exponent or a threshold and has a settable number of trials.
    """
    study, text = read_study(name)
    for place, options in enumerate(study.tasks):
        protocol = load_protocol(options.protocol).for_task(options)
        quantity, marks = _answers(protocol, options)
        amount = next((key for key in AMOUNTS if hasattr(options, key)), None)
        if quantity and amount:
            return ProtocolStudy(
                name=name,
                own_name=study.name,
                text=text,
                place=place,
                task=protocol.task,
                title=protocol.titled(study.quantity),
                quantity=quantity,
                marks=marks,
                amount=amount,
                number=getattr(options, amount),
            )
    tasks = ", ".join(options.protocol for options in study.tasks)
    raise UserError(
        "--protocols {name}: no task ({tasks}) yields an exponent or a threshold for simulated "
        "people; expected magnitude estimation, ratios to a standard, forced choice or constant"
        " stimuli",
        name=name,
        tasks=tasks,
    )


def _answers(protocol: Protocol, options: Options) -> tuple[str | None, tuple[str, str] | None]:
    """Return the quantity that a task estimates, and its answer columns; either may be None."""
    own = (*protocol.design, *protocol.stimulus, *protocol.response)
    columns = set(own)
    if isinstance(options, MagnitudeEstimation):
        return EXPONENT, None
    if columns.issuperset(RATIO):
        return EXPONENT, RATIO
    for marks in (FORCED_CHOICE, COMPARISON):
        if columns.issuperset(marks):
            standard = getattr(options, "standard_level", None)
            return (f"{DIFFERENCE} at {standard:g} µm" if standard else DETECTION), marks
    return None, None


def filling(study: ProtocolStudy, minutes: float, population: Population) -> ProtocolStudy:
    """Return the study with as many trials as the median participant completes in `minutes`.

    Raises
    ------
    UserError
        If the study takes too long even with the option `amount` set to 1.
    """
    once = study.minutes(population)
    twice = study.with_number(2 * study.number).minutes(population)
    each = (twice - once) / study.number
    number = study.number + math.floor((minutes - once) / each + 1e-9)
    if number < 1:
        least = math.ceil(10 * (once - (study.number - 1) * each)) / 10
        raise UserError(
            "--minutes {minutes:g}: {study} takes about {least:.1f} minutes with {amount} = 1; "
            "expected {least:.1f} minutes or more",
            minutes=minutes,
            study=study.name,
            least=least,
            amount=study.amount,
        )
    return study.with_number(number)


def minutes_of(steps: Iterable[BareStep]) -> float:
    """Return the duration of a run in minutes."""
    seconds = math.fsum(
        done.duration_s + (SETTLING_S if isinstance(done.step, Present) else 0.0) for done in steps
    )
    return seconds / MINUTE_S


def seed_of(*purpose: str | int) -> int:
    """Derive a seed from the SHA-256 of its purpose, so that it is the same on all machines."""
    key = "\x1f".join(map(str, purpose))
    return int.from_bytes(hashlib.sha256(key.encode()).digest()[:4], "big")
