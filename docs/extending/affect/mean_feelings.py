"""Compute the mean valence and arousal at each level."""

from slipscale.task import NotComputed, OwnResult, own_analysis

PARTS = ["valence", "arousal"]


def analysis(own):
    """Return the mean valence and arousal at each level, or why they cannot be computed."""
    rows = own.dataset.others.get("feelings")
    if rows is None or not set(PARTS) <= set(rows):
        return NotComputed("no trials with an affect grid")
    means = rows.groupby("level", observed=True)[PARTS].mean()
    valence, arousal = rows[PARTS].mean()
    return OwnResult(
        sentences=(f"The mean valence was {valence:.1f} and the mean arousal {arousal:.1f}.",),
        numbers={"valence": float(valence), "arousal": float(arousal)},
        table=means.reset_index(),
        table_caption="Mean valence and arousal (1 to 9) at each level.",
    )


ANALYSIS = own_analysis("mean_feelings", title="Valence and arousal", run=analysis)
