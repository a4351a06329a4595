"""The trials of a task, counted: one that is voided comes again under a number of its own."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from typing import TYPE_CHECKING, Generic, TypeVar

from slipscale.experiments.protocols.steps import EndBlock, Instruct, Voided

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable

    from slipscale.experiments.languages.texts import Texts
    from slipscale.experiments.protocols.steps import Answer, Rest, Step, Steps

Condition = TypeVar("Condition")
# What makes a trial, and the number of the trial that it repeats.
Repetition = tuple[Condition, int]


class Repeating(ABC, Generic[Condition]):
    """The trials of a task, block by block.

    ``Condition`` is what makes a trial (surface, block, phase, ...); a repetition has the same,
    whenever it comes.

    Parameters
    ----------
    total : int
        How many trials the task has if none is repeated.
    """

    def __init__(self, total: int) -> None:
        self.total = total
        self.number = 0
        self._known: dict[int, Condition] = {}
        self._draw: Callable[[], Condition | None] = lambda: None

    @abstractmethod
    def trial(
        self, condition: Condition, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield one trial; return the numbers of the trials to be repeated."""

    def start(self) -> Steps:
        """Yield what comes before the first of some trials: nothing, by default."""
        yield from ()

    def between(self) -> Steps:
        """Yield what comes after each trial: nothing, by default."""
        yield from ()

    def finish(self) -> Steps:
        """Yield what comes after the last of some trials: nothing, by default."""
        yield from ()

    def block(self, conditions: Iterable[Condition]) -> Steps:
        """Yield a block's trials, and at its end those to be repeated."""
        rest = iter(conditions)
        yield from self.drawn(lambda: next(rest, None))

    def drawn(self, draw: Callable[[], Condition | None]) -> Steps:
        """Yield a block's trials, each condition drawn when the trial before it is over.

        So it may depend on all answers until then; None ends the block. It is drawn again where
        the screen after the block voids a trial.
        """
        self._draw = draw
        yield from self._trials(deque())

    def close(self, screen: Callable[[], Instruct | Rest]) -> Steps:
        """Yield the screen that follows a block; repeat what is voided while it is shown.

        The screen is shown again after that: it tells where the participant stands.
        """
        while isinstance(reply := (yield EndBlock(screen=screen())), Voided) and reply.trials:
            yield from self._trials(self.again(reply.trials))

    def again(self, numbers: Iterable[int]) -> deque[Repetition[Condition]]:
        """Return what is to be repeated for these trials, at the end of the block."""
        repetitions = deque((self._known[number], number) for number in numbers)
        self.total += len(repetitions)
        return repetitions

    def _trials(self, repetitions: deque[Repetition[Condition]]) -> Steps:
        yield from self.start()
        while True:
            condition, repeats = self._draw(), None
            if condition is None:
                if not repetitions:
                    break
                condition, repeats = repetitions.popleft()
            self.number += 1
            self._known[self.number] = condition
            repetitions += self.again((yield from self.trial(condition, self.number, repeats)))
            yield from self.between()
        yield from self.finish()


def part_over(texts: Texts) -> Instruct:
    """Return the screen at a task's end: until it is left, the last trial can be repeated."""
    return Instruct(title=texts["session.part_over_title"], text=texts["session.part_over"])
