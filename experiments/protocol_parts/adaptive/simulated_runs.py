"""Simulate runs of an adaptive rule with a known psychometric function, without a session."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from slipscale.experiments.protocol_parts.adaptive.batched import QuestPlusBatch
from slipscale.experiments.protocol_parts.adaptive.quest_plus import QuestPlusTrack

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from slipscale.experiments.protocol_parts.adaptive.interleaved import Interleaved
    from slipscale.experiments.protocol_parts.adaptive.stopping import Stopping
    from slipscale.experiments.protocol_parts.adaptive.track import Track

    Array = NDArray[np.float64]
    #: Levels in µm peak to peak, and whether each answer was correct.
    Run = tuple[Array, NDArray[np.bool_]]


def simulated_runs(
    block: Interleaved,
    proportion: Callable[[Array], Array],
    runs: int,
    rng: np.random.Generator,
) -> list[Run]:
    """Simulate many runs, and return the levels and answers of each run.

    The tracks of a run are simulated one after the other instead of interleaved.

    Parameters
    ----------
    block : Interleaved
        Interleaved tracks in their initial state, with their stopping rule.
    proportion : callable
        Returns the proportion of correct answers at given levels, in µm peak to peak.
    runs : int
        Number of runs.
    rng : Generator
        Generates the answers.
    """
    per_track = []
    for track in block.tracks:
        if isinstance(track, QuestPlusTrack) and block.stopping.threshold_sd_log10 is None:
            per_track.append(_at_once(track, block.stopping.most_trials, proportion, runs, rng))
        else:
            known: dict[float, float] = {}
            per_track.append(
                [_one(track, block.stopping, proportion, known, rng) for _ in range(runs)]
            )
    return [
        (np.concatenate([run[0] for run in own]), np.concatenate([run[1] for run in own]))
        for own in zip(*per_track, strict=True)
    ]


def _one(
    track: Track,
    stopping: Stopping,
    proportion: Callable[[Array], Array],
    known: dict[float, float],
    rng: np.random.Generator,
) -> Run:
    """Simulate one run of a track; ``known`` caches proportions by level."""
    levels, answers = [], []
    while stopping.reason(track.progress) is None:
        level = track.level
        if level not in known:
            known[level] = float(proportion(np.array([level]))[0])
        correct = bool(rng.random() < known[level])
        levels.append(level)
        answers.append(correct)
        track = track.answered(correct=correct)
    return np.array(levels), np.array(answers, bool)


def _at_once(
    track: QuestPlusTrack,
    trials: int,
    proportion: Callable[[Array], Array],
    runs: int,
    rng: np.random.Generator,
) -> list[Run]:
    """Simulate many QUEST+ runs of a fixed number of trials simultaneously."""
    batch = QuestPlusBatch.start(track.rule, runs)
    levels, answers = [], []
    for _ in range(trials):
        levels.append(batch.levels)
        answers.append(rng.random(runs) < proportion(levels[-1]))
        batch = batch.answered(answers[-1])
    return list(zip(np.stack(levels, axis=1), np.stack(answers, axis=1), strict=True))
