"""Question answered by pointing from a start to a target."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.columns import Column, TrialRecord
from slipscale.experiments.steps.questions.base import Question
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.screens.scene import Box, Colour, Disc, Item, Scene, Text
from slipscale.experiments.steps.screens.screen import Screen
from slipscale.experiments.steps.screens.screen_texts import go_on_key, naming_key, remaining
from slipscale.experiments.steps.simulated_person import Draws, SimulatedPerson
from slipscale.experiments.steps.trial import Value

BAR_HEIGHT, CURSOR = 0.4, 0.012
#: Simulated people: movement time = INTERCEPT_S + SLOPE_S_PER_BIT * index of difficulty, close to
#: the throughput of 6.95 bit/s by touch (MacKenzie 2015, INTERACT, LNCS 9297). The spread is our
#: assumption.
INTERCEPT_S, SLOPE_S_PER_BIT, SPREAD = 0.05, 0.125, 0.15
#: Ratio of effective width to standard deviation, at which 4 % of the selections miss the target.
WIDTH_IN_SD = math.sqrt(2 * math.pi * math.e)


class Selection(NamedTuple):
    """The position selected in a `PointingQuestion`, and the duration of the movement."""

    x_mm: float
    y_mm: float
    time_s: float

    @classmethod
    def of(cls, value: Value) -> Selection | None:
        """Parse the value of a reply, or return None if nothing was selected."""
        return cls(*map(float, value.split())) if isinstance(value, str) else None

    @property
    def value(self) -> str:
        """The selection as text, for `Reply.value`."""
        return " ".join(f"{number:.6f}" for number in self)


@dataclass(frozen=True, slots=True)
class _Selected:
    """The value of a column: a part of a selection. Unlike a closure, it can be pickled."""

    name: str
    part: str

    def __call__(self, record: TrialRecord) -> float | None:
        found = Selection.of(record.answer(self.name))
        return None if found is None else float(getattr(found, self.part))


@dataclass(frozen=True, slots=True, kw_only=True)
class PointingQuestion(Question):
    """Question answered by pointing from a start to a target; the reply is a `Selection`.

    Parameters
    ----------
    prompt : str
        The instruction.
    start_mm, target_mm : tuple of float
        Centres of the start and the target relative to the middle of the screen; positive values
        are to the right and upwards.
    width_mm : float
        Width of each bar, or diameter of each disc.
    bars : bool
        If True, the start and the target are vertical bars, and only the horizontal position
        counts. If False, the start and the target are discs.
    screen_height_mm : float
        Movement in mm that corresponds to the height of the screen.
    """

    EXPECTED: ClassVar = "a selection"
    start_mm: tuple[float, float]
    target_mm: tuple[float, float]
    width_mm: float
    bars: bool
    screen_height_mm: float

    def holds(self, centre_mm: tuple[float, float], x_mm: float, y_mm: float) -> bool:
        """Return whether a position is within the bar or disc that is centred at ``centre_mm``."""
        x, y = centre_mm
        away_mm = abs(x_mm - x) if self.bars else math.hypot(x_mm - x, y_mm - y)
        return away_mm <= self.width_mm / 2

    def fits(self, value: object) -> bool:
        """Return whether a value is a selection."""
        return isinstance(value, str) and Selection.of(value) is not None

    def rehearsed(self, place: float, /) -> Value:
        """Return the middle of the target, reached after 1 to 2 s."""
        return Selection(*self.target_mm, time_s=1.0 + place).value

    def movement_s(self, value: Value, /) -> float:
        """Return the movement's duration; the time until then is the time to reach the start."""
        moved = Selection.of(value)
        return moved.time_s if moved else 0.0

    def screen(self, texts: Texts, time_limit_s: float | None, _back: bool, /) -> Screen:
        """Return the screen with start and target."""
        return Pointing(self, texts, time_limit_s)

    def simulated(self, person: SimulatedPerson, _name: str, /) -> Value:
        """Return a selection after a movement at the person's pace."""
        return self.moved(person.stream("movement"), person.pace).value

    @classmethod
    def columns(cls, name: str, /) -> dict[str, Column]:
        """Return the columns of the selected position and the duration of the movement."""

        def selected(part: str, description: str, units: str) -> Column:
            return Column(value=_Selected(name, part), description=description, units=units)

        time = selected("time_s", "Time between selecting the start and the next selection", "s")
        places = {
            f"{name}_{axis}_mm": selected(
                f"{axis}_mm",
                f"{along} coordinate of the selected position relative to the middle of the "
                f"screen, positive towards the {way}",
                "mm",
            )
            for axis, along, way in (("x", "Horizontal", "right"), ("y", "Vertical", "top"))
        }
        return {"movement_time": time, **places}

    def moved(self, draws: Draws, pace: float) -> Selection:
        """Draw a movement time from Fitts's law, and an endpoint with a typical spread."""
        bits = math.log2(math.dist(self.start_mm, self.target_mm) / self.width_mm + 1)
        spread = math.exp(SPREAD * draws.normal())
        time_s = (INTERCEPT_S + SLOPE_S_PER_BIT * bits) * pace * spread
        x_mm, y_mm = (
            each + self.width_mm / WIDTH_IN_SD * draws.normal() for each in self.target_mm
        )
        return Selection(x_mm, y_mm, time_s)


