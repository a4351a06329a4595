"""From a data set to everything `slipscale analyse` writes.

Each stage is a function of data, usable by itself in a notebook; this module calls them in
order, under the study's frozen choices, and writes what they say.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from analysis import descriptives, normalisation
from analysis.loading import Dataset, load
from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd


@dataclass(frozen=True, slots=True, kw_only=True)
class Analysis:
    """What was found.

    Parameters
    ----------
    dataset : Dataset
        As read.
    rule : str
        The normalisation, a key of `analysis.normalisation.RULES`.
    estimates : DataFrame
        Analysed trials with their ``normalised`` estimate.
    cells : DataFrame, shape (participants, amplitudes)
        Participants' mean normalised estimates.
    table3 : DataFrame
        See `analysis.descriptives.table3`.
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
    problems: tuple[str, ...]
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
    if not len(data.estimates) and not len(data.differences):
        raise UserError(f"{data.name}: no answered trials; nothing to analyse")
    tell("describing")
    rule, notes = _choose_rule(data, normalise)
    estimates = data.estimates.assign(normalised=normalisation.normalise(data.estimates, rule))
    cells = normalisation.cell_means(estimates, "normalised")
    analysis = Analysis(
        dataset=data,
        rule=rule,
        estimates=estimates,
        cells=cells,
        table3=descriptives.table3(cells, data.choices.standard_deviation),
        problems=(*data.problems, *notes, *_what_is_thin(cells)),
        out=None if not write else Path(out) if out else default_out(data, dataset),
    )
    if analysis.out is not None:
        tell("writing tables, figures and the report")
        _write(analysis, analysis.out)
    return analysis


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
                f"Mixed scales: {int(tops.isna().sum())} of {len(tops)} trials have no declared "
                f"scale top; all are normalised by '{rule}' instead."
            )
        ]
    return rule, []


def default_out(data: Dataset, source: str | Path | Dataset) -> Path:
    """Return where the output goes when the user does not say."""
    if data.folder is not None:
        return data.folder / "derivatives" / "slipscale"
    if isinstance(source, Dataset):
        raise UserError(f"{data.name}: a table by hand; say where the output goes (--out)")
    path = Path(source)
    return path.with_name(f"{path.stem}-slipscale")


def _what_is_thin(cells: pd.DataFrame) -> list[str]:
    """Say what so few data cannot tell."""
    notes = []
    participants, amplitudes = cells.shape
    if participants == 1:
        notes.append(
            "One participant: means are shown; standard deviations, intervals and tests need "
            "at least two."
        )
    if amplitudes == 1:
        notes.append("One amplitude: nothing to compare, no growth and no tests.")
    if participants and not (cells.to_numpy() > 0).any():
        notes.append("All estimates are zero: no spread, no growth and no tests.")
    missing = cells.index[cells.isna().any(axis=1)].astype(str)
    if len(missing):
        listed = ", ".join(missing[:6]) + (" and more" if len(missing) > 6 else "")  # noqa: PLR2004
        notes.append(
            f"{len(missing)} of {participants} participants lack an estimate at some amplitude "
            f"({listed}); means use all, within-participant intervals and tests the complete ones."
        )
    return notes


def _write(analysis: Analysis, out: Path) -> None:
    # Matplotlib takes a second to load: not before something is to be drawn.
    from analysis import figures, report  # noqa: PLC0415

    try:
        out.mkdir(parents=True, exist_ok=True)
        analysis.table3.to_csv(out / "table3.csv", index=False, lineterminator="\n")
        columns = [
            name
            for name in (
                "participant_id",
                "session",
                "run",
                "trial",
                "amplitude_um_pp",
                "estimate",
                "normalised",
                "response_time",
            )
            if not analysis.estimates[name].isna().all()
        ]
        analysis.estimates[columns].to_csv(
            out / "estimates.csv", index=False, na_rep="n/a", lineterminator="\n"
        )
        fig15 = figures.fig15(
            analysis.cells,
            unit=normalisation.RULES[analysis.rule].unit,
            confidence=analysis.dataset.choices.confidence,
        )
        figures.save(fig15, out / "fig15")
        (out / "report.html").write_text(
            report.render(analysis, figures.svg(fig15)), encoding="utf-8", newline="\n"
        )
        description: dict[str, Any] = {
            "Name": f"Slipscale's analysis of {analysis.dataset.name}",
            "BIDSVersion": "1.10.0",
            "DatasetType": "derivative",
            "GeneratedBy": [{"Name": "Slipscale", "Version": report.VERSION}],
        }
        text = json.dumps(description, indent=2) + "\n"
        (out / "dataset_description.json").write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise UserError(f"{out}: cannot be written ({error.strerror})") from error
