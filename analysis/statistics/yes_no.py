"""The descending difference: who felt a step, who said so where nothing changed, and what went.

Without catch steps "yes" is confounded with bias, and d' does not exist.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from analysis.statistics.omnibus import Result, interval_name, mean_with_interval, reason
from analysis.statistics.psychometric import psychometric
from analysis.statistics.verbal_coding import code_reports
from experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    import pandas as pd

    from analysis.statistics.verbal_coding import Codebook


def exact_interval(yes: int, n: int, confidence: float = 0.95) -> list[float]:
    """Return Clopper and Pearson's exact interval of a proportion."""
    from statsmodels.stats.proportion import proportion_confint  # noqa: PLC0415

    low, high = proportion_confint(yes, n, alpha=1 - confidence, method="beta")
    return [float(np.nan_to_num(low, nan=0.0)), float(np.nan_to_num(high, nan=1.0))]


def d_prime(hits: float, signals: float, false_alarms: float, noises: float) -> tuple[float, float]:
    """Return d' and the criterion c of a yes-no task, with the log-linear correction.

    Half a response is added to hits and false alarms, one trial to each kind, always (Hautus
    1995, Behav. Res. Methods Instrum. Comput. 27, 46-51), so that rates of 0 and 1 stay finite.

    >>> d, c = d_prime(10, 20, 10, 20)
    >>> round(d, 12), round(c, 12)
    (0.0, 0.0)
    """
    from scipy.special import ndtri  # noqa: PLC0415

    hit = float(ndtri((hits + 0.5) / (signals + 1)))
    alarm = float(ndtri((false_alarms + 0.5) / (noises + 1)))
    return hit - alarm, 0.0 - (hit + alarm) / 2


def analyse_differences(steps: pd.DataFrame, book: Codebook, confidence: float = 0.95) -> Result:
    """Return everything about the descending difference, as ``inference.json`` has it.

    Parameters
    ----------
    steps : DataFrame
        `analysis.reading.dataset.Dataset.differences`.
    book : Codebook
        Codes the verbal reports.
    confidence : float
        Of every interval.
    """
    if not len(steps):
        return reason("no answered steps of the descending difference")
    changes = steps[~steps["catch"]]
    catches = steps[steps["catch"]]
    by_step = changes.groupby(["amplitude_before_um_pp", "amplitude_um_pp"])["difference_felt"]
    counted = by_step.agg(["size", "sum"]).sort_index(ascending=False)
    rows = []
    for (before, after), (n, yes) in zip(
        counted.index.tolist(), counted.to_numpy(int).tolist(), strict=True
    ):
        rows.append(
            {
                "from_um_pp": float(before),
                "to_um_pp": float(after),
                "n": n,
                "yes": yes,
                interval_name(confidence): exact_interval(yes, n, confidence),
            }
        )
    catch_n, catch_yes = len(catches), int(catches["difference_felt"].sum())
    catch: Result = {"n": catch_n, "yes": catch_yes}
    if catch_n:
        catch[interval_name(confidence)] = exact_interval(catch_yes, catch_n, confidence)
    detection = signal_detection(changes, catches, confidence)
    return {
        "steps": rows,
        "catch": catch,
        "d_prime": detection.get("pooled_d_prime", detection),
        "signal_detection": detection,
        "psychometric": psychometric(steps, confidence),
        "verbal_reports": code_reports(changes, book),
        "finding": finding(changes, book),
        "participants": int(steps[PARTICIPANT].nunique()),
        "answers_per_participant_and_step": _repetitions(changes),
    }


def _repetitions(changes: pd.DataFrame) -> float:
    cells = changes.groupby(
        [PARTICIPANT, "amplitude_before_um_pp", "amplitude_um_pp"], observed=True
    )
    return float(cells.size().mean()) if len(changes) else 0.0


def signal_detection(changes: pd.DataFrame, catches: pd.DataFrame, confidence: float) -> Result:
    """Return d' and c, pooled and of each participant who had both kinds of step."""
    if not len(catches):
        return reason("no catch steps: 'yes' cannot be told from a readiness to say yes")
    if not len(changes):
        return reason("no steps on which the amplitude changed")
    counts = {
        "hits": int(changes["difference_felt"].sum()),
        "changes": len(changes),
        "false_alarms": int(catches["difference_felt"].sum()),
        "catches": len(catches),
    }
    pooled = d_prime(*counts.values())
    signals = changes.groupby(changes[PARTICIPANT].astype(str))["difference_felt"].agg(
        ["sum", "size"]
    )
    noises = catches.groupby(catches[PARTICIPANT].astype(str))["difference_felt"].agg(
        ["sum", "size"]
    )
    both = signals.add_suffix("_signal").join(noises.add_suffix("_noise"), how="inner")
    own: dict[str, Any] = {}
    for who, row in zip(both.index, both.to_numpy(float), strict=True):
        sensitivity, criterion = d_prime(*row)
        own[str(who)] = dict(zip(counts, map(int, row), strict=True)) | {
            "d_prime": sensitivity,
            "criterion": criterion,
        }
    values = np.array([found["d_prime"] for found in own.values()])
    return {
        "pooled_d_prime": pooled[0],
        "pooled_criterion": pooled[1],
        **counts,
        "mean_of_participants": mean_with_interval(values, confidence),
        "participants": own,
    }


def finding(changes: pd.DataFrame, book: Codebook) -> Result:
    """Compute the paper's finding: all felt a difference, and what went was slipperiness.

    "All of the subjects feel clearly the difference during the test, and they immediately say
    that it is 'less slippery'" (Section IV-B).
    """
    felt = changes["difference_felt"].groupby(changes[PARTICIPANT].astype(str)).agg(["max", "min"])
    n = len(felt)
    said = changes[(changes["difference_felt"] == 1) & (changes["verbal_report"] != "")]
    meanings = said["verbal_report"].astype(str).map(book.meaning)
    less = said[PARTICIPANT].astype(str)[meanings == "less_slippery"].nunique()
    ever, always = int((felt["max"] == 1).sum()), int((felt["min"] == 1).sum())
    return {
        "n": n,
        "felt_a_difference": ever,
        "felt_every_change": always,
        "said_less_slippery": less,
        "all_felt_a_difference": n > 0 and ever == n,
        "all_said_less_slippery": n > 0 and less == n,
    }
