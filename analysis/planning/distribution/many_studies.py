"""Simulate studies, each with its own seed, and collect their results."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from slipscale.analysis.pipeline import analyse
from slipscale.analysis.planning.distribution.numbers import Findings, findings
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.bare_dataset import why_sessions, write_simulated
from slipscale.experiments.running.pilot import pilot_plans, simulated_plate
from slipscale.experiments.running.rehearsal import check_answered, check_supported
from slipscale.experiments.study.file import study_hash
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError

#: Version of the algorithm that derives seeds. Each version gives every study a different seed.
VERSION = 1
SEED_DIGITS = 12  # Hexadecimal digits; a seed of this length is short enough to type.
HOUR_S = 3600.0


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyResult:
    """Result from one simulated study.

    Parameters
    ----------
    number : int
        Number of the study, from 1.
    seed : int
        Seed for repeating exactly this study with ``slipscale pilot STUDY --seed``.
    found : Findings
        Results of the study; empty if the analysis rejected the data.
    refused : str
        Reason why the analysis rejected the data; empty if it did not.
    """

    number: int
    seed: int
    found: Findings = field(default_factory=Findings)
    refused: str = ""


@dataclass(frozen=True, kw_only=True)
class ManyStudies:
    """Settings for simulating one study many times.

    Parameters
    ----------
    study_name : str
        Path of a study file, or the name of a study that comes with Slipscale.
    population : Population
    participants, language
        Values that override the study file.
    seed : int or None
        Random seed that overrides the study file; the seeds of all simulated studies are derived
        from this seed.
    """

    study_name: str
    population: Population
    participants: int | None = None
    language: str | None = None
    seed: int | None = None

    @cached_property
    def plans(self) -> list[RunPlan]:
        """The runs in a pilot of the study, with the overriding settings."""
        return pilot_plans(
            self.study_name,
            participants=self.participants,
            seed=self.seed,
            language=self.language,
            population=self.population,
        )

    @property
    def people(self) -> int:
        """Number of participants in each simulated study."""
        return len({plan.participant for plan in self.plans})

    @cached_property
    def why_sessions(self) -> str:
        """Reason why full sessions are simulated; empty if the fast simulation is equivalent."""
        return why_sessions(self.plans[0])

    def check(self) -> None:
        """Raise `UserError` if a pilot of the study would be rejected."""
        plan = self.plans[0]
        check_supported(plan, simulated_plate(plan))
        check_answered(plan)

    def seed_of(self, number: int) -> int:
        """Derive a simulated study's seed from the SHA-256 of its number and all settings."""
        first = self.plans[0]
        content = {
            "version": VERSION,
            "study": study_hash(first.study_text),
            "participants": self.people,
            "language": first.language,
            "population": first.population,
            "seed": first.seed,
            "number": number,
        }
        digest = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
        return int(digest[:SEED_DIGITS], 16)

    def compute(self, number: int) -> StudyResult:
        """Simulate one study and analyse it, as `slipscale pilot` and `slipscale analyse` would."""
        seed = self.seed_of(number)
        plans = [replace(plan, seed=seed) for plan in self.plans]
        with tempfile.TemporaryDirectory(prefix="slipscale-") as folder_name:
            folder = Path(folder_name) / "study"
            write_simulated(folder, plans, self.population, sessions=bool(self.why_sessions))
            try:
                return StudyResult(number=number, seed=seed, found=findings(analyse(folder)))
            except UserError as error:
                message = str(error).replace(f"{folder}: ", "")
                return StudyResult(number=number, seed=seed, refused=message)


def results(
    studies: ManyStudies, times: int, *, jobs: int = 1, patient: bool = False
) -> Iterator[StudyResult]:
    """Yield the results of studies 1, 2, ... in order, each as soon as it is available.

    Parameters
    ----------
    studies : ManyStudies
    times : int
        Number of studies.
    jobs : int
        Number of processes; -1 for one per processor.
    patient : bool
        Whether to run simulations that take more than an hour.

    Raises
    ------
    UserError
        If the simulation would take more than an hour and `patient` is False.
    """
    began_s = time.perf_counter()
    yield studies.compute(1)  # Slower than later studies, because of imports and tables.
    if times == 1:
        return
    again_s = time.perf_counter()
    yield studies.compute(2)
    study_s = time.perf_counter() - again_s
    left_s = study_s * (times - 2) / workers(jobs)
    if left_s + again_s - began_s > HOUR_S and not patient:
        raise UserError(
            "--times {times}: the simulation takes about {hours:.1f} hours on this computer "
            "({study_s:.1f} s per study); add --yes to allow this, or use --jobs or a smaller "
            "number",
            times=times,
            hours=left_s / HOUR_S,
            study_s=study_s,
        )
    left = range(3, times + 1)
    if jobs == 1 or len(left) < 2:  # noqa: PLR2004 - nothing to distribute
        yield from map(studies.compute, left)
        return
    from joblib import Parallel, delayed

    yield from Parallel(n_jobs=jobs, return_as="generator")(
        delayed(studies.compute)(number) for number in left
    )


def workers(jobs: int) -> int:
    """Return the number of processes that ``--jobs`` requests."""
    return (os.cpu_count() or 1) if jobs == -1 else jobs
