"""The page's recipes are followed in a copy of the repository."""

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from slipscale.analysis.published.biet2007 import ALLOWED_DATASET
from slipscale.experiments.study.file import study_text

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "extending" / "recipes.md").read_text(encoding="utf-8")
FOLDERS = ("src", "analysis", "experiments", "faults", "figure_style", "hardware", "stimuli")
CODE = dict(re.findall(r"^```python file=(\S+)\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL))
# Where the lines of a recipe go in a file that exists already.
BEFORE = {
    "analysis/tasks/estimation/declaration.py": "        return drawn\n",
    "experiments/study/tables.py": "    per_person: Amount",
    "analysis/tasks/estimation/figures.py": "",
}
(LINE,) = re.findall(r"^```toml file=pyproject.toml\n(.*)\n```", PAGE, re.MULTILINE)
LIST = "analysis/tasks/estimation/statistics.py"


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    root = tmp_path_factory.mktemp("copy")
    for folder in FOLDERS:
        shutil.copytree(
            ROOT / folder,
            root / folder,
            symlinks=True,
            ignore=shutil.ignore_patterns("__pycache__"),
        )
    for file, code in CODE.items():
        path = root / file
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        before = BEFORE.get(file, "")
        assert before in text
        changed = text.replace(before, code + before, 1) if before else f"{text}\n\n{code}"
        path.write_text(changed, encoding="utf-8")
    path = root / LIST
    text = path.read_text(encoding="utf-8")
    one = "from slipscale.analysis.tasks.estimation.range_of_means import RANGE_OF_MEANS\n"
    first = text.index("from slipscale.")
    text = text[:first] + one + text[first:]
    path.write_text(
        text.replace(
            "STATISTICS: tuple[Statistic[object], ...] = (\n",
            "STATISTICS: tuple[Statistic[object], ...] = (\n    RANGE_OF_MEANS,\n",
            1,
        )
    )
    # The entry point, as the installation of the copy would register it.
    installed = root / "src" / "copy-1.0.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: copy\nVersion: 1.0\n")
    points = "".join(f"{name} = {value}\n" for name, value in tomllib.loads(LINE).items())
    (installed / "entry_points.txt").write_text(f"[slipscale.questions]\n{points}")
    return root


def slipscale(copy, *words, status=0):
    return python(copy, "-m", "slipscale", *map(str, words), status=status)


def python(copy, *words, status=0):
    done = subprocess.run(
        [sys.executable, *words],
        cwd=copy,
        env={**os.environ, "PYTHONPATH": str(copy / "src")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == status, done.stderr
    return done.stdout + done.stderr


def test_a_figure_and_a_statistic_are_in_the_results(copy):
    slipscale(copy, "analyse", ALLOWED_DATASET, "--normalise", "none", "--out", "results")
    assert (copy / "results" / "medians.svg").is_file()
    found = json.loads((copy / "results" / "inference.json").read_text(encoding="utf-8"))
    assert found["range_of_means"] == pytest.approx(81.33 - 12.75, abs=0.01)


@pytest.mark.parametrize(
    "value, status, said",
    [("12.5", 0, "no fault"), ("-1.0", 2, "cost.deposit: expected 0 or more")],
)
def test_a_study_key_is_read_and_validated(copy, value, status, said):
    (copy / "own.toml").write_text(f"{study_text('biet2007')}\n[cost]\ndeposit = {value}\n")
    assert said in slipscale(copy, "study", "validate", "own.toml", status=status)


# Run in the copy: the kind is found, shown, answered by a key, rehearsed and simulated.
ASKED = """
from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.psychopy_window.layout import faults
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.participants.simulated_people.respondent import Respondent
from slipscale.experiments.steps.questions.registry import load_kind, watched
from slipscale.experiments.steps.steps import Ask
kind = load_kind("agreement")
question = watched(kind(prompt="Smooth?", lowest="no", highest="yes"), "a test")
screen = screen_for(Ask(name="smooth", question=question), load_texts("en"))
simulated = question.simulated(Respondent(seed=1, participant="01"), "smooth")
assert question.fits(simulated)
assert not list(faults(screen.scene(0.0)))
assert screen.press("6", 1.0) is None
print(question.rehearsed(0.0), question.rehearsed(1.0), screen.press("4", 1.0).value)
"""


def test_a_kind_of_question_is_shown_answered_rehearsed_and_simulated(copy):
    assert python(copy, "-c", ASKED) == "1.0 5.0 4.0\n"
