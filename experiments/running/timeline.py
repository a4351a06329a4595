"""Estimate a participant's time, the plate's on-time, the number of exposures and the cost.

Durations are estimated with simulated participants, without a plate or a screen. Real sessions take
longer, because welcoming participants, waiting, and answering their questions also take time. This
time can be set in the study's ``[cost]`` table.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from slipscale.experiments.participants.simulated_people.bare_run import BareStep, bare_run
from slipscale.experiments.running.begin_or_resume import plate_for
from slipscale.experiments.running.pilot import MOCK, pilot_plans
from slipscale.experiments.steps.steps import Present, Rest, Silence, Step
from slipscale.faults import UserError
from slipscale.hardware.address import with_plate_file
from slipscale.hardware.clock import VirtualClock

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from slipscale.experiments.participants.simulated_people.population import Population
    from slipscale.experiments.study.model import Study
    from slipscale.experiments.study.run_plan import RunPlan

    Array = NDArray[np.float64]

#: Time that a surface takes to settle on the mock plate.
SETTLING_S = 0.05
MINUTE_S, HOUR_S = 60.0, 3600.0
PEOPLE = 200
QUANTILES = (5, 50, 95)
ABOUT = "welcome, consent and questions"
RESTS = "rests"


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Quantiles across simulated participants."""

    p5: float
    p50: float
    p95: float

    @classmethod
    def of(cls, values: Sequence[float] | Array) -> Spread:
        """Return the 5th, 50th and 95th percentiles of the values."""
        p5, p50, p95 = (float(value) for value in np.percentile(np.asarray(values), QUANTILES))
        return cls(p5=p5, p50=p50, p95=p95)


@dataclass(frozen=True, slots=True, kw_only=True)
class Timeline:
    """Time, exposures and cost per participant, summed over the participant's runs.

    Parameters
    ----------
    parts : tuple of (str, Spread)
        Name and duration (in minutes) of each part, in order.
    total_min, plate_on_min : Spread
        Minutes in total, and minutes with the plate vibrating.
    exposures : Spread
        Number of presented surfaces with a level above 0.
    longest_on_s : Spread
        Longest continuous vibration.
    duty : Spread
        Largest duty cycle in any window whose length is given by the plate's limits.
    on_time_limit_s, duty_limit : float
        The plate's limits on continuous vibration and on the duty cycle.
    people, participants : int
        Number of simulated participants, and of planned participants.
    cost_each, cost_total : Spread or None
        Cost in the study's currency; None if the study file has no ``[cost]`` table.
    currency : str
    """

    parts: tuple[tuple[str, Spread], ...]
    total_min: Spread
    plate_on_min: Spread
    exposures: Spread
    longest_on_s: Spread
    duty: Spread
    on_time_limit_s: float
    duty_limit: float
    people: int
    participants: int
    cost_each: Spread | None = None
    cost_total: Spread | None = None
    currency: str = ""


class _Visit:
    """Times and events recorded for one simulated participant."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.parts: dict[str, float] = defaultdict(float)
        self.exposures = 0
        self._on_since_s: float | None = None
        self.on: list[tuple[float, float]] = []

    def take(self, part: str, done: BareStep) -> None:
        """Record a completed step."""
        begun_s = self.now_s
        self.now_s += done.duration_s
        step = done.step
        if isinstance(step, Present):
            vibrates = step.surface.made.level > 0
            self.exposures += vibrates
            self._switch(on=vibrates)
            self.now_s += SETTLING_S
        elif isinstance(step, Silence):
            self._switch(on=False)
        self.parts[part] += self.now_s - begun_s

    def end(self) -> None:
        """Record the end of a run, after which the plate is silent."""
        self._switch(on=False)

    def _switch(self, *, on: bool) -> None:
        if on and self._on_since_s is None:
            self._on_since_s = self.now_s
        elif not on and self._on_since_s is not None:
            self.on.append((self._on_since_s, self.now_s))
            self._on_since_s = None

    @property
    def on_s(self) -> float:
        """Total vibration time of the plate in s."""
        return sum(end - begun for begun, end in self.on)

    @property
    def longest_on_s(self) -> float:
        """Duration of the longest continuous vibration."""
        return max((end - begun for begun, end in self.on), default=0.0)

    def duty(self, window_s: float) -> float:
        """Return the plate's largest duty cycle over all windows of length ``window_s``."""
        # The maximum is reached in a window that ends at the same time as a vibration.
        return max((self._on_within(last - window_s, last) for _, last in self.on), default=0.0) / (
            window_s
        )

    def _on_within(self, first_s: float, last_s: float) -> float:
        """Return how long the plate vibrated between two times, in seconds."""
        return sum(max(min(end, last_s) - max(begun, first_s), 0.0) for begun, end in self.on)


