"""Define transients: surfaces whose amplitude changes when the finger triggers a change.

A transient begins with a constant amplitude. When the finger reaches a given position or force, or
when a given time has passed since contact, the amplitude changes to another value within a
transition time. The amplitude returns to its first value after a given duration. Without a
duration, it returns to its first value when the trigger condition is no longer met. A transient
that is triggered by position thus acts as an edge on the plate.

The list of amplitudes is timed by the clock of the plate itself. The duration of the transition is
therefore exact even if the computer rarely samples the finger; only its beginning depends on the
sampling.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal, get_args

from slipscale.faults import UserError
from slipscale.stimuli.modulation import (
    DEFAULT_MODULATOR,
    STEPS_MAX,
    Followed,
    Loop,
    Modulator,
    along_edge,
)
from slipscale.stimuli.parameters import Parameter, Parametric
from slipscale.stimuli.surface import Sensor

Shape = Literal["cosine", "linear"]
# Time for which the plate holds the last amplitude before it would repeat the list. Within this
# time, the computer commands the last amplitude.
HELD_S = 0.2
# Minimum number of half-cosine steps that make up a linear transition.
FEWEST_PIECES = 3
# Largest accepted difference between a duration and the nearest multiple of a step's duration.
DURATION_ERROR_S = 0.0005
#: Required sensors, keyed by trigger.
TRIGGERS: dict[str, Sensor] = {"position_mm": "position", "force_n": "force", "delay_s": "force"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Transient(Parametric):
    """Surface whose amplitude changes when a trigger condition is met.

    Exactly one of ``position_mm``, ``force_n`` and ``delay_s`` must be given.

    Parameters
    ----------
    shape : {"cosine", "linear"}
        Shape of the transition: half a period of a cosine, or a straight line.
    label, name : str
        See `slipscale.stimuli.texture.Grating`.

    Raises
    ------
    UserError
        If a parameter is out of range, or if there is not exactly one trigger.
    """

    #: Key by which a record is identified as a transient.
    MARK: ClassVar = "transition_s"

    from_level: Annotated[
        float,
        Parameter(
            name="initial {q.name}",
            unit=None,
            above=0,
            description="Amplitude before the change; above 0, because a plate that is switched "
            "off responds too slowly.",
        ),
    ]
    to_level: Annotated[
        float,
        Parameter(
            name="final {q.name}", unit=None, least=0, description="Amplitude after the change."
        ),
    ]
    transition_s: Annotated[
        float,
        Parameter(
            name="transition time",
            unit="s",
            above=0,
            most=2,
            description="Duration of the change between the two amplitudes.",
        ),
    ]
    duration_s: Annotated[
        float | None,
        Parameter(
            name="duration",
            unit="s",
            above=0,
            most=10,
            description="Time from the beginning of the change until the amplitude begins to "
            "return; default: until the trigger condition is no longer met.",
        ),
    ] = None
    position_mm: Annotated[
        float | None,
        Parameter(
            name="position",
            unit="mm",
            least=0,
            most=500,
            description="Position along the stroke, measured from the sensor's zero, at and "
            "beyond which the amplitude is changed.",
        ),
    ] = None
    force_n: Annotated[
        float | None,
        Parameter(
            name="force",
            unit="N",
            above=0,
            most=20,
            description="Normal force at and above which the amplitude is changed.",
        ),
    ] = None
    delay_s: Annotated[
        float | None,
        Parameter(
            name="delay",
            unit="s",
            least=0,
            most=60,
            description="Time between the finger's contact and the change in amplitude.",
        ),
    ] = None
    shape: Shape = "cosine"
    label: str = ""
    name: str = ""

    def __post_init__(self) -> None:
        self.refuse_parameters()
        if sum(getattr(self, each) is not None for each in TRIGGERS) != 1:
            raise UserError(
                "{where}: expected exactly one of {triggers}",
                where=self.where,
                triggers=", ".join(TRIGGERS),
            )
        if self.shape not in get_args(Shape):
            known = ", ".join(get_args(Shape))
            raise UserError(
                "{where}: unknown shape '{shape}' (expected one of: {known})",
                where=self.where,
                shape=self.shape,
                known=known,
            )
        if self.duration_s is not None and self.duration_s < self.transition_s:
            raise UserError(
                "{where}: duration_s must be at least transition_s ({transition_s:g}), but is "
                "{duration_s:g}",
                where=self.where,
                transition_s=self.transition_s,
                duration_s=self.duration_s,
            )

    @property
    def trigger(self) -> str:
        """Name of the parameter that triggers the change."""
        return next(each for each in TRIGGERS if getattr(self, each) is not None)

    @property
    def needs_sensor(self) -> bool:
        """Always True, because a sensor must measure the trigger."""
        return True

    @property
    def sensor(self) -> Sensor | None:
        """Sensor that measures the trigger."""
        return TRIGGERS[self.trigger]

    @property
    def level(self) -> float:
        """Larger of the two amplitudes."""
        return max(self.from_level, self.to_level)

    @property
    def settled_level(self) -> float:
        """Level at which the plate settles: the amplitude before the change."""
        return self.from_level

    @property
    def active_s(self) -> float:
        """Time from the trigger to the end of the last transition."""
        return self.transition_s + (self.duration_s or 0.0)

    @property
    def final_level(self) -> float:
        """Amplitude after the last transition."""
        return self.to_level if self.duration_s is None else self.from_level

    @property
    def caption(self) -> str:
        """Trigger with its value."""
        return f"{self.trigger} = {getattr(self, self.trigger):g}"

    @property
    def summary(self) -> str:
        """Description of the transient: amplitudes, trigger and durations."""
        lasts = "" if self.duration_s is None else f" for {1000 * self.duration_s:g} ms"
        return (
            f"{self.from_level:g} to {self.to_level:g} in {1000 * self.transition_s:g} ms{lasts}, "
            f"at {self.caption}"
        )

    def level_after(self, time_s: float) -> float:
        """Return the amplitude at a time relative to the trigger."""
        back_s = math.inf if self.duration_s is None else self.duration_s
        if time_s >= back_s:
            return self._along(self.to_level, self.from_level, time_s - back_s)
        return self._along(self.from_level, self.to_level, time_s)

    def _along(self, start: float, end: float, time_s: float) -> float:
        part = min(max(time_s / self.transition_s, 0.0), 1.0)
        return (
            along_edge(start, end, part) if self.shape == "cosine" else start + part * (end - start)
        )

    def shown(self, share: float) -> float:
        """Return the amplitude in a drawing of the change, at a position from 0 to 1."""
        return self.level_after((1.5 * share - 0.25) * self.active_s)

    def loop(self, modulator: Modulator = DEFAULT_MODULATOR) -> Loop | None:
        """Check the plate's limits. Return None, as no loop is played before the trigger."""
        self.change(modulator)
        return None

    def followed(self, modulator: Modulator = DEFAULT_MODULATOR) -> Followed | None:
        """Predict how well amplitude and friction follow the commanded change.

        Return None if there is no change.
        """
        if self.from_level == self.to_level:
            return None
        lasts = "" if self.duration_s is None else f" for {1000 * self.duration_s:g} ms"
        return Followed(
            change=f"a change in {1000 * self.transition_s:g} ms{lasts}",
            whole="it",
            plate=modulator.reached(self.duration_s),
            friction=modulator.friction_reached(self.duration_s),
            remedy="a longer duration",
            rise_s=modulator.friction_rise_s(self.transition_s),
        )

    def change(self, modulator: Modulator = DEFAULT_MODULATOR) -> Loop:
        """Return the list of amplitudes that a plate plays after the trigger.

        The last amplitude is held for `HELD_S` or more. If `final_level` is not commanded within
        this time, the list is repeated, and the repetition counts as a fault.

        Raises
        ------
        UserError
            If the plate or its serial line is too slow for the change.
        """
        pieces, step_s = self._pieces(modulator)
        turns = pieces if self.duration_s is None else round(self.duration_s / step_s)
        ends = turns if self.duration_s is None else turns + pieces
        count = ends + math.ceil(HELD_S / step_s)
        edge_s = min(self.transition_s, step_s)
        return Loop(
            levels=tuple(self._level_of(step, pieces, turns) for step in range(count)),
            step_s=step_s,
            edge_s=edge_s,
            mean_level=self.from_level,
        )

    def _level_of(self, step: int, pieces: int, turns: int) -> float:
        """Return the amplitude at the end of a step's transition."""
        part = min((step + 1) / pieces, 1.0)
        if self.duration_s is not None and step >= turns:
            part = 1.0 - min((step + 1 - turns) / pieces, 1.0)
        return self.from_level + part * (self.to_level - self.from_level)

    def _pieces(self, modulator: Modulator) -> tuple[int, float]:
        """Return the number of steps in a transition and the duration of each step.

        A half-cosine transition is played as the edge of a single step. A linear transition needs
        several steps, and both the transition time and the duration must be multiples of the step
        duration.
        """
        shortest_s, linear = modulator.edge_s, self.shape == "linear"
        lasts_s = self.duration_s
        if linear:
            # The whole list has at most `STEPS_MAX` steps.
            most_s = self.active_s + self.transition_s + HELD_S
            step_s = max(modulator.shortest_step_s, most_s / (STEPS_MAX - 2))
            shortest_s = FEWEST_PIECES * step_s
        if self.transition_s < shortest_s * (1 - 1e-9):
            raise UserError(
                "{where}: transition_s is {transition_s:g}, but the plate and its connection "
                "need {shortest_s:.4g} or more for a {shape} transition",
                where=self.where,
                transition_s=self.transition_s,
                shortest_s=shortest_s,
                shape=self.shape,
            )
        if not linear:
            if lasts_s is not None and lasts_s < modulator.shortest_step_s:
                raise UserError(
                    "{where}: duration_s is {lasts_s:g}, but the plate and its connection need "
                    "{shortest_step_s:.4g} or more",
                    where=self.where,
                    lasts_s=lasts_s,
                    shortest_step_s=modulator.shortest_step_s,
                )
            return 1, lasts_s or max(self.transition_s, HELD_S)
        most = math.floor(self.transition_s / step_s + 1e-9)
        steps = [self.transition_s / pieces for pieces in range(FEWEST_PIECES, most + 1)]
        if lasts_s is None:
            return most, steps[-1]
        error_s, each_s = min((abs(round(lasts_s / each) * each - lasts_s), each) for each in steps)
        if error_s > DURATION_ERROR_S:
            possible_s = round(lasts_s / each_s) * each_s
            raise UserError(
                "{where}: duration_s is {lasts_s:g}, but a linear transition is played in equal "
                "steps; the nearest duration is {possible_s:.4g}",
                where=self.where,
                lasts_s=lasts_s,
                possible_s=possible_s,
            )
        return round(self.transition_s / each_s), each_s
