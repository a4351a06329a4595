"""Public functions in the ``slipscale`` namespace that combine several packages.

`slipscale.load` and `slipscale.analyse` are aliases of `slipscale.analysis.load.load` and
`slipscale.analysis.pipeline.analyse`.
"""

from __future__ import annotations

import atexit
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from slipscale.experiments.study import file as study_file
from slipscale.faults import UserError

if TYPE_CHECKING:
    import numpy as np

    from slipscale.analysis.planning.power.answers import Row
    from slipscale.analysis.planning.power.design import Design
    from slipscale.analysis.reconstruction.answers import ColumnAnswer
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
    from slipscale.analysis.tasks.kind import Analysis
    from slipscale.experiments.study.model import Study
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.driver import PlateDriver


def read_study(study: str | Path) -> Study:
    """Read and validate a study.

    Parameters
    ----------
    study : str or Path
        A TOML file, or the name of a study that comes with Slipscale.

    Raises
    ------
    UserError
        If the study does not exist or its file has errors. The message lists all errors.

    Examples
    --------
    >>> read_study("biet2007").levels
    (0.0, 0.5, 1.2, 2.3)
    """
    return study_file.read_study(str(study))[0]


def pilot(
    study: str | Path = "biet2007",
    *,
    participants: int | None = None,
    seed: int | None = None,
    folder: str | Path | None = None,
) -> Analysis:
    """Run a study with simulated participants on the mock plate, and analyse it.

    Parameters
    ----------
    study : str or Path
        A TOML file, or the name of a study that comes with Slipscale.
    participants, seed : int, optional
        Number of participants and random seed; by default, the values in the study file.
    folder : str or Path, optional
        Folder for the data set, either new or with an interrupted pilot of the same study and seed.
        The default is a temporary folder, which is deleted when Python exits.

    Raises
    ------
    UserError
        If the study or the folder cannot be used.

    Examples
    --------
    >>> found = pilot("biet2007", participants=3, seed=1)
    >>> found.dataset.mode, found.table3["n"].tolist()
    ('pilot', [3, 3, 3, 3])
    """
    from slipscale.analysis.pipeline import analyse
    from slipscale.experiments.running.pilot import pilot_plans, run_pilot

    plans = pilot_plans(str(study), participants=participants, seed=seed, language=None)
    if folder is None:
        temporary = TemporaryDirectory(prefix="slipscale-pilot-")
        atexit.register(temporary.cleanup)
        folder = temporary.name
    run_pilot(Path(folder), plans, tell=lambda _: None)
    return analyse(folder)


@dataclass(frozen=True, slots=True, kw_only=True)
class Power:
    """Power of a study for several sample sizes.

    Parameters
    ----------
    design : Design
        The simulated design.
    rows : tuple of Row
        One row per number of participants.
    target : float
        The required power.
    """

    design: Design
    rows: tuple[Row, ...]
    target: float

    @property
    def enough(self) -> int | None:
        """Smallest sample size from which all comparisons reach the target power, or None."""
        from slipscale.analysis.planning.power.answers import fewest

        return next(iter(fewest(self.rows, self.target).values()))

    def __repr__(self) -> str:
        """Return a table of the power for each number of participants, and a conclusion."""
        from slipscale.analysis.planning.power.terminal import summary

        lines = [
            f"{row.condition.participants:>4} participants: power {row.weakest.value:.2f} "
            "for the weakest comparison"
            for row in self.rows
        ]
        return "\n".join([f"Power of {self.design.name}", *lines, summary(*self._asked)[0]])

    @property
    def _asked(self) -> tuple[Design, tuple[Row, ...], float]:
        return self.design, self.rows, self.target


