"""Everything `slipscale analyse` leaves behind: tables, figures, JSON, the report.

The same data and versions give the same bytes: no date, no path, no order by chance.
"""

from __future__ import annotations

import json
import platform
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import pandas as pd

from analysis.figures import estimates
from analysis.preprocessing import normalisation
from analysis.published import biet2007
from analysis.reporting import page
from analysis.reporting.csv_file import write_csv
from analysis.reporting.output_folder import make_folder
from analysis.statistics.run_all import plain
from faults import UserError

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure

    from analysis.result import Analysis

XML = '<?xml version="1.0" encoding="utf-8"?>\n'
SOFTWARE = ("slipscale", "numpy", "scipy", "pandas", "statsmodels", "pingouin", "matplotlib")


def write_analysis(analysis: Analysis, out: Path) -> Path:
    """Write tables, figures and the report into a folder, made if need be; return the report.

    Raises
    ------
    UserError
        A file cannot be written.
    """
    make_folder(out)
    try:
        for name, table in tables(analysis).items():
            write_csv(table, out / f"{name}.csv")
        for name, text in latex_tables(analysis).items():
            _write(out / f"{name}.tex", text)
        _write_json(out / "inference.json", analysis.inference)
        _write_json(out / "results.json", results(analysis))
        _write_json(out / "dataset_description.json", derivative_description(analysis))
        drawn = draw(analysis)
        svgs = {name: estimates.svg(figure, salt=name) for name, figure in drawn.items()}
        for name, figure in drawn.items():
            _write(out / f"{name}.svg", f"{XML}{svgs[name]}\n")
            estimates.save(figure, out / name, (".png", ".pdf"))
        report = out / "report.html"
        _write(report, page.render(analysis, svgs, software()))
    except OSError as error:
        raise UserError(
            f"{error.filename or out}: cannot be written ({error.strerror or error})"
        ) from error
    return report


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


