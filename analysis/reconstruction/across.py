"""What `slipscale reconstruct --conclusions` says across columns."""

from __future__ import annotations

from dataclasses import asdict
from itertools import groupby
from math import isfinite
from typing import TYPE_CHECKING, Any

from analysis.reconstruction.conclusions import conclusions
from analysis.reconstruction.distributions import distributions
from analysis.reconstruction.sampling import LISTED, Sampler

if TYPE_CHECKING:
    from collections.abc import Sequence

    from analysis.reconstruction.solutions import Solutions

P = ("p_low", "p_high")


def record(columns: Sequence[Solutions], measure: str, seed: int) -> dict[str, Any]:
    """Return bounds and distributions; no bounds where the data sets are too many to list.

    Raises
    ------
    UserError
        The columns cannot stand side by side.
    """
    samplers = [Sampler(solutions, measure) for solutions in columns]
    spread = distributions(samplers, seed)
    long = [s.column.label for s in columns if s.multisets > LISTED]
    bounds = [] if long else conclusions(samplers)
    return {
        "always": [_plain(asdict(found)) for found in bounds if found.decided],
        "depends": [_plain(asdict(found)) for found in bounds if not found.decided],
        "not_bounded": long,
        "distributions": [_plain(asdict(found)) for found in spread],
    }


def _plain(entry: dict[str, Any]) -> dict[str, Any]:
    """Replace infinity, which JSON has not, by None."""
    return {key: None if _infinite(value) else value for key, value in entry.items()} | (
        {"quantiles": [[p, None if _infinite(v) else v] for p, v in entry["quantiles"]]}
        if "quantiles" in entry
        else {}
    )


def _infinite(value: object) -> bool:
    return isinstance(value, float) and not isfinite(value)


def lines(found: dict[str, Any]) -> list[str]:
    """Return the answer for people, a line each."""
    said = []
    for key, heading in (
        ("always", "The same answer in every data set and pairing"),
        ("depends", "Depends on the data set or the pairing"),
    ):
        if found[key]:
            said += [heading, *map(_bound, found[key]), ""]
    if found["not_bounded"]:
        said += [
            f"No bounds: more than {LISTED:,} multisets in {', '.join(found['not_bounded'])}",
            "",
        ]
    first = found["distributions"][0]
    said.append(
        f"Over {first['samples']:,} uniform samples ({first['measure']}, seed {first['seed']}), "
        "by pairing: median, 2.5 % and 97.5 % quantile, share with p < 0.05"
    )
    for question, rows in groupby(found["distributions"], key=lambda row: row["question"]):
        said += [f"  {question}", *map(_distribution, rows)]
    return [*said, ""]


def _bound(entry: dict[str, Any]) -> str:
    sharp = "" if entry["sharp"] else " (a bound, perhaps not attained)"
    if entry["high"] is None:
        return f"  {entry['question']} {_number(entry['low'])}, p at most {entry['p_high']:.2g}"
    extent = _join(_number(entry["low"]), _number(entry["high"]))
    p = "" if entry["p_low"] is None else ", p " + _join(*(f"{entry[k]:.2g}" for k in P))
    return f"  {entry['question']}: {extent}{p}{sharp}"


def _distribution(row: dict[str, Any]) -> str:
    at = dict(row["quantiles"])
    share = "" if row["significant"] is None else f"{row['significant']:.1%}"
    values = "".join(f"{_number(at[q]):>9}" for q in (0.5, 0.025, 0.975))
    return f"    {row['pairing']:<17}{values}{share:>9}  {row['method']}"


def _join(low: str, high: str) -> str:
    return low if low == high else f"{low} to {high}"


def _number(value: float | None) -> str:
    return "infinite" if value is None else f"{value:.4g}"
