"""The report explains every coverage in the table of population thresholds that is not .93-.97."""

import re

import pytest

from benchmarks.measured_page import PAGE
from benchmarks.population_thresholds import LAPSES, OBSERVERS, SIZES
from slipscale.analysis.tasks.thresholds.cautions import CAUTIONS

CELL = re.compile(r"(0\.\d{3}); [+-]")
EXPLAINED = {name: dict(each.coverage) for each in CAUTIONS for name in each.observers}


def measured():
    """Return the number of studies per cell, and (observers, lapses) -> coverage by people."""
    text = (
        PAGE.read_text().split("<!-- populations: begin -->")[1].split("<!-- populations: end")[0]
    )
    studies = int(re.search(r"(\d+) studies per cell", text)[1])
    rows = (line.split(" | ") for line in text.splitlines() if CELL.search(line))
    found = {}
    for first, *cells in rows:
        name, _, lapses = first.removeprefix("| ").rpartition(", ")
        coverage = (float(CELL.match(cell)[1]) for cell in cells)
        found[name, int(lapses[:-1]) / 100] = dict(zip(SIZES, coverage, strict=True))
    return studies, found


def unexplained(studies, coverages, explained=EXPLAINED):
    """Return the cells outside .93 to .97 that no sentence in the report explains.

    By chance, coverage differs by up to three standard errors: .021 with 1,000 studies.
    """
    chance = max(0.02, 3 * (0.95 * 0.05 / studies) ** 0.5)
    found = []
    for (name, lapses), by_people in coverages.items():
        told = explained.get(name, {0: 0.95}).values()
        low, high = min(*told, 0.95) - chance, max(*told, 0.95) + chance
        found += [
            (name, lapses, people, share)
            for people, share in by_people.items()
            if not low <= share <= high
        ]
    return found


def test_the_report_explains_every_cell_outside_93_to_97_percent():
    studies, found = measured()
    assert set(found) == {(name, lapse) for name in OBSERVERS for lapse in LAPSES}
    assert unexplained(studies, found) == []


@pytest.mark.parametrize("share", [0.92, 0.98])
def test_a_cell_without_a_sentence_is_reported(share):
    cells = {("threshold: Gumbel", 0.0): {6: 0.95, 24: share}}
    assert unexplained(1000, cells) == [("threshold: Gumbel", 0.0, 24, share)]


def test_every_sentence_on_coverage_is_needed_and_states_the_numbers_of_the_table():
    studies, found = measured()
    chance = 3 * (0.95 * 0.05 / studies) ** 0.5
    for caution in CAUTIONS:
        for name in caution.observers:
            for people, share in caution.coverage:
                extreme = (min if share < 0.95 else max)(
                    found[name, lapse][people] for lapse in LAPSES
                )
                assert extreme == pytest.approx(share, abs=chance)
                assert f"{share:.0%} of studies with {people} people".replace("%", " %") in str(
                    caution
                )
            if share < 0.95:
                assert (name, 0.0, 24) in [each[:3] for each in unexplained(studies, found, {})]
