"""Tests on magnitude estimates: called from SciPy, statsmodels and pingouin, with their traps shut.

Each test takes a `Prepared` and returns its numbers, or ``{"reason": ...}``: constant data, too
few participants or conditions are checked first, because the libraries answer them with a
silent NaN. Tables of tests at the end say which there are.
"""

from __future__ import annotations

import warnings
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis.normalisation import KEY

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from analysis.prepared import Prepared

Result = dict[str, Any]
#: A mixed model of more participants takes minutes and says what the slopes' t interval says.
MIXED_MODEL_AT_MOST = 200
#: Wilcoxon's test is exact up to so many differences without and with ties.
EXACT_AT_MOST, EXACT_WITH_TIES = 50, 13
#: Differences below this, relative, are rounding.
TINY = 1e-12
#: Fewer participants than this give no test.
FEWEST = 3


def reason(text: str) -> Result:
    """Return what stands in place of a result that could not be computed."""
    return {"reason": text}


def lacking(table: pd.DataFrame, conditions: int = 2) -> str | None:
    """Say why a table of participants by amplitudes allows no test, or None."""
    n, k = table.shape
    if k < conditions:
        return f"{k} amplitudes; {conditions} or more are needed"
    if n < FEWEST:
        return (
            f"{n} participants with a usable estimate at every amplitude; "
            f"{FEWEST} or more are needed"
        )
    return None