def power(
    study: str | Path = "biet2007",
    *,
    participants: int | Sequence[int] = (6, 8, 10, 12, 16, 20, 24, 32),
    studies: int = 1000,
    seed: int = 2007,
    alpha: float = 0.05,
    target: float = 0.8,
    jobs: int = 1,
) -> Power:
    """Estimate power by simulating studies of several sample sizes.

    Parameters
    ----------
    study : str or Path
        A TOML file, or the name of a study that comes with Slipscale.
    participants : int or sequence of int
        Sample sizes to simulate.
    studies : int
        Number of simulated studies per sample size.
    seed : int
        Random seed of the simulation.
    alpha : float
        Significance level of the tests.
    target : float
        The required power.
    jobs : int
        Number of processes, or -1 to use all processors.

    Raises
    ------
    UserError
        If the study cannot be read, or an argument is out of range.

    Examples
    --------
    >>> power("biet2007", participants=[24], studies=100).enough
    24
    """
    from slipscale.analysis.planning.power import answers, grid, run_grid
    from slipscale.analysis.planning.power.design import design_of
    from slipscale.analysis.planning.power.shard import Looks
    from slipscale.experiments.participants.simulated_people.population import Population

    sizes = (participants,) if isinstance(participants, int) else tuple(participants)
    ranges = {
        "participants": (min(sizes, default=0) >= 1, list(sizes), "1 or more"),
        "studies": (studies >= 1, studies, "1 or more"),
        "seed": (seed >= 0, seed, "0 or more"),
        "alpha": (0 < alpha < 1, alpha, "a proportion above 0 and below 1"),
        "target": (0 < target < 1, target, "a proportion above 0 and below 1"),
        "jobs": (jobs >= 1 or jobs == -1, jobs, "1 or more, or -1 for all processors"),
    }
    if wrong := [
        f"{name} is {value}, expected {expected}"
        for name, (good, value, expected) in ranges.items()
        if not good
    ]:
        raise UserError("power: " + "; ".join(wrong))
    parsed, text = study_file.read_study(str(study))
    design = design_of(parsed, text, Population(), alpha)
    habits = design.population.habits
    wanted = [
        grid.Condition(
            participants=size,
            repetitions=design.task.repetitions,
            lapses=habits.lapses,
            dropout=habits.dropout,
        )
        for size in dict.fromkeys(sizes)
    ]
    looks = Looks()
    every = list(dict.fromkeys([*wanted, *grid.without_effect(wanted)]))
    outcomes = run_grid.run_grid(
        run_grid.shards(design, every, studies=studies, seed=seed, looks=looks), jobs=jobs
    )
    rows = answers.rows(design, wanted, outcomes, looks=looks)
    return Power(design=design, rows=tuple(rows), target=target)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reconstruction:
    """Raw data sets that are consistent with a published table.

    Parameters
    ----------
    title : str
        Title of the table.
    columns : tuple of ColumnAnswer
        Result for each column: whether its numbers are consistent, and the number of data sets that
        reproduce them.
    """

    title: str
    columns: tuple[ColumnAnswer, ...]
    _solutions: tuple[Solutions, ...]

    def sample(self, number: int = 1, seed: int = 1) -> dict[str, np.ndarray]:
        """Draw random data sets. All multisets of ratings are equally likely.

        Parameters
        ----------
        number : int
            Number of data sets per column.
        seed : int
            Random seed.

        Returns
        -------
        dict
            Arrays of ratings, keyed by column label, with shape (number, participants) and sorted
            rows. Columns that cannot be sampled are omitted.

        Raises
        ------
        UserError
            If the number or the seed is out of range.
        """
        import numpy as np

        from slipscale.analysis.reconstruction.data_sets.sampling import Sampler

        if number < 1 or seed < 0:
            raise UserError(
                "sample: number is {number} and seed is {seed}; expected a number of 1 or more "
                "and a seed of 0 or more",
                number=number,
                seed=seed,
            )
        found = {}
        for place, solutions in enumerate(self._solutions):
            if solutions.not_drawn or not solutions.consistent:
                continue
            scale = solutions.column.scale
            values = np.array([float(scale.value(step)) for step in range(scale.steps + 1)])
            # Draws the same samples as `slipscale reconstruct --sample`.
            drawn = Sampler(solutions).draw(number, np.random.default_rng([seed, place]))
            found[solutions.column.label] = values[drawn]
        return found

    def __repr__(self) -> str:
        """Return the number of data sets per column."""
        counts = [
            f"  {each.label}: {each.multisets:,} data sets"
            if each.multisets
            else f"  {each.label}: {each.reason or each.refused}"
            for each in self.columns
        ]
        return "\n".join([f"Reconstruction of {self.title or 'a published table'}", *counts])


def reconstruct(table: str | Path) -> Reconstruction:
    """Count the raw data sets that are consistent with a published table.

    Parameters
    ----------
    table : str or Path
        A TOML or CSV file, or the name of a shipped table: ``biet2007_table3``.

    Raises
    ------
    UserError
        If the table cannot be read.

    Examples
    --------
    >>> found = reconstruct("biet2007_table3")
    >>> found.columns[0].multisets
    40711
    >>> found.sample(5)["0 um"].shape
    (5, 12)
    """
    from slipscale.analysis.reconstruction.answers import column_answer
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
    from slipscale.analysis.reconstruction.table.table_files import read

    printed = read(Path(table))
    solutions = tuple(Solutions(column) for column in printed.columns)
    return Reconstruction(
        title=printed.title,
        columns=tuple(column_answer(each, "multisets") for each in solutions),
        _solutions=solutions,
    )


def open_plate(spec: str = "mock", *, clock: Clock | None = None, seed: int = 0) -> PlateDriver:
    """Return a context manager that connects a plate and always switches it off at the end.

    Parameters
    ----------
    spec : str
        ``mock``, ``serial:PORT``, ``scpi:RESOURCE``, or the name of another installed backend.
    clock : Clock, optional
        Source of time; by default, the computer's clock.
    seed : int
        Random seed of a simulated plate.

    Raises
    ------
    UserError
        If the backend is not installed.

    Examples
    --------
    >>> from slipscale.stimuli.surface import VirtualSurface
    >>> with open_plate("mock") as plate:
    ...     shown = plate.present(VirtualSurface(level=1.2))
    >>> shown.commanded_level
    1.2
    """
    from slipscale.hardware import registry
    from slipscale.hardware.clock import SystemClock

    return registry.open_plate(spec, clock=clock or SystemClock(), seed=seed)
