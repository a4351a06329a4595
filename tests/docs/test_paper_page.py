"""The page "The paper": every part with its code, values and reasons."""

import re
from collections import Counter
from functools import reduce
from importlib import import_module

import pytest

from slipscale.analysis.reproduction import comparison
from tools.site import paper_page

PLACES = {
    (kind, number): place
    for kind, places in (
        ("eq", paper_page.EQUATIONS),
        ("table", paper_page.TABLES),
        ("fig", paper_page.FIGURES),
    )
    for number, (_, place) in places.items()
}


@pytest.fixture(scope="module")
def pages():
    return paper_page.pages()


def found(place):
    """Import a module, or the object with a dotted name in one."""
    names = place.split(".")
    for end in range(len(names), 0, -1):
        try:
            module = import_module(".".join(names[:end]))
        except ModuleNotFoundError:
            continue
        return reduce(getattr, names[end:], module)
    raise LookupError(place)


def test_every_part_of_the_paper_has_a_place_in_the_code():
    assert [key for key in PLACES if key[0] == "eq"] == [("eq", n) for n in range(1, 48)]
    assert len(PLACES) == 47 + 3 + 15
    for place in PLACES.values():
        assert found(place) is not None


def test_the_page_shows_each_part_with_its_value_and_each_figure(pages):
    text = pages["validation/the-paper.md"]
    for number in range(1, 48):
        assert re.search(rf"^\| \*\*{number}\*\* ", text, re.MULTILINE), number
    for number in range(1, 16):
        assert f"(paper/fig{number}.svg)" in text
        assert pages[f"validation/paper/fig{number}.svg"].startswith("<svg")
    assert "| 14.75 | 13.603 mm | **differs** (`fig9.analytic.25kHz`): equation (38)" in text
    assert (
        "`infinite_squeeze.edge_squared` | equal | 0.27694 relative difference | **differs**"
        in text
    )


def test_each_statement_of_the_experiment_has_what_the_session_does(pages):
    text = pages["validation/the-paper.md"]
    session = text.split("statement by statement")[1]
    assert session.count("\n| ") == len(paper_page.SENTENCES) + 2
    assert "what has been removed" in session


def test_the_page_counts_the_same_items_as_the_terminal(pages):
    groups = Counter(one.outcome.group for one in comparison.compare())
    text = " ".join(pages["validation/the-paper.md"].split())
    assert f"For {groups['not published']} items, the paper gives no number." in text
    assert f"{groups['agrees']} independent items agree with the paper." in text
    assert groups["not published"] == 49
