"""Write the verdict of a test.

Every sentence with a verdict uses `verdict`. A missing difference is never a conclusion of
equality, and a test with few degrees of freedom hardly ever detects a difference: with t(1), a p
below .05 requires |t| > 12.7.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from slipscale.analysis.preprocessing.sufficiency import few_degrees
from slipscale.analysis.writing.numbers import p_value

if TYPE_CHECKING:
    from slipscale.analysis.statistics.repeated_measures.omnibus import PageTrend
    from slipscale.stimuli.quantity import Quantity


class Verb(NamedTuple):
    """What a test can show: the past tense, the infinitive, and what a test does not show."""

    past: str
    infinitive: str
    denied: str = "did not {infinitive} reliably"


DIFFERED = Verb("differed", "differ")
DEPENDED = Verb("depended", "depend")
CHANGED = Verb("changed", "change")
HAD_EFFECT = Verb("had an effect", "have an effect", "had no reliable effect")
WERE_BIASED = Verb("were biased", "be biased", "were not reliably biased")


def reliable(p: float, confidence: float) -> bool:
    """Return whether p is below the significance level (1 - confidence); False if p is NaN.

    >>> reliable(0.03, 0.95), reliable(0.03, 0.99), reliable(float("nan"), 0.95)
    (True, False, False)
    """
    return p < round(1 - confidence, 12)


def verdict(verb: Verb, p: float, confidence: float, df: float) -> str:
    """Return the verb of a sentence about a test.

    Parameters
    ----------
    verb : Verb
    p, confidence : float
    df : float
        Degrees of freedom of the error. For a rank test, the number of participants - 1, or 0 if
        no result of the test can be significant.

    >>> verdict(DIFFERED, 0.03, 0.95, 2), verdict(DIFFERED, 0.3, 0.95, 11)
    ('differed', 'did not differ reliably')
    >>> verdict(DIFFERED, 0.3, 0.95, 2)
    'could not be shown to differ, because there are too few participants to test it,'
    """
    if reliable(p, confidence):
        return verb.past
    if few_degrees(df):
        return (
            f"could not be shown to {verb.infinitive}, because there are too few participants to "
            "test it,"
        )
    return verb.denied.format(infinitive=verb.infinitive)


def page_sentence(
    what: str, found: PageTrend, confidence: float, level: str, quantity: Quantity
) -> str:
    """Return a sentence with the result of Page's test for a trend of ``what`` with ``level``."""
    trend = Verb("fell" if quantity.falls else "grew", quantity.grow)
    return (
        f"{what} {verdict(trend, found.p, confidence, found.n - 1)} with {level} (Page's L = "
        f"{found.L:g}, {p_value(found.p)}, one-sided, n = {found.n})."
    )
