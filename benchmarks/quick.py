"""Run the quick benchmarks, each next to the usual alternative: make benchmarks.

    .venv/bin/python -m benchmarks.quick [--rounds 5] [--write]

Slipscale and the alternative run in turn; processor times include child processes. The median time
of Slipscale is divided by the alternative's, so smaller ratios are better. The exit status is 1 if
any ratio is more than 30 % larger than the ratio recorded in ``figures.json``. ``--write`` records
the new ratios.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd

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

FIGURES = Path(__file__).with_name("figures.json")
WORSE = 1.3  # Ratios that grow by a larger factor are reported.
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


def ways(folder: Path) -> dict[str, tuple[Callable[[], object], Callable[[], object]]]:
    """Return the functions of Slipscale and of the alternative, keyed by benchmark."""
    data, table = folder / "data", folder / "table.csv"
    write_dataset(data, PARTICIPANTS, ROWS)
    rows = load(data).estimates
    one, several = written_tables(folder)
    pilot = folder / "pilot"
    run_pilot(
        pilot,
        pilot_plans("biet2007", participants=14, seed=1, language=None),
        tell=lambda _: None,
    )
    plan = pilot_plans("biet2007", participants=1, seed=1, language=None)[0]

    def read() -> object:
        paths = sorted(data.glob("sub-*/beh/*.tsv"))
        return pd.concat([pd.read_csv(path, sep="\t", na_values=["n/a"]) for path in paths])

    def session() -> None:
        with TemporaryDirectory() as empty:
            run_simulated(Path(empty), plan, "mock")

    def python(*words: str) -> Callable[[], object]:
        command = [sys.executable, *words]
        return lambda: subprocess.run(command, check=True, capture_output=True, env=environment())

    return {
        "slipscale --help / python -c pass": (
            python("-m", "slipscale", "--help"),
            python("-c", "pass"),
        ),
        "import slipscale / python -c pass": (
            python("-c", "import slipscale"),
            python("-c", "pass"),
        ),
        "analyse 14 people / pandas and pingouin by hand": (
            python("-m", "slipscale", "analyse", str(pilot), "--out", str(folder / "report")),
            python("-c", BY_HAND, str(pilot)),
        ),
        "load / read with pandas": (lambda: load(data), read),
        "read a table of 10,000 rows / read with pandas": (
            lambda: read_tables(one, participant="who", trial="trial"),
            lambda: pd.read_csv(one),
        ),
        "read 20 tables of 500 rows / read with pandas": (
            lambda: read_tables(several, participant_from_name="", trial="trial"),
            lambda: pd.concat([pd.read_csv(path) for path in sorted(several.iterdir())]),
        ),
        "load and analyse / read with pandas": (lambda: analyse(data), read),
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


def spent_s(work: Callable[[], object]) -> float:
    """Return the processor time of a call in seconds, including finished child processes."""

    def now() -> float:
        used = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        return sum(each.ru_utime + each.ru_stime for each in used)

    began = now()
    work()
    return now() - began


def ratio(ours: Callable[[], object], other: Callable[[], object], rounds: int) -> float:
    """Return the ratio of median times, without a first round that fills caches."""
    pairs = [(spent_s(ours), spent_s(other)) for _ in range(rounds + 1)][1:]
    return median(pair[0] for pair in pairs) / median(pair[1] for pair in pairs)


def worse(found: Mapping[str, float], recorded: Mapping[str, float]) -> list[str]:
    """Return the benchmarks with a ratio more than 30 % larger than the recorded one."""
    return [name for name in found if found[name] > WORSE * recorded.get(name, float("inf"))]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--write", action="store_true", help="record the ratios found here")
    options = parser.parse_args()
    record = json.loads(FIGURES.read_text(encoding="utf-8")) if FIGURES.exists() else {}
    recorded: dict[str, float] = record.get("ratios", {})
    print(f"recorded: {record.get('date', 'never')}, {record.get('machine', '')}")
    print(f"{'ours / other, processor time':<48} {'here':>8} {'recorded':>9}")
    found: dict[str, float] = {}
    with TemporaryDirectory() as folder:
        for name, (ours, other) in ways(Path(folder)).items():
            found[name] = round(ratio(ours, other, options.rounds), 4)
            print(f"{name:<48} {found[name]:8.3f} {recorded.get(name, float('nan')):9.3f}")
    if options.write:
        python = f"Python {platform.python_version()}"
        machine = f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores, {python}"
        record = {"date": f"{datetime.now(UTC):%Y-%m-%d}", "machine": machine, "ratios": found}
        FIGURES.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")
        return 0
    slower = worse(found, recorded)
    for name in slower:
        print(f"ratio more than 30 % larger than recorded: {name}")
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
