"""Generate warnings about the data, one sentence each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from slipscale.analysis.preprocessing.normalisation import cell_means
from slipscale.analysis.preprocessing.sufficiency import FEWEST
from slipscale.analysis.reading.cells import listed
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.stimuli.quantity import capitalised

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.analysis.reading.labelled_tasks import TaskTrials
    from slipscale.stimuli.quantity import Quantity

#: Rules that multiply all participants' estimates by the same factor, and the ratio between
#: participants' scales at which a warning is given.
ONE_FACTOR, SCALES_APART = ("none", "grand_maximum"), 5.0


def absent(data: Dataset) -> list[str]:
    """Report participants who have no data, are listed twice, or have an unfinished run."""
    about = data.participants
    names = about["participant_id"].astype(str)
    notes = []
    # Tables from other laboratories list participants themselves.
    own = any(source.name == "participants.tsv" for source in data.sources)
    listed_in = " in participants.tsv" if own else ""
    if missing := sorted(set(names) - data.people):
        notes.append(
            f"{len(missing)} of {names.nunique()} participants{listed_in} have no trials "
            f"({listed(missing)})."
        )
    if duplicates := sorted(set(names[names.duplicated()])):
        notes.append(
            f"participants.tsv lists {listed(duplicates)} more than once; the first row is used."
        )
    if "complete" in about:
        unfinished = names[about["complete"].astype(str).str.lower() == "no"]
        if len(unfinished):
            notes.append(
                f"{len(unfinished)} of {names.nunique()} participants did not finish a run "
                f"({listed(unfinished)}); their answers are analysed."
            )
    return notes


def changing_tops(data: Dataset) -> list[str]:
    """Report participants who declared more than one top of the scale."""
    tops = data.estimates.groupby(PARTICIPANT, observed=True)["scale_top"].nunique()
    several = tops.index[tops > 1].astype(str)
    if not len(several):
        return []
    sentence = (
        f"{listed(several)} declared more than one top of the scale; the rule scale_top divides "
        "each estimate by the top declared for its own trial."
    )
    return [sentence]


def beyond_tops(data: Dataset) -> list[str]:
    """Report the number of estimates above the declared top of the scale."""
    above = data.estimates["estimate"] > data.estimates["scale_top"]
    if not above.any():
        return []
    who = sorted(data.estimates.loc[above, PARTICIPANT].astype(str).unique())
    sentence = (
        f"{int(above.sum())} of {len(above)} estimates are above the top of the scale declared for "
        f"their trial ({listed(who)}). These estimates are not changed; check that the declared "
        "top belongs to this scale."
    )
    return [sentence]


def nothing(data: Dataset, kinds: Sequence[TaskTrials]) -> str:
    """Explain why there is nothing to analyse."""
    rows = sum(data.counts.get(f"{kind.counted}_rows", 0) for kind in kinds)
    parts = [part for kind in kinds for part in kind.counted_left_out(data.counts)]
    why = f" ({rows} rows read: {', '.join(parts)})" if parts else f" ({rows} rows read)"
    first = f". {data.problems[0]}" if data.problems else ""
    if data.others and not rows:
        return (
            f"contains only trials of {', '.join(data.others)}, which Slipscale does not "
            "analyse; install a package that analyses them (with an entry point in the group "
            f"slipscale.analyses){first}"
        )
    return f"no answered trials; nothing to analyse{why}{first}"


def too_few_data(cells: pd.DataFrame, quantity: Quantity) -> list[str]:
    """Report limitations: few participants or amplitudes, only zeros, or missing estimates."""
    notes = []
    participants, amplitudes = cells.shape
    if not participants:
        return []  # other tasks have their own messages
    if participants == 1:
        notes.append(
            "There is only one participant, so only means are shown: standard deviations "
            "require at least two participants, and intervals and tests at least three."
        )
    elif participants < FEWEST:
        notes.append(
            "There are only two participants, so only means and their spread are shown: "
            "intervals, tests and exponents require at least three."
        )
    if amplitudes == 1:
        notes.append(
            f"There is only one {quantity.level}, so there are no comparisons, growth "
            "functions or tests."
        )
    if participants and not (cells.to_numpy() > 0).any():
        notes.append(
            "All estimates are zero, so there is no spread, and there are no growth functions "
            "or tests."
        )
    missing = cells.index[cells.isna().any(axis=1)].astype(str)
    if len(missing):
        notes.append(
            f"{len(missing)} of {participants} participants have no estimate for at least "
            f"one {quantity.level} ({listed(missing)}). The analysis of "
            "variance, the linear trend, Friedman's test and Page's test use only participants "
            "with complete data; other results use every participant with the necessary "
            f"estimates. {capitalised(quantity.levels)} without an estimate from everyone have no "
            "within-participant interval."
        )
    return notes


def scales(cells: pd.DataFrame, rule: str) -> list[str]:
    """Warn if the rule leaves participants on different scales, or removes differences in level."""
    if rule == "modulus_equalisation" and len(cells) >= FEWEST:
        without = (
            "Modulus equalisation removes differences in level between participants: t-based "
            "intervals for means ignore these differences, and groups' levels cannot be compared."
        )
        return [without]
    largest = cells.max(axis=1)
    largest = largest[largest > 0]
    if rule not in ONE_FACTOR or len(largest) < FEWEST:
        return []
    apart = float(largest.max() / largest.median())
    apart = max(apart, float(largest.median() / largest.min()))
    if apart < SCALES_APART:
        return []
    sentence = (
        f"Participants used scales up to {apart:.0f} times larger or smaller than the "
        f"median participant's; the rule '{rule}' preserves these differences, so the "
        "largest numbers dominate the means. Compare with --normalise "
        "modulus_equalisation."
    )
    return [sentence]


def without_a_condition(prepared: Prepared | None) -> list[str]:
    """Report the means that are missing because a participant lacks a condition."""
    if prepared is None:
        return []
    lost = cell_means(prepared.trials).notna() & prepared.cells.isna()
    return [
        f"Means over conditions at {prepared.quantity.value(f'{level:g}')} are without "
        f"{listed(map(str, lost.index[lost[level]]))}, who did not judge it in every condition; "
        "a mean of the other conditions would not be comparable."
        for level in lost.columns[lost.any()]
    ]


def unequal(prepared: Prepared | None) -> list[str]:
    """Report unequal numbers of repetitions."""
    if prepared is None:
        return []
    counts = prepared.trials.groupby([PARTICIPANT, "level"], observed=True).size()
    if counts.min() == counts.max():
        return []
    sentence = (
        f"The number of repetitions differs: there are {counts.min()} to {counts.max()} "
        f"estimates of a {prepared.quantity.stimulus} per participant. Each participant's "
        "mean has the same weight, whatever the number of repetitions."
    )
    return [sentence]
