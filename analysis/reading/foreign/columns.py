"""Name the columns of tables from other laboratories as in Slipscale's tables."""

from __future__ import annotations

from slipscale.analysis.reading.trial_tables import BLOCK, ESTIMATION
from slipscale.experiments.dataset.schema import PARTICIPANT

STIMULUS, RESPONSE = ESTIMATION.required
REFERENCE, ANSWER = "level_before", "difference_felt"
GROUP = "group"
#: Columns in Slipscale's tables, keyed by field name of `mapping.Columns`.
OURS = {
    "participant": PARTICIPANT,
    "stimulus": STIMULUS,
    "response": RESPONSE,
    "answer": ANSWER,
    "yes_count": "yes_count",
    "no_count": "no_count",
    "percent": "percent",
    "n": "n",
    "reference": REFERENCE,
    "first": "first",
    "second": "second",
    "chosen": "chosen",
    "dissimilarity": "dissimilarity",
    "group": GROUP,
    "factor": "factor",
    "session": "session",
    "run": "run",
    "block": BLOCK,
    "trial": "trial",
}
NUMBERS = (
    *("stimulus", "response", "reference", "dissimilarity", "trial"),
    *("yes_count", "no_count", "percent", "n"),
)
