"""Inject faults at chosen commands, for tests and dry runs.

A fault is written as ``NAME@PHASE/N`` (at the N-th command of a phase), ``NAME@N`` (at the N-th
command of all phases), ``NAME@PHASE`` or ``NAME`` (at the first command). Several faults are joined
with ``+``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import dataclass

from slipscale.faults.message import Message

EVERY = ""  # phase of faults that are counted over the commands of all phases


@dataclass(frozen=True, slots=True)
class Injection:
    """Fault to inject at the ``n``-th command of a phase."""

    fault: str
    phase: str = EVERY
    n: int = 1


def parse_injections(
    text: str, *, faults: Collection[str], phases: Collection[str]
) -> tuple[Injection, ...]:
    """Parse the text that lists the faults to inject.

    Raises
    ------
    ValueError
        If the text is invalid. The message describes the expected format.

    Examples
    --------
    >>> parse_injections("lost@present/3", faults=["lost"], phases=["present"])
    (Injection(fault='lost', phase='present', n=3),)
    """
    return tuple(_parse(word, faults, phases) for word in text.split("+"))


def _parse(word: str, faults: Collection[str], phases: Collection[str]) -> Injection:
    fault, _, place = word.partition("@")
    phase, slash, count = (place, "/", "1") if place in phases else place.rpartition("/")
    if (
        fault not in faults
        or (slash and phase not in phases)
        or (place and not (count.isascii() and count.isdigit() and int(count) > 0))
    ):
        raise ValueError(
            Message(
                "expected FAULT, FAULT@N, FAULT@PHASE or FAULT@PHASE/N; faults: {faults}; "
                "phases: {phases}",
                faults=", ".join(sorted(faults)),
                phases=", ".join(sorted(phases)),
            )
        )
    return Injection(fault, phase, int(count) if place else 1)


class Schedule:
    """Schedule that determines the faults to inject at each command.

    >>> schedule = Schedule([Injection("lost", "present", 2)])
    >>> [schedule.due(phase) for phase in ("present", "read_back", "present")]
    [[], [], ['lost']]
    """

    def __init__(self, injections: Iterable[Injection] = ()) -> None:
        self._injections = list(injections)
        self._counts: Counter[str] = Counter()

    def add(self, injection: Injection) -> None:
        """Add a fault to inject, counting only commands after this call."""
        later = self._counts[injection.phase] + injection.n
        self._injections.append(Injection(injection.fault, injection.phase, later))

    def clear(self) -> None:
        """Remove all pending injections."""
        self._injections.clear()

    def due(self, phase: str, *, everywhere: bool = True) -> list[str]:
        """Count a command that belongs to a phase, and return the faults to inject at this command.

        If ``everywhere`` is False, the command does not count for faults without a phase.
        """
        counted = [phase, EVERY] if everywhere else [phase]
        self._counts.update(counted)
        return [
            each.fault
            for each in self._injections
            if each.phase in counted and each.n == self._counts[each.phase]
        ]
