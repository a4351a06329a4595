"""Number the trials of a task, and repeat voided trials under new numbers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Generator, Iterable
from typing import Generic, TypeVar

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.replies import Answer, Voided
from slipscale.experiments.steps.steps import EndBlock, Instruct, Rest, Step, Steps

Condition = TypeVar("Condition")
# The definition of a trial, and the number of the trial that it repeats.
Repetition = tuple[Condition, int]


class Repeating(ABC, Generic[Condition]):
    """Trials of a task, run in blocks, with repetitions of voided trials.

    An object of type ``Condition`` defines a trial, for example by its surface, block and phase. A
    repeated trial has the same condition as the original trial.

    Parameters
    ----------
    total : int
        Number of trials in the task if no trial is repeated.
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
        """Yield a trial's steps, and return the numbers of the trials to repeat."""

    def start(self) -> Steps:
        """Yield the steps before a group of trials (by default, none)."""
        yield from ()

    def between(self) -> Steps:
        """Yield the steps after each trial (by default, none)."""
        yield from ()

    def finish(self) -> Steps:
        """Yield the steps after a group of trials (by default, none)."""
        yield from ()

    def block(self, conditions: Iterable[Condition]) -> Steps:
        """Yield a block's trials, followed by their repetitions."""
        rest = iter(conditions)
        yield from self.drawn(lambda: next(rest, None))

    def drawn(self, draw: Callable[[], Condition | None]) -> Steps:
        """Yield the trials of a block whose conditions are selected one at a time.

        Before each trial, ``draw`` returns the trial's condition, which may depend on all earlier
        answers, or None to end the block. If a trial is voided while `close` shows its screen,
        ``draw`` is called again.
        """
        self._draw = draw
        yield from self._trials(deque())

    def close(self, screen: Callable[[], Instruct | Rest]) -> Steps:
        """Show the screen after a block, and repeat trials that are voided while it is shown.

        After the repetitions, the screen is shown again with updated progress.
        """
        while isinstance(reply := (yield EndBlock(screen=screen())), Voided) and reply.trials:
            yield from self._trials(self.again(reply.trials))

    def again(self, numbers: Iterable[int]) -> deque[Repetition[Condition]]:
        """Schedule the given trials for repetition, and increase the total number of trials."""
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
    """Return the screen at the end of a task.

    The last trial can be repeated until this screen closes.
    """
    return Instruct(title=texts["session.part_over_title"], text=texts["session.part_over"])