def additive_residuals(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return what participants' and amplitudes' means leave, shape as ``values``."""
    rows, columns = values.mean(axis=1, keepdims=True), values.mean(axis=0, keepdims=True)
    return np.asarray(values - rows - columns + values.mean())


def _is_constant(values: NDArray[np.float64]) -> bool:
    scale = max(float(np.abs(values).max()), 1.0)
    return bool(np.abs(additive_residuals(values)).max() <= TINY * scale)


def _log_table(data: Prepared, conditions: int = 2) -> tuple[pd.DataFrame, str | None]:
    """Return the complete table of mean logarithms, and why it allows no test."""
    table = data.whole_logs
    if data.refused:
        return table, data.zero_sentence
    return table, lacking(table, conditions)


def _rank_table(data: Prepared) -> tuple[pd.DataFrame, str | None]:
    """Return the complete table of mean estimates, and why it allows no test on ranks."""
    table = data.whole
    why = lacking(table, 3)
    if why is None and (np.ptp(table.to_numpy(float), axis=1) == 0).all():
        why = "every participant's estimates are all the same"
    return table, why


def _dropped(data: Prepared, table: pd.DataFrame) -> dict[str, int]:
    return {"n": len(table), "n_incomplete": len(data.cells) - len(table)}


def rm_anova(data: Prepared) -> Result:
    """Repeated-measures analysis of variance of participants' mean logarithms.

    Sphericity: Mauchly's test; degrees of freedom corrected after Greenhouse and Geisser and
    after Huynh and Feldt. Effect size: generalised eta squared (Olejnik and Algina 2003), with a
    bootstrap interval over participants. From pingouin and SciPy.
    """
    import pingouin  # noqa: PLC0415 - a second's import
    from scipy import stats  # noqa: PLC0415

    table, why = _log_table(data)
    if why:
        return reason(why)
    values = table.to_numpy(float)
    if _is_constant(values):
        return reason("no variance is left beside participants' and amplitudes' means")
    long = _long(table)
    corrected = values.shape[1] > 2  # noqa: PLR2004 - two conditions are always spherical
    with warnings.catch_warnings():
        _mute_known(warnings)
        found = pingouin.rm_anova(
            data=long,
            dv="value",
            within="amplitude",
            subject="who",
            correction=True,
            detailed=True,
            effsize="ng2",
        ).iloc[0]
        epsilon_hf = float(pingouin.epsilon(table, correction="hf")) if corrected else 1.0
        sphericity = pingouin.sphericity(table) if corrected else None
    df1 = values.shape[1] - 1
    df2 = df1 * (len(values) - 1)
    f, epsilon = float(found["F"]), float(found.get("eps", 1.0))
    low, high = _bootstrap(values, _generalised_eta_squared, data)
    return {
        "scale": "log",
        "F": f,
        "df1": df1,
        "df2": df2,
        "p": float(stats.f.sf(f, df1, df2)),
        "epsilon_gg": epsilon,
        "p_gg": float(stats.f.sf(f, df1 * epsilon, df2 * epsilon)),
        "epsilon_hf": epsilon_hf,
        "p_hf": float(stats.f.sf(f, df1 * epsilon_hf, df2 * epsilon_hf)),
        "eta2_generalised": float(found["ng2"]),
        "eta2_generalised_ci": [low, high],
        "mauchly_w": float(sphericity.W) if sphericity else None,
        "mauchly_p": float(sphericity.pval) if sphericity else None,
        **_shapiro(values),
        **_dropped(data, table),
    }


def _shapiro(values: NDArray[np.float64]) -> dict[str, float]:
    from scipy import stats  # noqa: PLC0415

    residuals = additive_residuals(values).ravel()
    # SciPy's p is not accurate above 5000 values.
    if residuals.size > 5000:  # noqa: PLR2004
        return {}
    found = stats.shapiro(residuals)
    return {"shapiro_w": float(found.statistic), "shapiro_p": float(found.pvalue)}


def _generalised_eta_squared(*columns: NDArray[np.float64], axis: int = -1) -> Any:
    """Return generalised eta squared, participants along ``axis``; one array per amplitude."""
    values = np.stack(columns, axis=0)
    n = values.shape[axis]
    grand = values.mean(axis=(0, axis), keepdims=True)
    effect = n * ((values.mean(axis=axis, keepdims=True) - grand) ** 2).sum(axis=(0, axis))
    total = ((values - grand) ** 2).sum(axis=(0, axis))
    # Generalised: effect over effect + people + error, and these three make the total.
    return effect / total


def _bootstrap(
    values: NDArray[np.float64], statistic: Callable[..., Any], data: Prepared
) -> tuple[float | None, float | None]:
    """Return a percentile interval over participants; None where it is not defined."""
    from scipy import stats  # noqa: PLC0415

    if np.ptp(values) == 0:
        return None, None
    found = stats.bootstrap(
        tuple(values.T),
        statistic,
        paired=True,
        vectorized=True,
        method="percentile",
        n_resamples=data.choices.bootstrap_resamples,
        batch=max(1, 2_000_000 // values.size),
        confidence_level=data.choices.confidence,
        rng=np.random.default_rng(data.choices.bootstrap_seed),
    ).confidence_interval
    return float(found.low), float(found.high)


def friedman(data: Prepared) -> Result:
    """Friedman's rank test and Kendall's W, on mean estimates: zeros and scales do not matter."""
    from scipy import stats  # noqa: PLC0415

    table, why = _rank_table(data)
    if why:
        return reason(why)
    values = table.to_numpy(float)
    found = stats.friedmanchisquare(*values.T)
    n, k = values.shape
    return {
        "chi2": float(found.statistic),
        "df": k - 1,
        "p": float(found.pvalue),
        "kendalls_w": float(found.statistic) / (n * (k - 1)),
        **_dropped(data, table),
    }


def page_trend(data: Prepared) -> Result:
    """Page's test of an ordered trend: estimates grow with amplitude. One-sided by nature."""
    from scipy import stats  # noqa: PLC0415

    table, why = _rank_table(data)
    if why:
        return reason(why)
    values = table.to_numpy(float)
    found = stats.page_trend_test(values)
    return {
        "L": float(found.statistic),
        "p": float(found.pvalue),
        "method": str(found.method),
        **_dropped(data, table),
    }


def linear_trend(data: Prepared) -> Result:
    """Linear contrast of mean logarithms at the amplitudes' true distances, one a participant."""
    table, why = _log_table(data)
    if why:
        return reason(why)
    amplitudes = table.columns.to_numpy(float)
    weights = amplitudes - amplitudes.mean()
    slopes = table.to_numpy(float) @ (weights / (weights**2).sum())
    found = mean_with_interval(slopes, data.choices.confidence)
    return {"unit": "natural logarithm per um_pp", **found, **_dropped(data, table)}


def mean_with_interval(values: NDArray[np.float64], confidence: float) -> Result:
    """Return mean, Student's interval and the test against 0 of one value per participant."""
    from scipy import stats  # noqa: PLC0415

    values = values[np.isfinite(values)]
    if len(values) < FEWEST:
        return reason(f"{len(values)} participants; {FEWEST} or more are needed")
    if np.ptp(values) <= TINY * max(float(np.abs(values).max()), 1.0):
        return reason("all participants have the same value: no spread to judge it by")
    found = stats.ttest_1samp(values, 0.0)
    interval = found.confidence_interval(confidence)
    return {
        "mean": float(values.mean()),
        "ci": [float(interval.low), float(interval.high)],
        "sd": float(values.std(ddof=1)),
        "t": float(found.statistic),
        "df": len(values) - 1,
        "p": float(found.pvalue),
    }


def pairwise(data: Prepared) -> list[Result] | Result:
    """Compare every two amplitudes: paired t on logarithms and Wilcoxon on estimates, Holm's p.

    Effect size: d_z, the mean difference over the standard deviation of the differences, with
    pingouin's interval; and the ratio of geometric means.
    """
    import pingouin  # noqa: PLC0415
    from statsmodels.stats.multitest import multipletests  # noqa: PLC0415

    table, why = _log_table(data)
    if why:
        return reason(why)
    ranks = data.whole
    rows: list[Result] = []
    for low, high in combinations(table.columns, 2):
        difference = (table[high] - table[low]).to_numpy(float)
        row: Result = {"from_um_pp": float(low), "to_um_pp": float(high), "n": len(difference)}
        found = mean_with_interval(difference, data.choices.confidence)
        if "reason" in found:
            row |= found | {"p": float("nan")}
        else:
            d_z = found["mean"] / found["sd"]
            ci = pingouin.compute_esci(
                stat=d_z,
                nx=len(difference),
                ny=len(difference),
                paired=True,
                eftype="cohen",
                confidence=data.choices.confidence,
                decimals=12,
            )
            row |= {
                "ratio": float(np.exp(found["mean"])),
                "ratio_ci": [float(np.exp(bound)) for bound in found["ci"]],
                "t": found["t"],
                "df": found["df"],
                "p": found["p"],
                "d_z": d_z,
                "d_z_ci": [float(ci[0]), float(ci[1])],
            }
        steps = (ranks[high] - ranks[low]).to_numpy(float)
        row["p_wilcoxon"] = signed_rank_p(steps)
        row["up"], row["down"] = int((steps > 0).sum()), int((steps < 0).sum())
        rows.append(row)
    for name in ("p", "p_wilcoxon"):
        raw = np.array([row[name] for row in rows])
        usable = np.isfinite(raw)
        adjusted = np.full(len(raw), np.nan)
        if usable.any():
            adjusted[usable] = multipletests(raw[usable], method="holm")[1]
        for row, value in zip(rows, adjusted, strict=True):
            row[f"{name}_holm"] = float(value)
    return rows


def signed_rank_p(differences: NDArray[np.float64]) -> float:
    """Return the two-sided p of Wilcoxon's signed-rank test, exact up to a dozen ties and all.

    SciPy's own choice for ties in small samples permutes in a Python loop, a second a pair; the
    same permutation test on ranks taken once is a thousand times faster.
    """
    from scipy import stats  # noqa: PLC0415

    steps = differences[np.isfinite(differences) & (differences != 0)]
    if not len(steps):
        return float("nan")
    sizes = np.abs(steps)
    tied = len(np.unique(sizes)) < len(sizes)
    if tied and len(steps) <= EXACT_WITH_TIES:
        found = stats.permutation_test(
            (np.sign(steps) * stats.rankdata(sizes),),
            lambda signed, axis: signed.sum(axis=axis),
            permutation_type="samples",
            vectorized=True,
            n_resamples=np.inf,
        )
        return float(found.pvalue)
    method = "asymptotic" if tied or len(steps) > EXACT_AT_MOST else "exact"
    return float(stats.wilcoxon(steps, method=method).pvalue)


def mixed_model(data: Prepared) -> Result:  # noqa: PLR0911 - each return is a sentence why not
    """Linear mixed model of log estimate on log amplitude, random intercepts and slopes (REML).

    Fitted by statsmodels on trials above 0 µm. The interval of the slope is Student's with n - 1
    degrees of freedom: statsmodels' own is the normal's, too short for a dozen people. Variances
    are given without errors: those of statsmodels are not usable.
    """
    import statsmodels.formula.api as smf  # noqa: PLC0415
    from scipy import stats  # noqa: PLC0415

    if data.refused:
        return reason(data.zero_sentence)
    trials = data.trials[(data.trials["amplitude_um_pp"] > 0) & data.trials["log"].notna()]
    people = trials[KEY].astype(str)
    n = people.nunique()
    if n < FEWEST or trials["amplitude_um_pp"].nunique() < 2:  # noqa: PLR2004
        return reason("three participants and two amplitudes above 0 are needed")
    if n > MIXED_MODEL_AT_MOST:
        return reason(
            f"{n} participants: fitted up to {MIXED_MODEL_AT_MOST}; with more, the t interval of "
            "participants' exponents (power_law) is the same estimate"
        )
    frame = pd.DataFrame(
        {"ly": trials["log"], "lx": np.log(trials["amplitude_um_pp"]), "who": people}
    )
    if len(frame) <= 2 * n:
        return reason("no more than two estimates above 0 µm a participant: no residual is left")
    left = frame["ly"] - frame.groupby("who")["ly"].transform("mean")
    if np.ptp(left) <= TINY:
        return reason("every participant's estimates are all the same")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            fit = smf.mixedlm("ly ~ lx", frame, groups="who", re_formula="~lx").fit(reml=True)
        except (np.linalg.LinAlgError, ValueError) as error:
            return reason(f"the model could not be fitted ({error})")
        errors = fit.bse_fe
    if not np.isfinite(errors["lx"]):
        return reason("the model could not be fitted (no standard error)")
    slope, se = float(fit.fe_params["lx"]), float(errors["lx"])
    half = float(stats.t.ppf((1 + data.choices.confidence) / 2, n - 1)) * se
    return {
        "intercept": float(fit.fe_params["Intercept"]),
        "exponent": slope,
        "se": se,
        "ci": [slope - half, slope + half],
        "sd_intercept": float(np.sqrt(fit.cov_re.iloc[0, 0])),
        "sd_exponent": float(np.sqrt(max(fit.cov_re.iloc[1, 1], 0.0))),
        "sd_residual": float(np.sqrt(fit.scale)),
        "log_likelihood_reml": float(fit.llf),
        "converged": bool(fit.converged),
        "warnings": sorted({str(w.message).splitlines()[0] for w in caught}),
        "n": n,
        "trials": len(frame),
    }


def _long(table: pd.DataFrame) -> pd.DataFrame:
    n, k = table.shape
    return pd.DataFrame(
        {
            "who": np.repeat(np.arange(n), k),
            "amplitude": np.tile(table.columns.to_numpy(float), n),
            "value": table.to_numpy(float).ravel(),
        }
    )


def _mute_known(control: Any) -> None:
    """Mute pingouin's one warning on pandas 3 (dropna in place); no other."""
    control.filterwarnings("ignore", category=pd.errors.Pandas4Warning)


#: Name in inference.json: the test.
TESTS: dict[str, Callable[[Prepared], Any]] = {
    "rm_anova": rm_anova,
    "friedman": friedman,
    "page_trend": page_trend,
    "linear_trend": linear_trend,
    "pairwise": pairwise,
    "mixed_model": mixed_model,
}