def _write_json(path: Path, value: Any) -> None:
    _write(path, json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def software() -> dict[str, str]:
    """Return the versions that took part."""
    return {"python": platform.python_version()} | {name: version(name) for name in SOFTWARE}


def tables(analysis: Analysis) -> dict[str, pd.DataFrame]:
    """Return the tables to write as CSV, by name."""
    found: dict[str, pd.DataFrame] = {"quality": quality_table(analysis)}
    if len(analysis.individuals):
        found["individuals"] = analysis.individuals
    if analysis.prepared is not None:
        columns = ["participant_id", "session", "run", "trial", "amplitude_um_pp", "estimate"]
        columns += ["normalised", "response_time"]
        trials = analysis.estimates
        if (trials["trial"].dropna() % 1 == 0).all():
            trials = trials.astype({"trial": "Int64"})
        kept = [name for name in columns if not trials[name].isna().all()]
        found |= {
            "table3": analysis.table3,
            "descriptives": analysis.description,
            "estimates": trials[kept],
            "wide": wide(analysis),
        }
        if len(analysis.textures):
            found["textures"] = analysis.textures
        pairs = analysis.inference["pairwise"]
        if isinstance(pairs, list):
            found["pairwise"] = flat(pairs)
    steps = analysis.inference["difference"].get("steps")
    if steps:
        found["difference"] = flat(steps)
    return found


def flat(rows: list[dict[str, Any]]) -> pd.DataFrame:
    """Return results as a table; an interval ``[low, high]`` becomes two columns.

    >>> flat([{"ratio": 2.0, "ratio_ci": [1.5, 2.5]}]).columns.tolist()
    ['ratio', 'ratio_ci_low', 'ratio_ci_high']
    """
    cells: list[dict[str, Any]] = []
    for row in plain(rows):
        cells.append({})
        for name, value in row.items():
            parts = zip(("_low", "_high"), value, strict=True) if isinstance(value, list) else ()
            cells[-1] |= {name + end: bound for end, bound in parts} or {name: value}
    return pd.DataFrame(cells)


def wide(analysis: Analysis) -> pd.DataFrame:
    """Return one row a participant, as JASP, jamovi and SPSS want repeated measures.

    Names are letters, digits and underscores: ``estimate_0_5`` is the mean normalised estimate
    at 0.5 µm peak to peak, ``log_0_5`` the mean natural logarithm.
    """

    def named(table: pd.DataFrame, prefix: str) -> pd.DataFrame:
        return table.rename(columns=lambda a: f"{prefix}_{f'{a:g}'.replace('.', '_')}")

    parts = [named(analysis.cells, "estimate")]
    if analysis.prepared is not None:
        logs = analysis.prepared.logs.reindex(columns=analysis.cells.columns)
        parts.append(named(logs, "log"))
    table = pd.concat(parts, axis=1).rename_axis(columns=None)
    table.index = table.index.astype(str)
    table = table.rename_axis("participant_id").reset_index()
    about = analysis.dataset.participants
    if len(about.columns) > 1:
        about = about.drop_duplicates("participant_id")
        # Our columns keep their names; a column of participants.tsv of the same name is marked.
        table = table.merge(
            about, on="participant_id", how="left", suffixes=("", "_participants_tsv")
        )
    return table


def quality_table(analysis: Analysis) -> pd.DataFrame:
    """Return every participant's measures, flags and exclusion."""
    names = list(analysis.flags.columns)
    raised = [
        ";".join(name for name, on in zip(names, row, strict=True) if on)
        for row in analysis.flags.to_numpy(bool).tolist()
    ]
    table = analysis.measures.assign(
        flags=raised, excluded=analysis.measures.index.isin(list(analysis.excluded))
    )
    return table.reset_index()


def latex_tables(analysis: Analysis) -> dict[str, str]:
    """Return the tables for a paper, in LaTeX with booktabs."""
    if analysis.prepared is None:
        return {}
    heads = {
        "amplitude_um_pp": r"Amplitude ($\mu$m, p-p)",
        "n": "$n$",
        "mean": "Mean",
        "maximum_deviation": "Max.\\ dev.",
        "standard_deviation": "SD",
    }
    table = analysis.table3.rename(columns=heads)
    table[heads["amplitude_um_pp"]] = [f"{a:g}" for a in analysis.table3["amplitude_um_pp"]]
    convention = analysis.dataset.choices.standard_deviation
    rule = analysis.rule.replace("_", r"\_")
    found = {
        "table3": table.to_latex(
            index=False,
            float_format="%.2f",
            label="tab:estimates",
            caption=f"Normalised magnitude estimates (rule: {rule}; SD: {convention}).",
            column_format="rrrrr",
        )
    }
    pairs = analysis.inference["pairwise"]
    if isinstance(pairs, list):
        rows = pd.DataFrame(
            [
                {
                    r"From ($\mu$m)": f"{row['from_um_pp']:g}",
                    r"To ($\mu$m)": f"{row['to_um_pp']:g}",
                    "Ratio": row.get("ratio"),
                    "$t$": row.get("t"),
                    "df": row.get("df"),
                    r"$p_\mathrm{Holm}$": row.get("p_holm"),
                    "$d_z$": row.get("d_z"),
                }
                for row in pairs
            ]
        )
        found["pairwise"] = rows.to_latex(
            index=False,
            float_format="%.3f",
            na_rep="--",
            label="tab:pairwise",
            caption="Pairwise comparisons of log estimates, Holm-corrected.",
            column_format="rrrrrrr",
        )
    return found


def results(analysis: Analysis) -> dict[str, Any]:
    """Return everything, for machines."""
    data = analysis.dataset
    return {
        "dataset": data.name,
        "mode": data.mode,
        "sha256": data.sha256,
        "files": {source.name: source.sha256 for source in data.sources},
        "details": {key: list(values) for key, values in data.details.items()},
        "software": software(),
        "choices": data.choices.model_dump(),
        "frozen_in_the_study_file": list(data.frozen),
        "study_file_unchanged": data.unchanged,
        "counts": dict(data.counts),
        "problems": list(analysis.problems),
        "excluded": {who: list(why) for who, why in analysis.excluded.items()},
        "table3": analysis.table3.to_dict(orient="records"),
        "textures": analysis.textures.to_dict(orient="records"),
        "descriptives": analysis.description.to_dict(orient="records"),
        "inference": analysis.inference,
        "individuals": analysis.individuals.to_dict(orient="records"),
        "sensitivity": analysis.sensitivity,
        "robustness": analysis.robustness,
        "quality": quality_table(analysis).to_dict(orient="records"),
        "paper": [
            {name: getattr(row, name) for name in ("amplitude_um_pp", *biet2007.STATISTICS)}
            for row in biet2007.TABLE3
        ],
    }


def derivative_description(analysis: Analysis) -> dict[str, Any]:
    """Return the BIDS description of the output folder."""
    return {
        "Name": f"Slipscale's analysis of {analysis.dataset.name}",
        "BIDSVersion": "1.10.0",
        "DatasetType": "derivative",
        "GeneratedBy": [{"Name": "Slipscale", "Version": page.VERSION}],
    }


def draw(analysis: Analysis) -> dict[str, Figure]:
    """Return the figures that the data allows, by file name."""
    found: dict[str, Figure] = {}
    level = analysis.dataset.choices.confidence
    if analysis.prepared is not None:
        unit = normalisation.RULES[analysis.rule].unit
        found["fig15"] = estimates.fig15(analysis.cells, unit=unit, confidence=level)
        if "reason" not in analysis.inference["power_law"]:
            found["growth"] = estimates.growth(
                analysis.prepared.logs,
                analysis.inference["growth"],
                unit=unit,
                confidence=level,
            )
        if "reason" not in analysis.inference["rm_anova"]:
            found["residuals"] = estimates.residuals(analysis.prepared.whole_logs)
    if analysis.inference["difference"].get("steps"):
        found["difference"] = estimates.difference(
            analysis.inference["difference"],
            analysis.dataset.differences,
            confidence=level,
        )
    return found
