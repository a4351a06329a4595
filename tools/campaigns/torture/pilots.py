"""Interrupt pilots at one point at a time, and compare them with an uninterrupted pilot."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING
from unittest import mock

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.journal import journal as journal_module
from slipscale.experiments.journal import plan_and_progress
from slipscale.experiments.running.pilot import pilot_plans, run_simulated
from slipscale.experiments.study.file import shipped_studies
from slipscale.faults import UserError
from slipscale.hardware import registry
from tools.campaigns.torture.disk_faults import FAULTS, GONE, Disk, Killed, below_the_journal

if TYPE_CHECKING:
    from slipscale.experiments.study.run_plan import RunPlan

EVERY_OPTION = Path(__file__).with_name("every_option.toml")


@dataclass
class Outcome:
    """Results of the campaign.

    Parameters
    ----------
    counts : Counter
        Number of cases by (fault, study).
    bad : list of tuple
        Fault and description of each case in which the data differ.
    """

    counts: Counter[tuple[str, str]] = field(default_factory=Counter)
    bad: list[tuple[str, str]] = field(default_factory=list)

    def judge(self, fault: str, plan: RunPlan, place: str, problem: str) -> None:
        """Count a case, and record its problem if there is one."""
        study = Path(plan.study_name).stem
        self.counts[fault, study] += 1
        if problem:
            who = f"participant {plan.participant}"
            self.bad.append((fault, f"{study}, {who}, {fault} {place}: {problem}"))


def studies() -> list[str]:
    """Return the campaign's studies: the shipped ones, and one that uses every option."""
    return [*shipped_studies(), str(EVERY_OPTION)]


def plans_of(study: str, participants: int) -> list[RunPlan]:
    """Return the plans of a study's pilot: each participant's sessions and runs."""
    return pilot_plans(study, participants=participants, seed=None, language=None)


@contextmanager
def folder() -> Iterator[Path]:
    """Create a temporary folder, in memory if possible because of the many writes."""
    shared = Path("/dev/shm")  # noqa: S108 - no secret is in it
    with tempfile.TemporaryDirectory(dir=shared if shared.is_dir() else None) as name:
        yield Path(name)


def content(dataset: Path) -> dict[str, bytes]:
    """Build a data set from its journals; return its files.

    Raises
    ------
    UserError
        If a journal is damaged, or tables do not match their journal.
    """
    if problems := build_dataset(dataset):
        raise UserError("; ".join(str(problem) for problem in problems))
    files = (path for path in dataset.rglob("*") if path.is_file())
    return {
        path.relative_to(dataset).as_posix(): path.read_bytes()
        for path in files
        if "sourcedata" not in path.parts and not path.name.endswith(".tmp")
    }


def difference(dataset: Path, expected: dict[str, bytes]) -> str:
    """Describe how a data set's files differ from the expected ones; empty if they do not."""
    try:
        found = content(dataset)
    except Exception as error:  # noqa: BLE001 - any exception is a problem
        return repr(error)
    names = sorted({*found, *expected})
    return ", ".join(name for name in names if found.get(name) != expected.get(name))


@contextmanager
def looked_up_once() -> Iterator[None]:
    """Cache look-ups of installed packages, which thousands of runs would otherwise repeat."""
    with ExitStack() as stack:
        for module, name in ((registry, "entry_points"), (plan_and_progress, "version")):
            stack.enter_context(mock.patch.object(module, name, cache(getattr(module, name))))
        yield


def undisturbed(plan: RunPlan) -> tuple[dict[str, bytes], int]:
    """Run a plan without faults; return the data set and the number of writes."""
    disk = Disk("none", -1)
    with folder() as dataset, below_the_journal(disk):
        run_simulated(dataset, plan, "mock", synced=True)
        return content(dataset), disk.writes


def disturbed(dataset: Path, plan: RunPlan, disk: Disk, kept: list[Path]) -> Path:
    """Run a pilot on a disk and resume it until it is complete; return its journal's path."""
    with (
        below_the_journal(disk),
        mock.patch.object(journal_module, "fallback_folders", return_value=kept),
    ):
        while disk.at >= 0:
            try:
                run_simulated(dataset, plan, "mock", synced=True)
                break
            except (Killed, UserError):
                disk.revive()
        else:
            run_simulated(dataset, plan, "mock", synced=True)
    return kept[0] if disk.fault in GONE and disk.struck else dataset


def spread(length: int, places: int, turn: int) -> range:
    """Return ``places`` evenly spaced positions in a run, or all positions if ``places`` is 0.

    Positions are shifted by ``turn``, the index of the fault, so that faults occur at different
    positions.
    """
    stride = max(length // places, 1) if places else 1
    return range(turn % stride, length, stride)


def disk_campaign(plan: RunPlan, places: int, outcome: Outcome) -> None:
    """Apply every disk fault to a pilot, each at ``places`` different writes."""
    expected, writes = undisturbed(plan)
    for turn, fault in enumerate(FAULTS):
        for at in spread(writes, places, turn):
            disk = Disk(fault, at)
            with folder() as made:
                try:
                    found = disturbed(made / "a", plan, disk, [made / "kept"])
                    problem = difference(found, expected)
                except Exception as error:  # noqa: BLE001 - any exception is a problem
                    problem = repr(error)
            outcome.judge(
                fault, plan, f"at write {at}", problem or ("" if disk.struck else "no fault")
            )