class Pointing(Screen):
    """Screen for a pointing movement from a start to a target.

    The movement begins when the start is selected, and ends with the next selection. A click or
    touch selects the position at which it occurs. If a sensor measures the finger's position, the
    screen shows this position, and the continue key selects it.
    """

    pointed = True

    def __init__(
        self, question: PointingQuestion, texts: Texts, time_limit_s: float | None
    ) -> None:
        super().__init__(texts, time_limit_s)
        self._question = question
        self._began_s: float | None = None
        self._cursor_mm: tuple[float, float] | None = None

    def scene(self, elapsed_s: float) -> Scene:
        """Return the instruction, start, target and cursor, with the next item highlighted."""
        question, moving = self._question, self._began_s is not None
        start = self._mark(question.start_mm, "quiet" if moving else "accent")
        target = self._mark(question.target_mm, "accent" if moving else "quiet")
        foot = "window.point" if self._cursor_mm is None else "window.point_key"
        return (
            Text(content=question.prompt.strip(), y=0.42, width=1.2, height=0.1),
            start,
            target,
            *self._cursor(),
            scene.hint(naming_key(self.texts, foot)),
            *remaining(self.limit_s, elapsed_s, self.texts, y=0.34),
        )

    def see(self, x_mm: float, y_mm: float) -> None:
        """Move the cursor to the finger's measured position."""
        self._cursor_mm = x_mm, y_mm

    def press(self, character: str, elapsed_s: float) -> Reply | None:
        """Select the cursor's position if the pressed key is the continue key."""
        if self._cursor_mm is None or character.casefold() != go_on_key(self.texts):
            return None
        return self._select(*self._cursor_mm, elapsed_s)

    def point(self, x: float, y: float, elapsed_s: float, *, dragged: bool) -> Reply | None:
        """Select the position at which a click or touch occurs."""
        height_mm = self._question.screen_height_mm
        return None if dragged else self._select(x * height_mm, y * height_mm, elapsed_s)

    def _select(self, x_mm: float, y_mm: float, elapsed_s: float) -> Reply | None:
        """Begin the movement if the start is selected. Any later selection ends the movement."""
        if self.expire(elapsed_s):
            return None
        if self._began_s is not None:
            return Reply(value=Selection(x_mm, y_mm, elapsed_s - self._began_s).value)
        if self._question.holds(self._question.start_mm, x_mm, y_mm):
            self._began_s = elapsed_s
        return None

    def _mark(self, centre_mm: tuple[float, float], colour: Colour) -> Item:
        height_mm = self._question.screen_height_mm
        x, y = (each / height_mm for each in centre_mm)
        size = self._question.width_mm / height_mm
        if self._question.bars:
            return Box(x=x, y=y, width=size, height=BAR_HEIGHT, colour=colour)
        return Disc(x=x, y=y, diameter=size, colour=colour)

    def _cursor(self) -> Scene:
        if self._cursor_mm is None:
            return ()
        x, y = (each / self._question.screen_height_mm for each in self._cursor_mm)
        return (Disc(x=x, y=0.0 if self._question.bars else y, diameter=CURSOR, colour="text"),)
