"""The table of kinds of task: nothing that a kind declares is forgotten."""

import pickle
import re
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import get_args

import pytest

from slipscale.analysis import tasks
from slipscale.analysis.reporting import files, page
from slipscale.analysis.statistics.statistic import Statistic
from slipscale.analysis.tasks.kind import TaskAnalysis
from slipscale.analysis.tasks.table import KINDS, STATISTICS
from slipscale.experiments.protocol_parts.registry import load_protocol, protocol_names
from slipscale.experiments.study.analysis_choices import Test
from slipscale.experiments.study.file import shipped_studies

# Pilots of published experiments take minutes: their results are in this table.
TABLE = Path(__file__).parents[3] / "docs" / "tutorials" / "published-studies.toml"
STUDIES = [name for name in shipped_studies() if f"[{name}]" not in TABLE.read_text("utf-8")]


@pytest.fixture(scope="module", params=[*STUDIES, "meyer2015"])
def pilot(request, shipped_pilot):
    return shipped_pilot(request.param)[1]


def test_every_figure_is_shown_in_the_report(pilot):
    names = files.draw(pilot)
    shown = page.render(pilot, {name: f"<svg>here is {name}</svg>" for name in names}, {})
    assert [name for name in names if f"here is {name}<" not in shown] == []


#: A part of a sentence that states a difference, and the p-values that it may contain.
STATED = re.compile(r"(?<!neither )\b(differed|changed|depended|were biased|had an effect)\b")
VALUES = re.compile(r"p [=≤<] (\.\d+)")


def test_no_sentence_states_a_difference_above_the_level(pilot):
    level = 1 - pilot.dataset.choices.confidence
    texts = [text for kind in KINDS for text in (*kind.answers(pilot), *kind.doubts(pilot))]
    texts += [text for kind in KINDS for part in kind.sentences(pilot).values() for text in part]
    for text in texts:
        for clause in re.split(r"; |\. (?=[A-Z])|, and ", text):
            if STATED.search(clause):
                assert all(float(p) <= level for p in VALUES.findall(clause)), clause


def test_every_statistic_is_in_the_json_under_its_key(pilot):
    assert list(pilot.inference.results) == [each.key for each in STATISTICS]


def test_every_statistic_and_kind_of_a_module_is_in_the_table():
    listed = {id(each) for each in (*STATISTICS, *KINDS)}
    for module in walk_packages(tasks.__path__, f"{tasks.__name__}."):
        for name, each in vars(import_module(module.name)).items():
            if isinstance(each, Statistic | TaskAnalysis):
                assert id(each) in listed, f"{module.name}.{name}"


PROTOCOLS = tuple(map(load_protocol, protocol_names()))


@pytest.mark.parametrize("declaration", [*PROTOCOLS, *KINDS, *STATISTICS])
def test_a_declaration_is_pickled_and_equals_its_copy(declaration):
    copy = pickle.loads(pickle.dumps(declaration))  # noqa: S301 - written here
    assert copy == declaration
    others = [each for each in (*PROTOCOLS, *KINDS, *STATISTICS) if each == declaration]
    assert others == [declaration]


def test_a_study_can_choose_every_test_and_no_other():
    assert set(get_args(Test)) == {each.key for each in STATISTICS if each.test}


def test_keys_and_names_are_unique():
    keys = [each.key for each in STATISTICS]
    names = [each.name for each in KINDS]
    assert len(set(keys)) == len(keys)
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("statistic", STATISTICS, ids=lambda each: each.key)
def test_every_statistic_says_what_it_computes(statistic):
    assert len(statistic.meaning.split()) >= 2


@pytest.mark.parametrize("statistic", STATISTICS, ids=lambda each: each.key)
def test_the_methods_section_describes_every_statistic(statistic):
    # The normalisation is described together with the estimates.
    assert bool(statistic.methods) is (statistic.key != "normalisation")
    assert re.fullmatch("[a-z_]+", statistic.key)
