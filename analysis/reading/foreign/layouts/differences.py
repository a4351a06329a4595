"""Convert judgements of differences between stimuli (difference scaling).

The answer states which difference is larger: the second of a quadruple's two pairs, or the step
from the second to the third stimulus of a triad. The codes 0 and 1, or 1 and 2, are the first and
the second, as in R's package MLDS; of other codes, ``--yes`` means the second.
"""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from slipscale.analysis.reading.answer_codes import as_answers, codes_of, without_missing
from slipscale.analysis.reading.foreign.columns import ANSWER
from slipscale.analysis.reading.foreign.layouts.layout import Rows
from slipscale.analysis.reading.foreign.layouts.pairs import FIRST, SECOND, compared


def convert(rows: Rows) -> Mapping[str, pd.DataFrame]:
    """Return the comparisons of differences."""
    words = rows.mapping.answers
    frame = without_missing(rows.frame, ANSWER, words.missing, rows.problems)
    codes = codes_of(frame[ANSWER])
    if (
        words.yes is None
        and words.no is None
        and codes.dropna().isin(FIRST | SECOND).all()
        and (codes.isin(SECOND).any())
    ):
        second = codes.map(dict.fromkeys(FIRST, 0.0) | dict.fromkeys(SECOND, 1.0)).astype(float)
    else:
        second = as_answers(frame, ANSWER, rows.sources, rows.problems, words=words)
    return compared(rows, frame, rows.mapping.shape.compared, second + 1)