def timeline(
    name: str,
    *,
    people: int = PEOPLE,
    population: Population | None = None,
    text: str | None = None,
) -> Timeline:
    """Estimate the timeline for one participant of a study.

    Parameters
    ----------
    name : str
        A study file, or the name of a study that comes with Slipscale.
    people : int
        Number of simulated participants.
    population : Population, optional
    text : str, optional
        Content of the study file, if it differs from the saved file.

    Raises
    ------
    UserError
        If ``people`` is 0, or a protocol has no simulated answers.
    """
    if people < 1:
        raise UserError("--people {people}: expected 1 or more", people=people)
    plans = pilot_plans(name, participants=people, seed=None, language=None, text=text)
    study = plans[0].study
    visits: dict[str, _Visit] = defaultdict(_Visit)
    for plan in plans:
        visit = visits[plan.participant]
        for done in bare_run(plan, population):
            visit.take(_part(done.step, plan), done)
        visit.end()
    every = list(visits.values())
    order = list(dict.fromkeys(part for visit in every for part in visit.parts))
    minutes = np.array([visit.now_s for visit in every]) / MINUTE_S
    held = with_plate_file(MOCK, study.plate.file)
    limits = plate_for(plans[0], held, VirtualClock()).limits
    found = Timeline(
        parts=tuple(
            (part, Spread.of([visit.parts[part] / MINUTE_S for visit in every])) for part in order
        ),
        total_min=Spread.of(minutes),
        plate_on_min=Spread.of([visit.on_s / MINUTE_S for visit in every]),
        exposures=Spread.of([visit.exposures for visit in every]),
        longest_on_s=Spread.of([visit.longest_on_s for visit in every]),
        duty=Spread.of([visit.duty(limits.duty_window_s) for visit in every]),
        on_time_limit_s=limits.on_time_s,
        duty_limit=limits.duty,
        people=people,
        participants=study.participants,
    )
    return _with_cost(found, study, minutes)


def _with_cost(found: Timeline, study: Study, minutes: Array) -> Timeline:
    """Add the study's cost to a timeline, if the study specifies costs."""
    cost = study.cost
    if cost is None:
        return found
    visits = len(study.sessions or ("",)) * study.runs
    hours = (minutes + cost.setup_minutes * visits) * MINUTE_S / HOUR_S
    each = cost.per_person + cost.per_rig_hour * hours
    # The total for all participants is estimated by resampling the simulated participants.
    drawn = np.random.default_rng(0).choice(each, size=(1000, study.participants))
    return replace(
        found,
        cost_each=Spread.of(each),
        cost_total=Spread.of(drawn.sum(axis=1)),
        currency=cost.currency,
    )


def _part(step: Step, plan: RunPlan) -> str:
    """Return the name of the part of a run to which a step belongs."""
    if isinstance(step, Rest) or isinstance(getattr(step, "screen", None), Rest):
        return RESTS
    trial = step.trial
    if trial is None:
        return ABOUT
    titles = {protocol.task: protocol.titled(plan.study.quantity) for protocol, _ in plan.tasks()}
    title = titles[trial.task]
    return f"{title}, practice" if trial.phase == "practice" else title


def as_json(found: Timeline) -> str:
    """Convert a timeline to JSON."""
    content = asdict(found)
    content["parts"] = [{"part": part, **asdict(minutes)} for part, minutes in found.parts]
    return json.dumps(content, indent=2, ensure_ascii=False)


def lines(found: Timeline) -> list[str]:
    """Format a timeline as lines of text: durations, exposure to vibration, and costs."""
    width = max(len(part) for part, _ in found.parts) + 2
    head = f"{'minutes':<{width}}{'p5':>8}{'p50':>8}{'p95':>8}"
    rows = [*found.parts, ("in all", found.total_min), ("plate vibrating", found.plate_on_min)]
    width = max(width, *(len(name) + 2 for name, _ in rows))
    shown = [
        f"Timeline for a participant ({found.people} simulated people)",
        head,
        *(f"{name:<{width}}{s.p5:8.1f}{s.p50:8.1f}{s.p95:8.1f}" for name, s in rows),
        "",
    ]
    exposures, longest, duty = found.exposures, found.longest_on_s, found.duty
    shown.append(
        f"vibrating surfaces: {exposures.p50:.0f} ({exposures.p5:.0f} to {exposures.p95:.0f})"
    )
    shown.append(
        f"longest continuous vibration: {longest.p50:.0f} s (95th percentile: {longest.p95:.0f} s; "
        f"the plate's limit: {found.on_time_limit_s:g} s)"
    )
    shown.append(
        f"largest duty cycle: {duty.p50:.0%} (95th percentile: {duty.p95:.0%}; the plate's "
        f"limit: {found.duty_limit:.0%})"
    )
    if found.longest_on_s.p95 > found.on_time_limit_s or found.duty.p95 > found.duty_limit:
        shown.append(
            "WARNING: the plate switches itself off beyond its limits; add rests, or limit the "
            "exploration time"
        )
    if found.cost_each and found.cost_total:
        each, total = found.cost_each, found.cost_total
        shown.append(
            f"cost per participant: {each.p50:.0f} {found.currency} ({each.p5:.0f} to "
            f"{each.p95:.0f}); "
            f"{total.p50:.0f} {found.currency} for {found.participants} participants "
            f"({total.p5:.0f} to {total.p95:.0f})"
        )
    else:
        shown.append("cost: not estimated, because the study file has no [cost] table")
    return shown
