"""The report names the method that was run, for every protocol."""

import html
import re

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from slipscale.analysis.pipeline import analyse
from slipscale.analysis.tasks.exponent_and_weber.statistics import EXPONENT_AND_WEBER
from slipscale.analysis.tasks.thresholds.sentences import MEANT
from slipscale.analysis.tasks.thresholds.statistics import THRESHOLDS
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.protocol_parts.registry import protocol_names
from slipscale.experiments.running.bare_dataset import write_simulated
from slipscale.experiments.running.pilot import pilot_plans

TRACKS = """standard_um_pp = 1.2
start_um_pp = 0.4
lowest_um_pp = 0.02
highest_um_pp = 0.8
tracks = 1
most_trials = 12
catch_trials = 1
"""
OPTIONS = {
    "category_scale": 'labels = ["little", "some", "much"]\nrepetitions = 1\n',
    "constant_stimuli": "standard_um_pp = 1.2\ncomparisons_um_pp = [0.9, 1.1, 1.3, 1.5]\n",
    "detection_threshold": TRACKS.replace("standard_um_pp = 1.2\n", ""),
    "difference_threshold": TRACKS,
    "oddity": 'label = "triangle"\n' + TRACKS,
    "limits": "lowest_um_pp = 0.2\nhighest_um_pp = 1.6\nstep_um_pp = 0.2\nseries = 2\n",
    "matching": "references_um_pp = [1.2]\nrepetitions = 1\n",
    "magnitude_estimation": "repetitions = 2\n",
    "ratio_to_standard": "standard_um_pp = 0.5\n",
    "magnitude_production": "numbers = [5.0, 20.0]\nstandard_um_pp = 1.0\n"
    "lowest_um_pp = 0.1\nhighest_um_pp = 2.4\n",
}
#: How the literature calls each method.
METHODS = {
    "category_scale": "Category scale",
    "constant_stimuli": "Constant stimuli",
    "descending_difference": "Descending difference",
    "detection_threshold": "Detection threshold, two-interval forced choice",
    "difference_threshold": "Difference threshold at 1.2 µm, two-interval forced choice",
    "identification": "Identification",
    "limits": "Method of limits",
    "magnitude_estimation": "magnitude estimation",
    "magnitude_production": "Magnitude production",
    "matching": "Matching",
    "oddity": "Difference threshold by oddity, oddity with three intervals",
    "paired_comparison": "Paired comparison",
    "pointing": "Pointing",
    "ratio_to_standard": "Ratio",
    "same_different": "Same–different",
    "similarity": "Similarity",
    "sorting": "sorting",
    "visual_analogue_scale": "Visual analogue scale",
}


@pytest.fixture(scope="module")
def every(tmp_path_factory):
    """A study of every protocol that needs no position of the finger."""
    folder = tmp_path_factory.mktemp("every")
    tasks = "\n".join(
        f'[[tasks]]\nprotocol = "{name}"\n{OPTIONS.get(name, "")}'
        for name in protocol_names()
        if name != "pointing"
    )
    text = (
        'name = "every"\ntitle = "Every method"\nlanguage = "en"\nseed = 5\nparticipants = 5\n'
        "amplitudes_um_pp = [0.5, 0.9, 1.5, 2.3]\n[plate]\ntolerance = 0.01\n"
        f"tolerance_um_pp = 0.015\n{tasks}"
    )
    study, data = folder / "every.toml", folder / "data"
    study.write_text(text, encoding="utf-8")
    plans = pilot_plans(str(study), participants=5, seed=1, language=None)
    write_simulated(data, plans, Population(), sessions=False)
    return analyse(data)


def test_every_protocol_has_its_name_in_the_report(every, page):
    text = html.unescape(re.sub(r"<[^>]+>", " ", re.sub(r"<svg.*?</svg>", "", page(every))))
    missing = {
        name: words
        for name in protocol_names()
        for words in METHODS[name].split(", ")
        if name != "pointing" and words.lower() not in text.lower()
    }
    assert set(METHODS) == set(protocol_names())
    assert missing == {}
    assert "three-interval forced choice)" not in text.replace("1.12 in three-interval", "")


def test_only_choices_by_magnitude_are_compared_with_the_exponent(every):
    methods = {task.task: task.method for task in every.inference[THRESHOLDS]}
    assert methods["triangle"] == "oddity"
    compared = every.inference[EXPONENT_AND_WEBER]
    assert "triangle" not in [each.task for each in compared or ()]


def test_half_way_is_another_d_prime_in_oddity():
    """Numerical integration of the decision rules."""

    def triangle(d):
        def at(z):
            ends = -z * 3**0.5 + d * np.array([1, -1]) * (2 / 3) ** 0.5
            return 2 * norm.cdf(ends).sum() * norm.pdf(z)

        return quad(at, 0, 10)[0]

    def three(d):
        return quad(lambda z: norm.cdf(z) ** 2 * norm.pdf(z - d), -10, 12)[0]

    assert triangle(2.32) == pytest.approx(2 / 3, abs=1e-3)
    assert three(1.12) == pytest.approx(2 / 3, abs=2e-3)
    assert norm.cdf(0.95 / 2**0.5) == pytest.approx(3 / 4, abs=2e-3)
    assert all(figure in MEANT["oddity"][1] for figure in ("2.32", "1.12", "0.95"))
