"""Few people cannot show a difference, and no sentence is written without the rule for this."""

import ast
import re
from pathlib import Path

import pytest

import slipscale.analysis
from slipscale.analysis.writing.verdicts import (
    CHANGED,
    DEPENDED,
    DIFFERED,
    HAD_EFFECT,
    WERE_BIASED,
    verdict,
)

SOURCE = Path(slipscale.analysis.__file__).parent
#: A claim about a test, which only `verdict` may write.
CLAIM = re.compile(
    r"\b(did not|does not|do not|had no|has no|no|not) (\w+ )?(reliabl[ey]|significant)|"
    r"\b(did not|does not) (differ|depend|change)\b|"
    r"(?<!neither )\bdiffered\b|\b(changed|depended) (by|from|on)\b|\b(were|was) biased\b"
)


@pytest.mark.parametrize("df", [1, 2, 2.4, 3])
def test_few_degrees_of_freedom_show_no_absence(df):
    told = verdict(DIFFERED, 0.209, 0.95, df)
    assert "did not" not in told
    assert "too few participants" in told


@pytest.mark.parametrize("df", [1, 3, 4, 100])
def test_a_difference_below_the_level_is_a_difference(df):
    assert verdict(CHANGED, 0.049, 0.95, df) == "changed"
    assert verdict(CHANGED, 0.049, 0.99, df) != "changed"


def test_more_degrees_of_freedom_allow_the_usual_sentence():
    assert verdict(DEPENDED, 0.05, 0.95, 4) == "did not depend reliably"
    assert verdict(DEPENDED, float("nan"), 0.95, 4) == "did not depend reliably"


def test_every_verb_has_its_own_denial():
    assert verdict(WERE_BIASED, 0.5, 0.95, 7) == "were not reliably biased"
    assert verdict(HAD_EFFECT, 0.5, 0.95, 7) == "had no reliable effect"


def test_a_test_that_cannot_be_significant_shows_no_absence():
    assert "could not be shown to differ" in verdict(DIFFERED, 0.094, 0.95, 0)


def _claims(text: str) -> list[str]:
    """Return the claims in texts of a module; docstrings are no sentences of a report."""
    tree = ast.parse(text)
    own = {
        id(node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    }
    return [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and id(node) not in own
        and CLAIM.search(node.value)
    ]


def _chosen(text: str) -> list[int]:
    """Return the lines that choose between two texts by a test's p."""
    return [
        node.lineno
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.IfExp)
        and isinstance(node.body, ast.Constant)
        and "reliable(" in ast.unparse(node.test)
    ]


#: Sphericity is an assumption, and its verdict is "not rejected".
ASSUMPTIONS = "reporting/sections/assumptions.py"
#: "Results that are not significant are not evidence of equality."
CAUTIONS = ("evidence of", "equality")


def test_no_sentence_is_written_without_the_verdict():
    found = {
        f"{path.relative_to(SOURCE)}": told
        for path in SOURCE.rglob("*.py")
        if path.name != "verdicts.py"
        and f"{path.relative_to(SOURCE)}" != ASSUMPTIONS
        and (
            told := [
                each
                for each in (*_claims(path.read_text("utf-8")), *_chosen(path.read_text("utf-8")))
                if not any(caution in f"{each}" for caution in CAUTIONS)
            ]
        )
    }
    assert found == {}
