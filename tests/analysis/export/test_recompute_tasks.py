"""The numbers of thresholds, scales and matching, recomputed by a script that stands alone."""

import ast
import re
import runpy
import sys

import pandas as pd
import pytest

from slipscale.analysis.export.files import write_export
from slipscale.analysis.pipeline import analyse
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.bare_dataset import write_simulated
from slipscale.experiments.running.pilot import pilot_plans

STUDY = """
name = "every"
title = "Every task"
language = "en"
seed = 5
participants = 4
amplitudes_um_pp = [1.0, 1.06, 1.1, 1.15, 1.2]
[plate]
tolerance = 0.01
tolerance_um_pp = 0.015
[[tasks]]
protocol = "magnitude_estimation"
[[tasks]]
protocol = "difference_threshold"
standard_um_pp = 1.2
intervals = 3
most_trials = 30
[[tasks]]
protocol = "constant_stimuli"
question = "yes_no"
standard_um_pp = 1.2
comparisons_um_pp = [0.9, 1.0, 1.1, 1.3, 1.4]
repetitions = 10
[[tasks]]
protocol = "paired_comparison"
label = "pairs"
repetitions = 3
[[tasks]]
protocol = "paired_comparison"
label = "triads"
form = "triads"
repetitions = 3
[[tasks]]
protocol = "matching"
references_um_pp = [1.2]
repetitions = 2
"""
#: Drawn at random, searched along a profile, or of a curve that jumps: named, never passed over.
NAMED = re.compile(
    r"\.fit\.(p|simulations)$|maximum_likelihood\.\w+_ci\.|differences\.(\w*interval|simulations)"
)


@pytest.fixture(scope="module")
def exported(tmp_path_factory, without_figures):
    folder = tmp_path_factory.mktemp("every")
    study, data = folder / "every.toml", folder / "data"
    study.write_text(STUDY, encoding="utf-8")
    people = Population(noise=5.0)
    # With some other seeds a participant has no threshold, and so not every number of WRONG exists.
    plans = pilot_plans(str(study), participants=4, seed=1, language=None, population=people)
    write_simulated(data, plans, people, sessions=False)
    out = tmp_path_factory.mktemp("out")
    write_export(analyse(data, psignifit=False), out, ["scripts"])
    return out


#: Told 5 % too large.
WRONG = [
    "matching.0.direction.mean",
    "scales.0.thurstone.values.0",
    "scales.1.differences.noise",
    "thresholds.0.population.threshold.value",
    "exponent_and_weber.0.ekman_fraction.interval.1",
]


def test_the_script_recomputes_every_task_sees_what_is_wrong_and_names_what_it_leaves(
    exported, tmp_path, capsys
):
    for path in [*exported.glob("*.csv"), exported / "recompute_tasks.py"]:
        (tmp_path / path.name).write_bytes(path.read_bytes())
    numbers = pd.read_csv(tmp_path / "numbers.csv")
    wrong = numbers["name"].isin(WRONG)
    assert wrong.sum() == len(WRONG)
    numbers["value"] = numbers["value"].where(~wrong, 1.05 * numbers["value"])
    numbers.to_csv(tmp_path / "numbers.csv", index=False)
    assert runpy.run_path(str(tmp_path / "recompute_tasks.py"))["main"](tmp_path) == len(WRONG)
    said = capsys.readouterr().out
    assert sorted(re.findall(r"^(\S+) .* DIFFERS$", said, re.MULTILINE)) == sorted(WRONG)
    left = re.findall(r"^not recomputed: (.+)$", said, re.MULTILINE)
    for part in ("thresholds.0.", "thresholds.1.", "scales.0.", "scales.1.", "matching.0."):
        own = set(numbers["name"][numbers["name"].str.startswith(part)])
        assert len(own - set(left)) > 10, part
    jumping = {name.partition("maximum_likelihood")[0] for name in left if name.endswith("levels")}
    assert len(jumping) <= 2
    for name in left:
        of_a_jump = any(name.startswith(place) for place in jumping)
        assert of_a_jump or NAMED.search(name), name


def test_the_script_needs_nothing_of_ours(exported):
    nodes = list(ast.walk(ast.parse((exported / "recompute_tasks.py").read_text(encoding="utf-8"))))
    names = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    names += [node.module for node in nodes if isinstance(node, ast.ImportFrom)]
    others = {name.split(".")[0] for name in names} - set(sys.stdlib_module_names)
    assert others == {"numpy", "pandas", "scipy", "statsmodels"}
