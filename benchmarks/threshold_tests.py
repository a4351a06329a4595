"""Compare the tests of thresholds in ``slipscale power`` with the model in the report.

    .venv/bin/python -m benchmarks.threshold_tests [--people 6] [--studies 100]

Simulated people discriminate amplitudes with either hand. With the left hand, people's sensations
are multiplied by the effect. Two tests at the .05 level compare the hands in each study: a paired
t test of individual thresholds, as in `power`, and the hierarchical model, as in `analyse`. If the
effect is 1, the hands do not differ, and significant results are false alarms.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
from scipy import stats

from slipscale.analysis.planning.protocols.answers import read_answers, rows_of
from slipscale.analysis.planning.protocols.precision import thresholds_of
from slipscale.analysis.planning.protocols.studies import ProtocolStudy, protocol_study, seed_of
from slipscale.analysis.tasks.thresholds.population_threshold import population_threshold
from slipscale.analysis.tasks.thresholds.reading import told_choices
from slipscale.analysis.tasks.thresholds.statistics import CURVE_OF
from slipscale.experiments.participants.simulated_people.growth import people_for
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.experiments.study.file import parse_study

EFFECTS = (1.0, 1.3, 1.8)
HANDS = ("left", "right")
ALPHA = 0.05
STUDY = """
name = "hands"
title = "Hands"
seed = 1
participants = 6
amplitudes_um_pp = [0.0, 1.2, 2.3]
[[factors]]
name = "hand"
levels = ["left", "right"]
simulated = {{ left = {effect} }}
[[tasks]]
protocol = "constant_stimuli"
standard_um_pp = 1.2
comparisons_um_pp = [1.21, 1.26, 1.32, 1.4, 1.6]
repetitions = 8
"""


def decisions(study: ProtocolStudy, population: Population, people: int, seed: int) -> list[float]:
    """Return the p-values of the paired t test and of the hierarchical model for one study."""
    rows, _ = rows_of(study, people, seed, population)
    marks = study.marks or ("", "")
    answers, trials = [], []
    for number, own in enumerate(rows):
        for hand in HANDS:
            part = own[own["hand"] == hand].reset_index(drop=True)
            answers.append(read_answers(study, part))
            levels = part.rename(columns={marks[0]: "track_level"})
            choices = told_choices(levels.astype({"track_level": float}), marks)
            names = {"participant_id": f"sub-{number:02d}", "session": "", "factor: hand": hand}
            trials.append(choices.assign(**names))
    method = next(each.method for each in answers if each)
    found = thresholds_of(answers, AnalysisChoices(), points=True)
    logs = np.log(found).reshape(people, len(HANDS))
    changes = (logs[:, 1] - logs[:, 0])[np.isfinite(logs).all(axis=1)]
    table = pd.concat(trials, ignore_index=True)
    table = table[table["correct"].notna()].astype({"correct": bool})
    curve = CURVE_OF.get(method, "weibull")
    found = population_threshold(table, AnalysisChoices(), method=method, curve=curve)
    contrasts = [each for factor in found.factors for each in factor.contrasts] if found else []
    return [
        float(stats.ttest_1samp(changes, 0).pvalue) if len(changes) > 2 else 1.0,
        contrasts[0].p if contrasts else 1.0,
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--people", type=int, default=6)
    parser.add_argument("--studies", type=int, default=100)
    args = parser.parse_args()
    print("| effect | studies | paired t | hierarchical model | same decision |")
    print("| --- | --- | --- | --- | --- |")
    seeds = [seed_of(1, "hands", number) for number in range(args.studies)]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "hands.toml"
        for effect in EFFECTS:
            text = STUDY.format(effect=effect)
            path.write_text(text, encoding="utf-8")
            study = protocol_study(str(path))
            population = people_for(parse_study(text, path.name), Population())
            p = np.array([decisions(study, population, args.people, seed) for seed in seeds])
            t, model = (p < ALPHA).T
            print(
                f"| {effect:g} | {len(p)} | {t.mean():.3f} | {model.mean():.3f} "
                f"| {(t == model).mean():.3f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
