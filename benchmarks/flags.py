"""Measure how often honest simulated people are flagged for data quality, in several designs.

A flag should be raised for at most 5 % of honest people. People of the shipped population are
simulated, and their answers are read and flagged by the functions of the analysis. Response times
and plate faults are not simulated. Run:
.venv/bin/python -m benchmarks.flags [--participants 1000] [--seed 1] [--write]
"""

from __future__ import annotations

import argparse
from functools import partial
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd

from benchmarks.measured_page import put
from slipscale.analysis.load import load
from slipscale.analysis.preprocessing.data_quality import flags, measures
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.bare_dataset import write_simulated
from slipscale.experiments.running.pilot import pilot_plans
from slipscale.experiments.study.analysis_choices import Thresholds

FOUR, TWO, EIGHT = "0.0, 0.5, 1.2, 2.3", "1.2, 2.3", "0.0, 0.3, 0.6, 0.9, 1.2, 1.6, 1.9, 2.3"
#: Amplitudes (µm peak to peak), repetitions of magnitude estimation, catch steps, and the standard
#: deviation, between people, of their log trial-to-trial noise (default: 0.25), keyed by column.
DESIGNS = {
    "4 × 1": (FOUR, 1, 1, 0.25),
    "4 × 3": (FOUR, 3, 2, 0.25),
    "4 × 6": (FOUR, 6, 4, 0.25),
    "4 × 12": (FOUR, 12, 8, 0.25),
    "4 × 3, noise SD × 2": (FOUR, 3, 2, 0.5),
    "4 × 3, equal noise": (FOUR, 3, 2, 0.0),
    "2 × 4": (TWO, 4, 2, 0.25),
    "8 × 3": (EIGHT, 3, 2, 0.25),
}
#: Flags for response times and plate faults.
NOT_SIMULATED = ["fast", "timed_out", "faults"]
#: Participants per study: flags compare a participant with the others.
STUDY = 12


def share_flagged(design: str, participants: int, seed: int) -> pd.Series[float]:
    """Return the proportion of honest people who receive each flag in studies of one design."""
    amplitudes, repetitions, catch_steps, noise = DESIGNS[design]
    people = Population(noise_sigma=noise)
    shipped = files("slipscale.experiments").joinpath("studies", "biet2007.toml")
    text = shipped.read_text(encoding="utf-8")
    text = text.replace("repetitions = 1", f"repetitions = {repetitions}")
    text = text.replace(FOUR, amplitudes)
    text = text.replace("catch_steps = 1", f"catch_steps = {catch_steps}")
    with TemporaryDirectory() as folder:
        study = Path(folder) / "study.toml"
        study.write_text(text, encoding="utf-8")
        plans = pilot_plans(
            str(study), participants=participants, seed=seed, language=None, population=people
        )
        write_simulated(Path(folder) / "data", plans, people, sessions=False)
        data = load(Path(folder) / "data")
    names = sorted(data.people)
    shares = []
    for start in range(0, len(names), STUDY):
        here = set(names[start : start + STUDY])
        study_data = data.with_tables(partial(_of_people, here))
        shares.append(flags(measures(study_data, Thresholds()), Thresholds()))
    return pd.concat(shares).mean()


def _of_people(names: set[str], rows: pd.DataFrame) -> pd.DataFrame:
    if not len(rows):
        return rows
    own = rows[rows[PARTICIPANT].astype(str).isin(names)].reset_index(drop=True)
    return own.assign(**{PARTICIPANT: own[PARTICIPANT].cat.remove_unused_categories()})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--participants", type=int, default=1000, help="per cell (default: 1000)")
    parser.add_argument("--seed", type=int, default=1, help="random seed (default: 1)")
    parser.add_argument("--write", action="store_true", help="put the table into the page")
    args = parser.parse_args()
    found = pd.DataFrame(
        {design: share_flagged(design, args.participants, args.seed) for design in DESIGNS}
    )
    people = f"{args.participants} simulated people in studies of {STUDY} people"
    lines = [
        (
            f"Each cell describes {people}; columns are designs (amplitudes × repetitions; noise "
            "SD: between people)."
        ),
        "",
        f"| Flag | {' | '.join(found.columns)} |",
        f"| --- |{' --- |' * len(found.columns)}",
    ]
    found = found.drop(index=NOT_SIMULATED)
    raised = found.any(axis="columns")
    for flag, shares in found[raised].iterrows():
        lines.append(f"| {flag} | {' | '.join(f'{share:.3f}' for share in shares)} |")
    never = ", ".join(f"`{flag}`" for flag in found.index[~raised])
    lines += ["", f"These flags were never raised: {never}."]
    print("\n".join(lines))
    if args.write:
        put("flags", lines)


if __name__ == "__main__":
    main()
