"""Join rows of stimuli with the rows of their answers, as in the events of a BIDS folder.

An answer belongs to the last stimulus above it in the same file. Only the first answer to a
stimulus is used.
"""

from __future__ import annotations

import pandas as pd

from slipscale.analysis.reading.foreign.columns import STIMULUS
from slipscale.analysis.reading.foreign.layouts.layout import Rows
from slipscale.faults import UserError


def reshape(rows: Rows) -> pd.DataFrame:
    """Return one row per stimulus with an answer; other rows are counted.

    Raises
    ------
    UserError
        If no row is a stimulus, or none is an answer.
    """
    events = rows.mapping.shape.rows_of
    if events is None:
        return rows.frame
    frame = rows.frame
    kinds = frame[events.column].astype("str").str.strip()
    stimulus, answer = kinds == events.stimulus, kinds == events.answer
    for value, found in ((events.stimulus, stimulus), (events.answer, answer)):
        if not found.any():
            raise UserError(
                "{file}: no row has '{value}' in column {column}; found {kinds}. Write --rows-of "
                "{column}=STIMULUS,ANSWER with two of these",
                file=rows.sources[0].name,
                value=value,
                column=events.column,
                kinds=", ".join(sorted(kinds.dropna().unique())[:12]),
            )
    place = stimulus.groupby(frame["file"]).cumsum()
    key = pd.MultiIndex.from_arrays([frame["file"], place])
    first = (
        answer & (place > 0) & ~(key.to_frame(index=False).assign(a=answer.to_numpy()).duplicated())
    )
    shown = frame[stimulus.to_numpy()].set_axis(key[stimulus])
    answered = frame[first.to_numpy()].set_axis(key[first])
    shown = shown.loc[answered.index]
    joined = {
        name: shown[name].where(shown[name].notna(), answered[name])
        if name == STIMULUS
        else answered[name].where(answered[name].notna(), shown[name])
        for name in frame.columns
    }
    for count, what in (
        (int(stimulus.sum()) - len(answered), "stimuli without an answer are omitted"),
        (int(answer.sum()) - len(answered), "answers without a stimulus of their own are omitted"),
        (int((~stimulus & ~answer).sum()), "rows of other events were skipped"),
    ):
        if count:
            rows.problems.add(f"{count} {what}")
    return pd.DataFrame(joined).reset_index(drop=True)
