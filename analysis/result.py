"""What an analysis found: one frozen structure that tables, figures and pages are made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd

    from analysis.preprocessing.log_transform import Prepared
    from analysis.reading.dataset import Dataset


@dataclass(frozen=True, slots=True, kw_only=True)
class Analysis:
    """What was found.

    Parameters
    ----------
    dataset : Dataset
        What was analysed: as read, less the participants excluded.
    rule : str
        The normalisation, a key of `analysis.preprocessing.normalisation.RULES`.
    estimates : DataFrame
        Analysed trials with their ``normalised`` estimate, ``log``, ``position``, ``repetition``.
    cells : DataFrame, shape (participants, amplitudes)
        Participants' mean normalised estimates.
    table3, description : DataFrame
        See `analysis.statistics.descriptives`.
    textures : DataFrame
        See `analysis.statistics.textures.describe`.
    inference : Mapping
        What ``inference.json`` holds, see `analysis.statistics.run_all`.
    sensitivity, robustness : list
        Results under other normalisations, and without flagged participants.
    individuals : DataFrame
        See `analysis.statistics.individuals`.
    measures, flags : DataFrame
        Data quality of every participant read, see `analysis.preprocessing.data_quality`.
    excluded : Mapping
        Participant -> the flags that excluded them.
    problems : tuple of str
        What was wrong with the data or could not be computed, one sentence each.
    """

    dataset: Dataset
    rule: str
    estimates: pd.DataFrame
    cells: pd.DataFrame
    table3: pd.DataFrame
    description: pd.DataFrame
    textures: pd.DataFrame
    prepared: Prepared | None
    inference: Mapping[str, Any]
    sensitivity: list[dict[str, Any]]
    robustness: list[dict[str, Any]]
    individuals: pd.DataFrame
    measures: pd.DataFrame
    flags: pd.DataFrame
    excluded: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
