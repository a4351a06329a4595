"""Rows as they were written, made into columns that can be counted on.

Numbers become numbers, answers become 1 and 0, missing labels become their default; every cell
that is not what its column asks for is named by file and line and becomes missing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis.tables import Problems, Source, numbers, places

if TYPE_CHECKING:
    from collections.abc import Sequence

#: Amplitudes are told apart to 0.1 nm: 0.1 + 0.2 µm is 0.3 µm.
DECIMALS = 4
TRUE, FALSE = {"yes", "true", "1", "1.0"}, {"no", "false", "0", "0.0"}


def clean_estimates(
    frame: pd.DataFrame, sources: Sequence[Source], problems: Problems
) -> pd.DataFrame:
    """Return rows with every column of the tidy table, numbers as numbers."""
    clean = pd.DataFrame(
        {
            "participant_id": frame["participant_id"].astype("category"),
            "session": _labels(frame, "session", ""),
            "run": _labels(frame, "run", "1"),
            "file": frame["file"],
            "line": frame["line"],
        }
    )
    for column in ("amplitude_um_pp", "estimate"):
        clean[column] = numbers(frame, column, sources, problems, minimum=0.0)
    clean["amplitude_um_pp"] = clean["amplitude_um_pp"].round(DECIMALS)
    for column in ("trial", "block", "response_time", "scale_top", "modulus"):
        clean[column] = (
            numbers(frame, column, sources, problems, minimum=0.0, lost="the cell")
            if column in frame and frame[column].notna().any()
            else np.nan
        )
    clean["phase"] = _labels(frame, "phase", "main")
    clean["flag"] = _labels(frame, "flag", "")
    clean["texture"] = _labels(frame, "texture", "")
    return _without_doubles(clean, sources, problems)


def clean_differences(
    frame: pd.DataFrame, sources: Sequence[Source], problems: Problems
) -> pd.DataFrame:
    """Return steps of the descending difference; ``difference_felt`` is 1, 0 or missing."""
    clean = pd.DataFrame(
        {name: frame[name] for name in ("participant_id", "session", "run", "file", "line")}
    )
    for column in ("amplitude_before_um_pp", "amplitude_um_pp"):
        clean[column] = numbers(frame, column, sources, problems, minimum=0.0).round(DECIMALS)
    for column in ("trial", "series", "step", "confidence", "response_time"):
        clean[column] = (
            numbers(frame, column, sources, problems, lost="the cell")
            if column in frame and frame[column].notna().any()
            else np.nan
        )
    felt = frame["difference_felt"].astype("object").map(lambda v: str(v).strip().lower())
    clean["difference_felt"] = felt.map(dict.fromkeys(TRUE, 1.0) | dict.fromkeys(FALSE, 0.0))
    wrong = clean["difference_felt"].isna() & frame["difference_felt"].notna()
    problems.add_many(
        [
            f"{place}, column difference_felt: '{value}' where yes or no was expected; "
            "the step is left out"
            for place, value in zip(
                places(frame[wrong], sources), frame.loc[wrong, "difference_felt"], strict=True
            )
        ],
        "column difference_felt",
    )
    clean["catch"] = _catches(frame, clean, problems)
    clean["verbal_report"] = _labels(frame, "verbal_report", "")
    clean["phase"] = _labels(frame, "phase", "main")
    clean["flag"] = _labels(frame, "flag", "")
    return _without_doubles(clean, sources, problems)


def _catches(frame: pd.DataFrame, clean: pd.DataFrame, problems: Problems) -> pd.Series[bool]:
    """Tell catch steps by the amplitudes, which were presented; say where the column differs."""
    unchanged = clean["amplitude_before_um_pp"] == clean["amplitude_um_pp"]
    if "catch" in frame:
        said = frame["catch"].astype("object").map(lambda v: str(v).strip().lower())
        for sentence, wrong in (
            ("catch steps change the amplitude; they count as steps", said.isin(TRUE) & ~unchanged),
            (
                "steps leave the amplitude as it was; they count as catch steps",
                ~said.isin(TRUE) & unchanged,
            ),
        ):
            if wrong.any():
                problems.add(f"{int(wrong.sum())} {sentence}")
    return unchanged


def _labels(frame: pd.DataFrame, column: str, missing: str) -> pd.Series[Any]:
    if column not in frame:
        return pd.Series(pd.Categorical([missing] * len(frame)), index=frame.index)
    values = frame[column].astype("category")
    values = values.cat.rename_categories([str(name) for name in values.cat.categories])
    if missing not in values.cat.categories:
        values = values.cat.add_categories(missing)
    return values.fillna(missing)


def _without_doubles(
    clean: pd.DataFrame, sources: Sequence[Source], problems: Problems
) -> pd.DataFrame:
    """Drop and name rows that give the same trial of the same run once more."""
    if clean["trial"].isna().all():
        return clean
    key = ["participant_id", "session", "run", "phase", "trial"]
    doubled = clean["trial"].notna() & clean.duplicated(key, keep="first")
    doubled &= ~clean["flag"].astype(str).str.contains("voided") if doubled.any() else doubled
    problems.add_many(
        [
            f"{place}: trial {trial:g} of {who} is there a second time; the first is kept"
            for place, trial, who in zip(
                places(clean[doubled], sources),
                clean.loc[doubled, "trial"],
                clean.loc[doubled, "participant_id"],
                strict=True,
            )
        ],
        "doubled trials",
    )
    return clean[~doubled].reset_index(drop=True) if doubled.any() else clean


def empty_estimates() -> pd.DataFrame:
    """Return the columns of `clean_estimates`, without a row."""
    text = ("participant_id", "session", "run", "phase", "flag", "texture")
    values = ("trial", "block", "amplitude_um_pp", "estimate", "response_time", "scale_top")
    columns: dict[str, Any] = {name: pd.Categorical([]) for name in text}
    columns |= {name: np.array([], float) for name in (*values, "modulus", "file", "line")}
    return pd.DataFrame(columns)


def empty_differences() -> pd.DataFrame:
    """Return the columns of `clean_differences`, without a row."""
    text = ("participant_id", "session", "run", "phase", "flag", "verbal_report")
    values = ("trial", "series", "step", "amplitude_before_um_pp", "amplitude_um_pp")
    columns: dict[str, Any] = {name: pd.Categorical([]) for name in text}
    columns |= {name: np.array([], float) for name in (*values, "difference_felt", "confidence")}
    return pd.DataFrame(columns | {"catch": np.array([], bool)})
