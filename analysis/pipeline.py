"""From a data set to everything `slipscale analyse` writes.

Each stage is a function of data, usable by itself in a notebook; this module calls them in
order, under the study's frozen choices. Exclusion comes first, by the study's rule, before
anything is described or tested.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from analysis import conclude, descriptives, normalisation, notices, quality, textures
from analysis.dataset import Dataset
from analysis.folders import make_folder
from analysis.individuals import individuals
from analysis.loading import load
from analysis.prepared import Prepared, prepare
from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import pandas as pd


@dataclass(frozen=True, slots=True, kw_only=True)
class Analysis:
    """What was found.

    Parameters
    ----------
    dataset : Dataset
        What was analysed: as read, less the participants excluded.
    rule : str
        The normalisation, a key of `analysis.normalisation.RULES`.
    estimates : DataFrame
        Analysed trials with their ``normalised`` estimate, ``log``, ``position``, ``repetition``.
    cells : DataFrame, shape (participants, amplitudes)
        Participants' mean normalised estimates.
    table3, description : DataFrame
        See `analysis.descriptives`.
    textures : DataFrame
        See `analysis.textures.describe`.
    inference : Mapping
        What ``inference.json`` holds, see `analysis.conclude`.
    sensitivity, robustness : list
        Results under other normalisations, and without flagged participants.
    individuals : DataFrame
        See `analysis.individuals`.
    measures, flags : DataFrame
        Data quality of every participant read, see `analysis.quality`.
    excluded : Mapping
        Participant -> the flags that excluded them.
    problems : tuple of str
        What was wrong with the data or could not be computed, one sentence each.
    out : Path or None
        Where the files are; None where nothing was written.
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
    out: Path | None = None

    @property
    def report(self) -> Path | None:
        """The report's path, where it was written."""
        return self.out / "report.html" if self.out else None


def analyse(
    dataset: str | Path | Dataset,
    out: str | Path | None = None,
    *,
    normalise: str | None = None,
    write: bool = True,
    progress: Callable[[str], None] | None = None,
) -> Analysis:
    """Analyse a data set and write tables, figures and the report.

    Parameters
    ----------
    dataset : str, Path or Dataset
        A data set's folder, a tidy table, or what `analysis.loading.load` returned.
    out : str or Path, optional
        Folder for the output; by default ``derivatives/slipscale`` in the data set, or beside a
        tidy table a folder with its name and ``-slipscale``.
    normalise : str, optional
        A rule of `analysis.normalisation.RULES`, in place of the study's frozen one.
    write : bool
        False writes nothing.
    progress : callable, optional
        Told in a few words what comes next.

    Raises
    ------
    UserError
        The data cannot be read, holds nothing to analyse, or does not allow the rule.
    """
    tell = progress or (lambda _: None)
    tell("reading the data")
    data = dataset if isinstance(dataset, Dataset) else load(dataset)
    target = None if not write else Path(out) if out else default_out(data, dataset)
    if not len(data.estimates) and not len(data.differences):
        raise UserError(f"{data.name}: {notices.nothing(data)}")
    if target is not None:
        make_folder(target)
    absences = notices.absent(data)
    tell("checking data quality")
    measures = quality.measures(data, data.choices.thresholds)
    flags = quality.flags(measures, data.choices.thresholds)
    data, excluded = exclude(data, flags)
    tell("describing")
    rule, notes = _choose_rule(data, normalise)
    estimates = data.estimates.assign(normalised=normalisation.normalise(data.estimates, rule))
    prepared = prepare(estimates, data.choices) if len(estimates) else None
    cells = prepared.cells if prepared else normalisation.cell_means(estimates, "normalised")
    choices = data.choices
    description = descriptives.describe(
        cells,
        prepared.logs if prepared else cells,
        confidence=choices.confidence,
        resamples=choices.bootstrap_resamples,
        seed=choices.bootstrap_seed,
    )
    tell("testing")
    inference = conclude.conclude(data, prepared, rule if prepared else None)
    analysis = Analysis(
        dataset=data,
        rule=rule,
        estimates=prepared.trials if prepared else estimates,
        cells=cells,
        table3=descriptives.table3(cells, choices.standard_deviation),
        description=description,
        textures=textures.describe(data.textures, data.estimates, rule, choices.standard_deviation),
        prepared=prepared,
        inference=inference,
        sensitivity=conclude.sensitivity(data.estimates, rule) if prepared else [],
        robustness=conclude.robustness(prepared, set(flags.index[flags.any(axis=1)]))
        if prepared
        else [],
        individuals=individuals(prepared, inference),
        measures=measures,
        flags=flags,
        excluded=excluded,
        problems=(
            *data.problems,
            *absences,
            *notes,
            *notices.changing_tops(data),
            *notices.beyond_tops(data),
            *notices.thin(cells),
            *notices.scales(cells, rule),
            *notices.unequal(prepared),
        ),
        out=target,
    )
    if target is not None:
        tell("writing tables, figures and the report")
        # Matplotlib takes a second to load: not before something is to be drawn.
        from analysis.outputs import write_all  # noqa: PLC0415

        write_all(analysis, target)
    return analysis


def exclude(data: Dataset, flags: pd.DataFrame) -> tuple[Dataset, dict[str, tuple[str, ...]]]:
    """Return the data without the participants whom the study's rule excludes, and why."""
    rules: list[str] = list(data.choices.exclusions)
    if not rules:
        return data, {}
    out = flags.index[flags[rules].any(axis=1)]
    why = {str(who): tuple(name for name in rules if bool(flags.loc[who, name])) for who in out}
    if why and len(why) == len(flags):
        raise UserError(
            f"{data.name}: the study's exclusions ({', '.join(rules)}) leave no participant"
        )

    def keep(rows: pd.DataFrame) -> pd.DataFrame:
        if not why or not len(rows):
            return rows
        kept = rows[~rows[normalisation.KEY].isin(list(why))].reset_index(drop=True)
        people = kept[normalisation.KEY].cat.remove_unused_categories()
        return kept.assign(**{normalisation.KEY: people})

    return (
        replace(
            data,
            estimates=keep(data.estimates),
            answers=keep(data.answers),
            differences=keep(data.differences),
            textures=keep(data.textures),
        ),
        why,
    )


def default_out(data: Dataset, source: str | Path | Dataset) -> Path:
    """Return where the output goes when the user does not say."""
    if data.folder is not None:
        return data.folder / "derivatives" / "slipscale"
    if isinstance(source, Dataset):
        raise UserError(f"{data.name}: a table by hand; say where the output goes (--out)")
    path = Path(source)
    return path.with_name(f"{path.stem}-slipscale")


def _choose_rule(data: Dataset, asked: str | None) -> tuple[str, list[str]]:
    """Return the user's rule, else the study's, else the default; and what to say about it."""
    frozen = data.choices.normalisation
    if asked and frozen and asked != frozen:
        return asked, [f"The study froze the normalisation '{frozen}'; '{asked}' was asked for."]
    if asked or frozen:
        return str(asked or frozen), []
    rule = normalisation.default_rule(data.estimates)
    if not (data.estimates["estimate"] > 0).any():
        return "none", []
    tops = data.estimates["scale_top"]
    if rule != "scale_top" and tops.notna().any():
        return rule, [
            (
                f"Mixed scales: {int((~(tops > 0)).sum())} of {len(tops)} trials have no declared "
                f"scale top above 0; all are normalised by '{rule}' instead."
            )
        ]
    return rule, []
