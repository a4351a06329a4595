"""What the quick benchmarks compare: functions of Slipscale, each with the usual alternative.

A row is a pair of functions. Commands run as child processes, as a user starts them.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # As the command sets it.

import numpy as np
import pandas as pd

from benchmarks import analyse_shares
from benchmarks.analyse_scale import environment, write_dataset
from benchmarks.models import FILM, marched, own_assembly, stock_assembly
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.foreign.files import read_rows
from slipscale.analysis.reading.foreign.layouts.table import layout_of
from slipscale.analysis.reading.meaning.keywords import mapping_of
from slipscale.analysis.writing.csv_file import write_csv
from slipscale.experiments.participants.simulated_people.bare_run import bare_run
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.pilot import pilot_plans, run_pilot, run_simulated
from slipscale.stimuli.film.periodic_film import periodic_state

Pair = tuple[Callable[[], object], Callable[[], object]]
PARTICIPANTS, ROWS = 400, 100_000
TABLE_PEOPLE, TABLE_ROWS = 20, 10_000
#: The main tests of a study and its figure, as a user would write them with pandas and pingouin.
BY_HAND = """
import sys, warnings
from pathlib import Path
import numpy as np, pandas as pd, pingouin as pg
import statsmodels.formula.api as smf
from matplotlib import pyplot as plt
warnings.simplefilter("ignore")
folder = Path(sys.argv[1])
paths = sorted(folder.glob("sub-*/beh/*magnitudeestimation*.tsv"))
rows = pd.concat([pd.read_csv(p, sep="\\t", na_values="n/a").assign(who=p.name[:6]) for p in paths])
rows = rows[rows["phase"] == "main"].reset_index(drop=True)
rows["log"] = np.log(rows["estimate"].clip(lower=1))
names = {"data": rows, "dv": "log", "within": "amplitude_um_pp", "subject": "who"}
pg.rm_anova(**names, correction=True)
pg.friedman(**names)
pg.pairwise_tests(**names, padjust="holm")
smf.mixedlm("log ~ np.log(amplitude_um_pp)", rows[rows["amplitude_um_pp"] > 0], groups="who").fit()
cells = rows.groupby("amplitude_um_pp")["estimate"].agg(["mean", "std"])
plt.errorbar(cells.index, cells["mean"], cells["std"])
plt.savefig(folder / "figure.svg")
"""
#: The packages that an analysis of estimates needs.
IMPORTS = "\n".join(
    f"import {module}"
    for modules in analyse_shares.IMPORTS.values()
    for module in modules
    if not module.startswith("slipscale")
)


def written_tables(folder: Path) -> tuple[Path, Path]:
    """Write 10,000 answers as one table, and as a folder with one table per person."""
    drawn, rows = np.random.default_rng(1), TABLE_ROWS // TABLE_PEOPLE
    answers = pd.DataFrame(
        {
            "who": np.repeat([f"p{person:02d}" for person in range(TABLE_PEOPLE)], rows),
            "trial": np.tile(np.arange(1, rows + 1), TABLE_PEOPLE),
            "level": drawn.choice([0.5, 1, 2, 4, 8, 16], TABLE_ROWS),
            "correct": drawn.integers(0, 2, TABLE_ROWS),
            "rt": drawn.random(TABLE_ROWS).round(4),
        }
    )
    one, several = folder / "answers.csv", folder / "answers"
    answers.to_csv(one, index=False)
    several.mkdir()
    for who, own in answers.groupby("who"):
        own.drop(columns="who").to_csv(several / f"{who}.csv", index=False)
    return one, several


def read_tables(path: Path, **options: object) -> object:
    """Read the columns that the options name, with Slipscale."""
    mapping = mapping_of({"stimulus": "level", "answer": "correct", **options})
    return read_rows([path], mapping, layout_of(mapping), Problems(), None)


def python(*words: str) -> Callable[[], object]:
    """Return a function that runs Python as a child process, with stored bytecode."""
    command = [sys.executable, *words]
    return lambda: subprocess.run(command, check=True, capture_output=True, env=environment())


def slipscale(*words: str, folder: Path | None = None) -> Callable[[], object]:
    """Return a function that runs a command of Slipscale as a child process."""
    command, about = [sys.executable, "-m", "slipscale", *words], environment()
    return lambda: subprocess.run(command, check=True, capture_output=True, env=about, cwd=folder)


def simulated(folder: Path, study: str, people: int) -> Path:
    """Simulate a study into an empty folder; return the folder."""
    plans = pilot_plans(study, participants=people, seed=1, language=None)
    run_pilot(folder, plans, tell=lambda _: None)
    return folder


def read_all(data: Path) -> object:
    """Read every table of a data set with pandas, in the loop that a user would write."""
    paths = sorted(data.glob("sub-*/beh/*.tsv"))
    return pd.concat([pd.read_csv(path, sep="\t", na_values=["n/a"]) for path in paths])


def guarded(folder: Path) -> dict[str, Pair]:
    """Return the pairs that `make benchmarks` compares with their record, keyed by benchmark."""
    data, table = folder / "data", folder / "table.csv"
    write_dataset(data, PARTICIPANTS, ROWS)
    rows = load(data).estimates
    one, several = written_tables(folder)
    pilot = simulated(folder / "pilot", "biet2007", 14)
    plan = pilot_plans("biet2007", participants=1, seed=1, language=None)[0]

    def session() -> None:
        with TemporaryDirectory() as empty:
            run_simulated(Path(empty), plan, "mock")

    analysis = slipscale("analyse", str(pilot), "--out", str(folder / "report"))
    return {
        "slipscale --help / python -c pass": (slipscale("--help"), python("-c", "pass")),
        "import slipscale / python -c pass": (
            python("-c", "import slipscale"),
            python("-c", "pass"),
        ),
        "study validate / pydantic and tomlkit": (
            slipscale("study", "validate", "biet2007"),
            python("-c", "import pydantic, tomlkit"),
        ),
        "analyse 14 people / pandas and pingouin by hand": (
            analysis,
            python("-c", BY_HAND, str(pilot)),
        ),
        "analyse 14 people / its imports": (analysis, python("-c", IMPORTS)),
        "load / read with pandas": (lambda: load(data), lambda: read_all(data)),
        "read a table of 10,000 rows / read with pandas": (
            lambda: read_tables(one, participant="who", trial="trial"),
            lambda: pd.read_csv(one),
        ),
        "read 20 tables of 500 rows / read with pandas": (
            lambda: read_tables(several, participant_from_name="", trial="trial"),
            lambda: pd.concat([pd.read_csv(path) for path in sorted(several.iterdir())]),
        ),
        "load and analyse / read with pandas": (lambda: analyse(data), lambda: read_all(data)),
        "write_csv / to_csv": (
            lambda: write_csv(rows, table),
            lambda: rows.to_csv(table, index=False),
        ),
        "pilot session / protocol and simulated person": (
            session,
            lambda: list(bare_run(plan, Population())),
        ),
        "periodic film / marching": (lambda: periodic_state(**FILM), marched),  # type: ignore[arg-type]
        "plate (five matrices) / scikit-fem (one matrix)": (own_assembly, stock_assembly),
    }


def slow(folder: Path) -> dict[str, Pair]:
    """Return the pairs that only ``--all`` measures, keyed by benchmark."""
    million, laboratory = folder / "million", folder / "laboratory"
    write_dataset(million, 4_000, 1_000_000)
    slipscale("lab", "init", str(laboratory))()
    packages = python("-c", "import pydantic, tomlkit")
    plans = pilot_plans("messaoud2016", participants=4, seed=1, language=None)

    def published() -> None:
        with TemporaryDirectory() as empty:
            simulated(Path(empty), "messaoud2016", 4)

    def piloted() -> None:
        with TemporaryDirectory() as empty:
            slipscale("pilot", "--participants", "12", "--out", f"{empty}/pilot")()

    return {
        "study show / pydantic and tomlkit": (slipscale("study", "show", "biet2007"), packages),
        "participants / pydantic and tomlkit": (
            slipscale("participants", folder=laboratory),
            packages,
        ),
        "pilot of 12 people / imports of its analysis": (piloted, python("-c", IMPORTS)),
        "messaoud2016, 4 people / protocol and simulated people": (
            published,
            lambda: [list(bare_run(plan, Population())) for plan in plans],
        ),
        "analyse a million rows / read with pandas": (
            lambda: analyse(million),
            lambda: read_all(million),
        ),
    }
