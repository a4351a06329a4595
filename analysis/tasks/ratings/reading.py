"""Read ratings from a data set: on a visual analogue scale, or in ordered categories.

``surface`` is the texture name, or the amplitude (µm peak to peak); a texture has no
``amplitude_um_pp``. Catch trials are marked.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.task_tables import task_trials

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.reading.delimited import Problems

#: Columns that identify a table of ratings.
RATED = ("rating", "amplitude_um_pp")
#: Columns for ratings on a line, and the number of categories for category ratings.
OF_SCALE = ("resolution", "cursor_start", "categories")
LENGTH = 100.0  # of the line


def _ratings(frame: pd.DataFrame, problems: Problems) -> pd.DataFrame:
    beyond = frame["rating"] > frame["categories"].fillna(LENGTH)
    if beyond.any():
        problems.add(
            f"{int(beyond.sum())} ratings are above {LENGTH:g}, the right end of the line, or the "
            "number of categories; they are left out"
        )
    amplitude = frame["amplitude_um_pp"]
    plain = frame["texture"] == ""
    return frame.assign(
        rating=frame["rating"].mask(beyond),
        surface=frame["texture"].mask(plain, amplitude.map("{:g}".format)),
        amplitude_um_pp=amplitude.where(plain),
    )


TRIALS = task_trials(
    "ratings",
    "rating",
    marks=RATED,
    numeric=(*OF_SCALE, *RATED),
    words=("texture",),
    columns=("surface", *OF_SCALE, *RATED),
    needed=("rating",),
    levels=("amplitude_um_pp",),
    derive=_ratings,
)
