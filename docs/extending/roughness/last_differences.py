"""Compute each participant's mean of the last four differences in a shrinking-difference task."""

import pandas as pd

from slipscale.task import NotComputed, OwnResult, own_analysis, styled

LAST = 4


def differences(own):
    """Yield each task's trials with the difference between the intervals, in µm peak to peak."""
    for task, rows in own.dataset.others.items():
        if {"rougher", "interval2_level"} <= set(rows):
            change = rows["interval1_level"] - rows["interval2_level"]
            yield task, rows.assign(difference_level=change.abs())


@styled
def drawn(tasks):
    """Plot the difference in each trial, with one line per participant and task."""
    from matplotlib.figure import Figure  # Imported only if a figure is drawn.

    figure = Figure(figsize=(6, 3.5), layout="constrained")
    axes = figure.subplots()
    for (task, rows), style in zip(tasks, ("-", "--", ":", "-."), strict=False):
        for who, own in rows.groupby("participant_id", observed=True):
            axes.plot(own["trial"], own["difference_level"], style, label=f"{who}, {task}")
    axes.set(xlabel="Trial", ylabel="Difference (µm, peak to peak)")
    axes.legend(fontsize="small")
    return figure


def analysis(own):
    """Return the result of the analysis, or the reason why it cannot be computed."""
    tasks = list(differences(own))
    if not tasks:
        return NotComputed("no trials of a shrinking-difference task")
    tables, numbers, sentences = [], {}, []
    for task, rows in tasks:
        last = rows.groupby("participant_id", observed=True)["difference_level"].apply(
            lambda each: each.tail(LAST).mean()
        )
        tables.append(last.reset_index().assign(task=task))
        numbers[task] = {"mean_level": float(last.mean()), "participants": len(last)}
        sentences.append(
            f"The mean of the last {LAST} differences in {task} was {last.mean():.2f} µm (peak to "
            f"peak, {len(last)} participants)."
        )
    return OwnResult(
        sentences=tuple(sentences),
        numbers=numbers,
        table=pd.concat(tables, ignore_index=True),
        table_caption=f"Mean of each participant's last {LAST} differences, µm peak to peak.",
        figure=drawn(tasks),
        figure_caption="Differences that were presented, trial by trial.",
        figure_alt="Differences between the intervals, with one line per participant and task",
    )


ANALYSIS = own_analysis("last_differences", title="Shrinking differences", run=analysis)
