"""Ask for valence and arousal on a grid of nine by nine cells."""

from dataclasses import dataclass
from typing import ClassVar

from slipscale.question import (
    ENTER,
    Box,
    Column,
    Question,
    Refused,
    Reply,
    Screen,
    Text,
    TypedEntry,
    asked,
    button,
    go_on_key,
    remaining,
)

SIDE = 9
PITCH = 0.052  # distance between the centres of cells, in screen heights
EDGE = PITCH * SIDE / 2  # distance from the middle of the grid to its edge


def number_of(valence, arousal):
    """Return the number of a cell; cells are numbered from the lower left corner, row by row."""
    return float(SIDE * (arousal - 1) + valence)


def parts_of(number):
    """Return a cell's valence and arousal."""
    row, column = divmod(int(number) - 1, SIDE)
    return column + 1, row + 1


@dataclass(frozen=True, slots=True, kw_only=True)
class AffectGrid(Question):
    """Question answered by choosing a cell; the reply's value is the cell's number.

    ``left`` and ``right`` name the ends of valence, ``bottom`` and ``top`` those of arousal.
    ``how`` explains how to choose a cell.
    """

    EXPECTED: ClassVar = "the number of a cell, 1 to 81"
    SPOKEN: ClassVar = True  # An operator can type what a participant says, such as "7 5".
    left: str
    right: str
    bottom: str
    top: str
    how: str

    def fits(self, value):
        """Return whether a value is the number of a cell."""
        return type(value) in (int, float) and value in range(1, SIDE**2 + 1)

    def rehearsed(self, place, /):
        """Return the cell at a position in the order of numbers."""
        return float(1 + round(place * (SIDE**2 - 1)))

    def entry(self, _texts, /):
        """Return an answer field in which an operator types valence and arousal."""
        return TypedEntry(judge)

    def screen(self, texts, time_limit_s, _back, /):
        """Return the screen with the grid."""
        return Grid(self, texts, time_limit_s)

    def simulated(self, person, name, /):
        """Return a cell whose valence follows the sensation; the arousal is random."""
        valence = min(1 + int(person.rating(50.0) / 100 * SIDE), SIDE)
        return number_of(valence, 1 + person.stream(name, "arousal").below(SIDE))

    @classmethod
    def columns(cls, name, /):
        """Return the columns of valence and arousal."""

        def part(index):
            def value(record):
                number = record.answer(name)
                return None if number is None else parts_of(number)[index]

            return value

        return {
            "valence": Column(value=part(0), description="Valence: 1 (unpleasant) to 9 (pleasant)"),
            "arousal": Column(value=part(1), description="Arousal: 1 (sleepy) to 9 (excited)"),
        }


def judge(line):
    """Return the cell that two numbers from 1 to 9 name, or the reason why they name none."""
    words = line.split()
    if len(words) == 2 and all(word in "123456789" for word in words):  # noqa: PLR2004
        return Reply(value=number_of(*map(int, words)))
    blanks = {"entry": line, "minimum": "1", "maximum": str(SIDE)}
    return Refused(line, "window.out_of_bounds", blanks)


class Grid(Screen):
    """Screen with the grid: a click, a touch or the arrow keys choose a cell."""

    pointed = True

    def __init__(self, question, texts, time_limit_s):
        super().__init__(texts, time_limit_s)
        self.question = question
        self.chosen = None
        self.missed = False

    def scene(self, elapsed_s):
        """Return the question, the grid with its labels, and how to answer."""
        question, edge = self.question, EDGE
        beside = {"size": 0.034, "width": 0.3, "height": 0.2}
        return (
            asked(question.prompt, y=0.43),
            Text(content=question.top, y=edge + 0.035, **beside),
            Text(content=question.bottom, y=-edge - 0.03, **beside),
            Text(content=question.left, y=0.0, x=-edge - 0.18, **beside),
            Text(content=question.right, y=0.0, x=edge + 0.18, **beside),
            *(self._cell(column, row) for row in range(SIDE) for column in range(SIDE)),
            Text(
                content=question.how,
                y=-0.33,
                size=0.034,
                colour="accent" if self.missed else "quiet",
            ),
            *button(self.texts["window.go_on"], ENTER, x=0, y=-0.42, width=0.5, height=0.08),
            *remaining(self.limit_s, elapsed_s, self.texts, y=0.36),
        )

    def _cell(self, column, row):
        chosen = self.chosen == (column + 1, row + 1)
        middle = (SIDE - 1) / 2
        return Box(
            x=PITCH * (column - middle),
            y=PITCH * (row - middle),
            width=0.9 * PITCH,
            height=0.9 * PITCH,
            colour="accent" if chosen else "field",
        )

    def point(self, x, y, _elapsed_s, *, dragged):  # noqa: ARG002 - dragging chooses, too
        """Choose the cell at a point."""
        column, row = (int(each // PITCH + 1) for each in (x + EDGE, y + EDGE))
        if 1 <= column <= SIDE and 1 <= row <= SIDE:
            self.chosen, self.missed = (column, row), False

    def move(self, notches):
        """Choose a cell further right."""
        self._go(notches, 0)

    def turn(self, notches):
        """Choose a cell further up."""
        self._go(0, notches)

    def _go(self, right, up):
        valence, arousal = self.chosen or ((SIDE + 1) // 2, (SIDE + 1) // 2)
        moved = (valence + right, arousal + up)
        self.chosen = tuple(min(max(each, 1), SIDE) for each in moved)
        self.missed = False

    def press(self, character, elapsed_s):
        """Submit the chosen cell on Enter or the key to continue."""
        if character.casefold() not in (ENTER, "\n", go_on_key(self.texts)):
            return None
        if self.expire(elapsed_s):
            return None
        self.missed = self.chosen is None
        return None if self.missed else Reply(value=number_of(*self.chosen))

    @property
    def typed(self):
        """The chosen cell, which is restored after an interruption."""
        return "" if self.chosen is None else "{} {}".format(*self.chosen)

    def offer(self, typed):
        """Restore the cell that was chosen before an interruption."""
        if typed:
            self.chosen = tuple(int(word) for word in typed.split())
