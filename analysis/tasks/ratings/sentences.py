"""Write sentences on ratings on a visual analogue scale, or in categories."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.writing.numbers import (
    counted,
    level_of,
    number,
    p_value,
    page_sentence,
    reliable,
    unit_number,
)

if TYPE_CHECKING:
    from slipscale.analysis.tasks.ratings.statistics import TaskRatings
    from slipscale.stimuli.quantity import Quantity


def rating_title(found: TaskRatings) -> str:
    """Return the name of a task in the report."""
    kind = "Visual analogue scale" if found.categories is None else "Category scale"
    return f"{kind} ({found.task})"


def scale_of(found: TaskRatings) -> str:
    """Return what the numbers of a task are."""
    if found.categories is None:
        return "mean places on the line from 0 (left) to 100"
    return f"mean categories, from 1 (lowest) to {found.categories},"


def rating_answer(found: TaskRatings, quantity: Quantity) -> str:
    """Return the main sentence on ratings."""
    means = ", ".join(
        f"{number(each.mean, 1)} ({_surface(each.surface, quantity)})" for each in found.surfaces
    )
    return (
        f"{rating_title(found)}, {counted(found.answers, 'rating', 'ratings')} of "
        f"{counted(found.participants, 'participant', 'participants')}: "
        f"{scale_of(found)} were {means}."
    )


def rating_tests(found: TaskRatings, confidence: float, quantity: Quantity) -> str:
    """Return the tests of ratings, and what ratings cannot show."""
    texts = []
    friedman, trend = found.friedman, found.page_trend
    if isinstance(friedman, NotComputed):
        texts.append(f"Whether ratings differ between surfaces was not tested: {friedman.reason}.")
    else:
        verb = "differed" if reliable(friedman.p, confidence) else "did not differ reliably"
        texts.append(
            f"Ratings {verb} between surfaces (Friedman's test on ranks, χ²({friedman.df}, "
            f"n = {friedman.n}) = {number(friedman.chi2)}, {p_value(friedman.p)}, Kendall's W = "
            f"{unit_number(friedman.kendalls_w)})."
        )
    if trend:
        texts.append(page_sentence("They", trend, confidence, quantity.level, quantity))
    return " ".join([*texts, *rating_biases(found, confidence)])


def rating_biases(found: TaskRatings, confidence: float) -> list[str]:
    """Return the sentences on biases of ratings: the start, the ends of the line, lapses."""
    if found.categories is not None:
        told = "Categories are ordered: tests use ranks; means treat them as equally spaced."
        return [told]
    texts = []
    start = found.start_effect
    if isinstance(start, NotComputed):
        texts.append(f"The effect of the mark's start was not measured: {start.reason}.")
    else:
        low, high = start.interval
        told = "not reliably " if low <= 0 <= high else ""
        texts.append(
            f"A mark that started 10 places further to the right was {told}put further to the "
            f"{'right' if start.mean >= 0 else 'left'}: by {number(10 * abs(start.mean))} places, "
            f"{level_of(confidence)} CI of the shift to the right [{number(10 * low)}, "
            f"{number(10 * high)}]."
        )
    ends = sum(each.at_left + each.at_right for each in found.surfaces)
    if ends:
        texts.append(
            f"{ends} of {found.answers} ratings are at an end of the line, which biases means "
            "towards the middle."
        )
    if found.catch_mean is not None:
        texts.append(
            f"The bare plate of {counted(found.catch_trials, 'catch trial', 'catch trials')} was "
            f"rated {number(found.catch_mean, 1)}."
        )
    texts.append(
        "The line is bounded and has no unit: its places can be compared and averaged, but "
        "allow neither ratios nor an exponent."
    )
    return texts


def rating_sentences(
    found: tuple[TaskRatings, ...], confidence: float, quantity: Quantity
) -> list[str]:
    """Return one paragraph per rating task."""
    return [
        f"{rating_answer(task, quantity)} {rating_tests(task, confidence, quantity)}"
        for task in found
    ]


def _surface(name: str, quantity: Quantity) -> str:
    """Format a surface for a sentence: an amplitude with its unit, or a texture's name."""
    try:
        return quantity.value(float(name))
    except ValueError:
        return name
