"""Measure and record the finger's contact during explorations and answers.

Each step's samples are written to the journal (docs/decisions/one-journal.md) before the step's
answer. The samples of an interrupted step are kept and marked as such.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING

from slipscale.experiments.steps.steps import Ask, Explore
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.experiments.journal.journal import Journal
    from slipscale.experiments.participants.base import Watch
    from slipscale.hardware.contact.source import ContactSource, Kind, Sample

# Maximum number of samples per record; longer series are split.
A_RECORD = 2000
TIME_DIGITS, VALUE_DIGITS = 4, 4


class Contact:
    """A session's finger-position and force sources.

    Parameters
    ----------
    sources : Mapping
        Connected sources; empty if nothing is measured.
    journal : Journal
    follow : callable
        Called in every frame for each source, with the source's kind and new samples. Returns the
        times at which these samples triggered a texture change, or None if the source cannot
        trigger changes.
    """

    def __init__(
        self,
        sources: Mapping[Kind, ContactSource],
        journal: Journal,
        follow: Callable[[Kind, list[Sample]], list[float] | None],
    ) -> None:
        self._sources = sources
        self._journal = journal
        self._follow = follow
        self.last: dict[Kind, list[Sample]] = {}  # samples of the last completed step

    @contextmanager
    def measured(self, step: Explore | Ask, watch: Watch) -> Iterator[Watch]:
        """Record samples during a step, in a ``with`` block.

        Yields a function that calls ``watch`` and records the new samples. Call this function on
        every frame.

        Raises
        ------
        SensorFault
            If the connection to a source was lost. The source is reconnected when the step is
            repeated.
        """
        if not self._sources or step.trial is None:
            yield watch
            return
        for source in self._sources.values():
            source.begin()
        traces = [_Trace(kind, source, step) for kind, source in self._sources.items()]
        try:
            yield partial(self._look, watch, traces)
            for trace in traces:
                trace.take()
        except UserError:
            raise  # usually the journal itself failed, so nothing can be recorded
        except BaseException:
            for trace in traces:
                trace.write(self._journal, ends="broken off")
            raise
        for trace in traces:
            trace.write(self._journal, ends="whole")
        self.last = {trace.kind: trace.whole for trace in traces}

    def _look(self, watch: Watch, traces: list[_Trace]) -> None:
        """Process one frame: call ``watch``, then fetch new samples and record them."""
        watch()
        for trace in traces:
            new = trace.take()
            trace.note_changes(self._follow(trace.kind, new))
            trace.write_full(self._journal)


class _Trace:
    """Samples from one source during one step that have not been written yet."""

    def __init__(self, kind: Kind, source: ContactSource, step: Explore | Ask) -> None:
        self.kind = kind
        self._source = source
        self._step = step
        self.whole: list[Sample] = []
        self._samples: list[Sample] = []
        self._changes_s: list[float] | None = None
        self._unreadable = source.unreadable  # number before the step

    def take(self) -> list[Sample]:
        """Fetch and return the new samples from the source."""
        new = self._source.take()
        self._samples += new
        self.whole += new
        return new

    def note_changes(self, times_s: list[float] | None) -> None:
        """Add the times at which this source triggered texture changes, unless they are None."""
        if times_s is not None:
            self._changes_s = [*(self._changes_s or ()), *times_s]

    def write_full(self, journal: Journal) -> None:
        """Write a journal record if enough samples have accumulated."""
        if len(self._samples) >= A_RECORD:
            self.write(journal, ends="")

    def write(self, journal: Journal, *, ends: str) -> None:
        """Write the samples; ``ends`` states how the step ended, or is "" if it continues."""
        samples, self._samples = self._samples, []
        begun_s = samples[0].time_s if samples else 0.0
        quantities = self._source.quantities
        changes_s, self._changes_s = self._changes_s, None
        unreadable = self._source.unreadable - self._unreadable
        self._unreadable += unreadable
        journal.append(
            "contact",
            source=self.kind,
            trial=self._step.trial.number if self._step.trial else None,
            during="exploration" if isinstance(self._step, Explore) else "answer",
            ends=ends,
            begun_s=begun_s,
            times_s=[round(each.time_s - begun_s, TIME_DIGITS) for each in samples],
            values={
                name: [round(each.values[place], VALUE_DIGITS) for each in samples]
                for place, name in enumerate(quantities)
            },
            **({"unreadable": unreadable} if unreadable else {}),
            **(
                {}
                if changes_s is None
                else {"changes_s": [round(each - begun_s, TIME_DIGITS) for each in changes_s]}
            ),
        )
