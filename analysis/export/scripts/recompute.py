"""Recompute the numbers of a Slipscale report from the files in this folder.

Run it here: python recompute.py. It needs pandas, SciPy and statsmodels, nothing of Slipscale. It
reads estimates.csv, answers.csv, quality.csv and settings.csv, computes every number anew and
prints it beside the one of numbers.csv. Exit status 1: a number differs.
"""

import sys
import warnings
from itertools import combinations, permutations
from math import ceil, exp, log, nan, sqrt
from pathlib import Path

import numpy as np
import pandas as pd
import statsmodels.api as sm
import statsmodels.formula.api as smf
from scipy import integrate, optimize, stats

#: Numbers agree within this, relative; those of fits that are iterated within the second.
CLOSE, CLOSE_FITS = 1e-5, 1e-2
FITTED = (
    "mixed_model.",
    "reliability.",
    "growth.",
    "difference.psychometric.",
    "difference.weber.",
    "difference.signal_detection.by_",
    "difference.signal_detection.all_",
)


def read(folder, name):
    """Return a table, identifiers as text; None where there is none."""
    path = folder / name
    words = {"participant_id": str, "session": str, "run": str, "flags": str}
    return (
        pd.read_csv(path, dtype=words, keep_default_na=False, na_values=[""])
        if path.exists()
        else None
    )


def mean_test(values, confidence):
    """Return mean, Student's interval, standard deviation and the test against 0."""
    values = np.asarray(values, float)
    values = values[np.isfinite(values)]
    if len(values) < 3 or np.ptp(values) <= 1e-12 * max(np.abs(values).max(), 1):
        return {}
    found = stats.ttest_1samp(values, 0)
    low, high = found.confidence_interval(confidence)
    return {
        "mean": values.mean(),
        "ci.0": low,
        "ci.1": high,
        "sd": values.std(ddof=1),
        "t": found.statistic,
        "df": len(values) - 1,
        "p": found.pvalue,
    }


def holm(ps):
    """Return Holm's corrected p; those that are not defined do not count."""
    ps = np.asarray(ps, float)
    known = np.flatnonzero(np.isfinite(ps))
    order = known[np.argsort(ps[known], kind="stable")]
    out, largest = np.full(len(ps), nan), 0.0
    for place, index in enumerate(order):
        largest = max(largest, min(1.0, (len(known) - place) * ps[index]))
        out[index] = largest
    return out


def descriptives(cells, logs, confidence, ddof):
    """Return Table III and all descriptive statistics, level by level."""
    out = {}
    known = logs.notna().all()
    within = [c for c in logs if known[c]]
    if len(within) < 2:
        within = [c for c in logs if logs[c].notna().any()]
    whole = logs[within].dropna()
    n, k = whole.shape
    half = {}
    if n >= 3 and k >= 2:
        shifted = whole.sub(whole.mean(axis=1), axis=0) + whole.to_numpy().mean()
        se = shifted.std(ddof=1) * sqrt(k / (k - 1)) / sqrt(n)
        half = (se * stats.t.ppf((1 + confidence) / 2, n - 1)).to_dict()
    for i, level in enumerate(cells):
        x, y = cells[level].dropna(), logs[level].dropna()
        deviation = (x - x.mean()).abs().max()
        out |= {
            f"table3.{i}.n": len(x),
            f"table3.{i}.mean": x.mean(),
            f"table3.{i}.maximum_deviation": deviation,
            f"table3.{i}.standard_deviation": x.std(ddof=ddof),
        }
        d = f"descriptives.{i}."
        out |= {
            d + "n": len(x),
            d + "mean": x.mean(),
            d + "maximum_deviation": deviation,
            d + "sd_sample": x.std(ddof=1),
            d + "sd_population": x.std(ddof=0),
            d + "median": x.median(),
            d + "geometric_n": len(y),
            d + "geometric_mean": exp(y.mean()) if len(y) else nan,
        }
        for values, names, back in (
            (x, ("mean_low", "mean_high"), float),
            (y, ("geometric_low", "geometric_high"), exp),
        ):
            if len(values) >= 3 and values.std(ddof=1) > 0:
                h = (
                    stats.t.ppf((1 + confidence) / 2, len(values) - 1)
                    * values.std(ddof=1)
                    / sqrt(len(values))
                )
                out |= {
                    d + names[0]: back(values.mean() - h),
                    d + names[1]: back(values.mean() + h),
                }
        if level in half:
            out |= {
                d + "within_low": exp(y.mean() - half[level]),
                d + "within_high": exp(y.mean() + half[level]),
            }
    return out


def eta_squared(values, confidence):
    """Return generalised eta squared and its jackknife interval on Fisher's z."""

    def ratio(v):
        means = v.mean(axis=0)
        return len(v) * ((means - means.mean()) ** 2).sum() / ((v - v.mean()) ** 2).sum()

    n = len(values)
    whole = ratio(values)
    each = np.array([ratio(np.delete(values, i, axis=0)) for i in range(n)])
    pseudo = n * np.arctanh(sqrt(whole)) - (n - 1) * np.arctanh(np.sqrt(each))
    half = stats.t.ppf((1 + confidence) / 2, n - 1) * pseudo.std(ddof=1) / sqrt(n)
    low, high = (np.tanh(max(pseudo.mean() + s * half, 0)) ** 2 for s in (-1, 1))
    return {"eta2_generalised": whole, "eta2_generalised_ci.0": low, "eta2_generalised_ci.1": high}


def mauchly(covariance, df):
    """Return Mauchly's W of the covariance of orthonormal contrasts, and its p."""
    d = len(covariance)
    w = np.linalg.det(covariance) / (np.trace(covariance) / d) ** d
    rho = 1 - (2 * d**2 + d + 2) / (6 * d * df)
    w2 = (
        (d + 2)
        * (d - 1)
        * (d - 2)
        * (2 * d**3 + 6 * d**2 + 3 * (d + 1) + 2)
        / (288 * (df * d * rho) ** 2)
    )
    z, f = -df * rho * log(w), d * (d + 1) / 2 - 1
    p1, p2 = stats.chi2.sf(z, f), stats.chi2.sf(z, f + 4)
    return w, p1 + w2 * (p2 - p1)


def rm_anova(logs, confidence):
    """Return the repeated-measures analysis of variance of mean logarithms."""
    values = logs.loc[:, logs.notna().any()].dropna().to_numpy(float)
    n, k = values.shape
    if n < 3 or k < 2:
        return {}
    centred = values - values.mean(axis=1, keepdims=True)
    residuals = centred - centred.mean(axis=0)
    df1, df2 = k - 1, (k - 1) * (n - 1)
    f = n * ((values.mean(axis=0) - values.mean()) ** 2).sum() / df1 / ((residuals**2).sum() / df2)
    contrasts = np.linalg.qr(np.column_stack([np.ones(k), np.eye(k)[:, 1:]]))[0][:, 1:]
    covariance = np.atleast_2d(np.cov(values @ contrasts, rowvar=False))
    gg = np.trace(covariance) ** 2 / (df1 * np.trace(covariance @ covariance))
    hf = min((n * df1 * gg - 2) / (df1 * (n - 1 - df1 * gg)), 1.0) if k > 2 else 1.0
    out = {
        "F": f,
        "df1": df1,
        "df2": df2,
        "p": stats.f.sf(f, df1, df2),
        "epsilon_gg": gg,
        "p_gg": stats.f.sf(f, df1 * gg, df2 * gg),
        "epsilon_hf": hf,
        "p_hf": stats.f.sf(f, df1 * hf, df2 * hf),
        "n": n,
        "n_incomplete": len(logs) - n,
    }
    out |= eta_squared(values, confidence)
    if k > 2 and n >= k:
        out["mauchly_w"], out["mauchly_p"] = mauchly(covariance, n - 1)
    out["shapiro_w"], out["shapiro_p"] = stats.shapiro((residuals).ravel())
    return {f"rm_anova.{name}": value for name, value in out.items()}


def friedman(cells):
    """Return Friedman's test of participants with a mean at every level."""
    values = cells.dropna().to_numpy(float)
    n, k = values.shape
    if n < 3 or k < 3:
        return {}
    chi2, p = stats.friedmanchisquare(*values.T)
    return {
        "chi2": chi2,
        "df": k - 1,
        "p": p,
        "kendalls_w": chi2 / (n * (k - 1)),
        "n": n,
        "n_incomplete": len(cells) - n,
    }


def page_trend(cells, method):
    """Return Page's L and its one-sided p, exact by convolution or by the normal's."""
    values = cells.dropna().to_numpy(float)
    n, k = values.shape
    if n < 3 or k < 3:
        return {}
    ell = (stats.rankdata(values, axis=1) * np.arange(1, k + 1)).sum()
    if method == "exact":
        one = np.bincount(
            [sum(i * r for i, r in enumerate(order, 1)) for order in permutations(range(1, k + 1))]
        )
        total = np.array([1.0])
        for _ in range(n):
            total = np.convolve(total, one / one.sum())
        p = total[int(ell) :].sum()
    else:
        mean, variance = n * k * (k + 1) ** 2 / 4, n * (k**3 - k) ** 2 / (144 * (k - 1))
        p = stats.norm.sf((ell - mean) / sqrt(variance))
    return {
        "page_trend.L": ell,
        "page_trend.p": p,
        "page_trend.n": n,
        "page_trend.n_incomplete": len(cells) - n,
    }


def wilcoxon(steps):
    """Return the two-sided p of Wilcoxon's signed-rank test."""
    steps = np.asarray(steps, float)
    steps = steps[steps != 0]
    if not len(steps):
        return nan
    ranks = stats.rankdata(np.abs(steps))
    tied = len(np.unique(ranks)) < len(ranks)
    if (tied and len(steps) <= 13) or (not tied and len(steps) <= 50):
        # Every pattern of signs is as likely as another: sums of doubled ranks, by convolution.
        counts = np.array([1.0])
        for rank in (2 * ranks).round().astype(int):
            counts = np.convolve(counts, np.concatenate([[0.5], np.zeros(rank - 1), [0.5]]))
        up = round(2 * ranks[steps > 0].sum())
        return min(1.0, 2 * min(counts[: up + 1].sum(), counts[up:].sum()))
    return stats.wilcoxon(steps, method="asymptotic").pvalue


def noncentrality(t, df, p):
    """Return the non-centrality at which t has the cumulative probability p."""
    # Over the distribution of the standard deviation's estimate, y; the rule of 200 points.
    nodes, weights = np.polynomial.legendre.leggauss(200)
    low, high = stats.chi.ppf([1e-14, 1 - 1e-14], df) / sqrt(df)
    y = low + (high - low) * (nodes + 1) / 2
    density = stats.chi.pdf(y * sqrt(df), df) * sqrt(df) * weights * (high - low) / 2

    def beyond(shift):
        return (stats.norm.cdf(t * y - shift) * density).sum() - p

    width = 10 + 3 * abs(t)
    return optimize.brentq(beyond, t - width, t + width, xtol=1e-12)


def bayes_factor(t, n, scale=0.707):
    """Return Jeffreys, Zellner and Siow's factor for a difference over none."""
    df = n - 1

    def of(u):
        g = exp(u)
        a = 1 + n * g * scale**2
        return exp(
            -log(a) / 2
            - n / 2 * log(1 + t**2 / (a * df))
            + n / 2 * log(1 + t**2 / df)
            - (u + log(2 * np.pi) + 1 / g) / 2
        )

    peak = max(np.linspace(-30, 30, 601), key=of)
    return sum(
        integrate.quad(of, *part, limit=500, epsrel=1e-10)[0]
        for part in ((peak - 30, peak), (peak, peak + 60))
    )


def pairwise(cells, logs, confidence, bound):
    """Return every pair of levels: paired t of logarithms, equality, Wilcoxon's test."""
    rows = []
    for low, high in combinations(cells, 2):
        d = (logs[high] - logs[low]).dropna().to_numpy()
        s = (cells[high] - cells[low]).dropna().to_numpy()
        row = {
            "n": len(s),
            "n_logs": len(d),
            "up": (s > 0).sum(),
            "down": (s < 0).sum(),
            "p_wilcoxon": wilcoxon(s) if len(s) >= 3 else nan,
        }
        found = mean_test(d, confidence)
        if found:
            n, t, df = len(d), found["t"], found["df"]
            se = found["sd"] / sqrt(n)
            half = stats.t.ppf(confidence, df) * se
            row |= {
                "ratio": exp(found["mean"]),
                "ratio_ci.0": exp(found["ci.0"]),
                "ratio_ci.1": exp(found["ci.1"]),
                "t": t,
                "df": df,
                "p": found["p"],
                "d_z": found["mean"] / found["sd"],
                "d_z_ci.0": noncentrality(t, df, (1 + confidence) / 2) / sqrt(n),
                "d_z_ci.1": noncentrality(t, df, (1 - confidence) / 2) / sqrt(n),
                "equivalence_ratio": bound,
                "equivalence_ci.0": exp(found["mean"] - half),
                "equivalence_ci.1": exp(found["mean"] + half),
                "equivalence_p": stats.t.sf(
                    min(log(bound) + found["mean"], log(bound) - found["mean"]) / se, df
                ),
                "bayes_factor_10": bayes_factor(t, n),
            }
        rows.append(row)
    for name, corrected in (
        ("p", "p_holm"),
        ("p_wilcoxon", "p_wilcoxon_holm"),
        ("equivalence_p", "equivalence_p_holm"),
    ):
        for row, p in zip(rows, holm([row.get(name, nan) for row in rows]), strict=True):
            row[corrected] = p
    return {
        f"pairwise.{i}.{name}": value for i, row in enumerate(rows) for name, value in row.items()
    }


def slopes(logs):
    """Return each participant's exponent, by least squares of logarithms on logarithms."""
    above = logs.loc[:, [c for c in logs if c > 0]]
    x = np.log(above.columns.to_numpy(float))
    out = {}
    for who, row in above.iterrows():
        here = row.notna().to_numpy()
        out[who] = np.polyfit(x[here], row.to_numpy(float)[here], 1)[0] if here.sum() > 1 else nan
    return pd.Series(out, dtype=float)


def power_law(logs, confidence):
    """Return the mean of participants' exponents."""
    found = mean_test(slopes(logs), confidence)
    if not found:
        return {}
    points = logs.loc[:, [c for c in logs if c > 0]].notna().sum(axis=1).max()
    return {
        "exponent": found["mean"],
        "ci.0": found["ci.0"],
        "ci.1": found["ci.1"],
        "sd": found["sd"],
        "n": found["df"] + 1,
        "points": points,
    }


def order(trials, confidence):
    """Return slopes on the trial's position and on the level before, by a jackknife over people."""
    parts = [c for c in ("who", "session", "run") if c in trials and trials[c].notna().all()]
    frame = trials.assign(
        position=trials.groupby("who").cumcount() + 1, before=trials.groupby(parts)["level"].shift()
    )
    frame = frame[frame["before"].notna() & frame["log"].notna()]
    columns = pd.get_dummies(frame["level"], dtype=float).iloc[:, 1:]
    columns = columns.assign(position=frame["position"], before=frame["before"], log=frame["log"])
    within = columns - columns.groupby(frame["who"]).transform("mean")

    def fit(part):
        return np.linalg.lstsq(part.iloc[:, :-1].to_numpy(), part["log"].to_numpy(), rcond=1e-10)[
            0
        ][-2:]

    people = frame["who"].unique()
    if len(people) < 3:
        return {}
    whole = fit(within)
    each = np.array([fit(within[frame["who"] != person]) for person in people])
    n, out = len(people), {}
    errors = np.sqrt((n - 1) / n * ((each - whole) ** 2).sum(axis=0))
    for name, b, se in zip(("position", "carry_over"), whole, errors, strict=True):
        half = stats.t.ppf((1 + confidence) / 2, n - 1) * se
        found = {
            "mean": b,
            "ci.0": b - half,
            "ci.1": b + half,
            "sd": se * sqrt(n),
            "t": b / se,
            "df": n - 1,
            "p": 2 * stats.t.sf(abs(b / se), n - 1),
        }
        out |= {f"order.{name}.{key}": value for key, value in found.items()}
    return out


def reliability(trials, confidence):
    """Return intraclass correlations over repetitions, by components of variance."""
    usable = trials[trials["log"].notna()]
    counts = usable.groupby(["who", "level"]).size().unstack(fill_value=0)
    if not (counts > 1).any(axis=None) or len(counts) < 3:
        return {}
    n, k = counts.shape
    there = counts.to_numpy()[counts.to_numpy() > 0]
    balanced = counts.to_numpy().min() == counts.to_numpy().max()
    r = int(there[0]) if balanced else len(there) / (1 / there).sum()
    rows = usable.sort_values(["who", "level"], kind="stable")
    if balanced:
        block = rows["log"].to_numpy().reshape(n, k, r)
    else:
        block = np.array([group[["level", "log"]].to_numpy() for _, group in rows.groupby("who")],
                         dtype=object)  # fmt: skip

    def restricted(logs, people):
        """Return -2 log restricted likelihood and the parts of a model of all single estimates."""
        a, b = np.exp(logs)
        known = np.unique(np.concatenate([p[:, 0] for p in people]))
        left = sum(len(p) for p in people) - len(known)
        xx, xy, yy, det = 0, 0, 0, 0
        for p in people:
            same = p[:, :1] == p[:, 0]
            v = np.eye(len(p)) + a + b * same
            x, y = (p[:, :1] == known) * 1.0, p[:, 1].astype(float)
            solved = np.linalg.solve(v, np.column_stack([x, y]))
            xx, xy, yy = xx + x.T @ solved[:, :-1], xy + x.T @ solved[:, -1], yy + y @ solved[:, -1]
            det += np.linalg.slogdet(v)[1]
        scale = (yy - xy @ np.linalg.solve(xx, xy)) / left
        return det + np.linalg.slogdet(xx)[1] + left * np.log(scale), scale

    def by_reml(people):
        found = min(
            (
                optimize.minimize(
                    lambda logs: restricted(logs, people)[0], start, method="Nelder-Mead",
                    options={"xatol": 1e-7, "fatol": 1e-10},
                )
                for start in ([0, -0.7], [-3, -3])
            ),
            key=lambda each: each.fun,
        )  # fmt: skip
        scale = restricted(found.x, people)[1]
        return (*np.exp(found.x) * scale, scale)

    def components(b):
        if not balanced:
            return by_reml([np.asarray(p, float) for p in b])
        m = len(b)
        cells = b.mean(axis=2)
        centred = cells - cells.mean(axis=0)
        own = centred.mean(axis=1)
        between = k * r * (own**2).sum() / (m - 1)
        error = ((b - cells[..., None]) ** 2).sum() / (m * k * (r - 1))
        mixed = r * ((centred - own[:, None]) ** 2).sum() / ((m - 1) * (k - 1)) if k > 1 else error
        return (between - mixed) / (k * r), (mixed - error) / r, error

    def coefficient(b, of):
        people, mixed, error = components(b)
        return (people + mixed) / (people + mixed + error / of)

    own, mixed, error = components(block)
    out = {
        "variance_participants": max(own, 0),
        "variance_interaction": max(mixed, 0),
        "variance_repetitions": error,
        "n": n,
        "amplitudes": k,
        "repetitions": r,
        "trials": len(usable),
    }
    for name, of in (("single", 1), ("mean", r)):
        out[name + ".value"] = coefficient(block, of)
        each = [coefficient(np.delete(block, i, axis=0), of) for i in range(n)]
        pseudo = n * np.arctanh(out[name + ".value"]) - (n - 1) * np.arctanh(each)
        half = stats.t.ppf((1 + confidence) / 2, n - 1) * pseudo.std(ddof=1) / sqrt(n)
        out |= {
            name + ".ci.0": np.tanh(pseudo.mean() - half),
            name + ".ci.1": np.tanh(pseudo.mean() + half),
        }
    return {f"reliability.{key}": value for key, value in out.items()}


def linear_trend(logs, confidence):
    """Return the linear contrast of mean logarithms."""
    whole = logs.loc[:, logs.notna().any()].dropna()
    if len(whole) < 3 or whole.shape[1] < 2:
        return {}
    x = whole.columns.to_numpy(float) - np.mean(whole.columns)
    found = mean_test(whole.to_numpy() @ x / (x**2).sum(), confidence)
    found |= {"n": len(whole), "n_incomplete": len(logs) - len(whole)} if found else {}
    return {f"linear_trend.{name}": value for name, value in found.items()}


def mixed_model(trials, confidence):
    """Return the linear mixed model of log estimate on log level."""
    above = trials[(trials["level"] > 0) & trials["log"].notna()]
    lx = np.log(above["level"])
    frame = pd.DataFrame({"ly": above["log"], "lx": lx - lx.mean(), "who": above["who"]})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = smf.mixedlm("ly ~ lx", frame, groups="who", re_formula="~lx")
        best = max(
            (model.fit(reml=True, method=m) for m in ("bfgs", "lbfgs", "powell")),
            key=lambda f: f.llf,
        )
        se = best.bse_fe["lx"]
    n, slope, centre = frame["who"].nunique(), best.fe_params["lx"], lx.mean()
    half = stats.t.ppf((1 + confidence) / 2, n - 1) * se
    at_one = np.array([1.0, -centre])
    spread = best.cov_re.to_numpy()
    return {
        "mixed_model.intercept": best.fe_params["Intercept"] - centre * slope,
        "mixed_model.exponent": slope,
        "mixed_model.se": se,
        "mixed_model.ci.0": slope - half,
        "mixed_model.ci.1": slope + half,
        "mixed_model.sd_intercept": sqrt(max(at_one @ spread @ at_one, 0)),
        "mixed_model.sd_exponent": sqrt(max(spread[1, 1], 0)),
        "mixed_model.sd_residual": sqrt(best.scale),
        "mixed_model.log_likelihood_reml": best.llf,
        "mixed_model.n": n,
        "mixed_model.trials": len(frame),
    }


def growth_functions(x):
    """Return name -> (logarithm, lower and upper limits, reported parameters)."""
    least, most = x.min(), x.max()
    below = least * (1 - 1e-6)
    lx = np.log(x)
    return {
        "power": (lambda q: q[0] * lx, [(-20, 20)], {"exponent": lambda q: q[0]}),
        "threshold": (
            lambda q: q[0] * np.log(x - q[1]),
            [(-20, 20), (-10 * most, below)],
            {"exponent": lambda q: q[0], "threshold": lambda q: q[1]},
        ),
        "linear": (lambda q: np.log(x + q[0]), [(-below, 1000 * most)], {"offset": lambda q: q[0]}),
        "fechner": (
            lambda q: np.log(lx - q[0]),
            [(lx.min() - 50, lx.min() - 1e-6)],
            {"threshold": lambda q: exp(q[0])},
        ),
        "ekman": (
            lambda q: np.logaddexp(0, q[0] * (lx - q[1])),
            [(0, 20), (lx.min() - 7, lx.max() + 7)],
            {"exponent": lambda q: q[0], "doubling_stimulus": lambda q: exp(q[1])},
        ),
        "naka_rushton": (
            lambda q: -np.logaddexp(0, q[0] * (q[1] - lx)),
            [(0, 20), (lx.min() - 7, lx.max() + 7)],
            {"exponent": lambda q: q[0], "half_saturation": lambda q: exp(q[1])},
        ),
    }


def growth(logs, names):
    """Return growth functions fitted to participants' mean logarithms, each with an own factor."""
    usable = logs.loc[:, [c for c in logs if c > 0]]
    usable = usable[usable.notna().sum(axis=1) >= 2]
    y = usable.to_numpy(float)
    here = ~np.isnan(y)
    centred = y - np.nanmean(y, axis=1, keepdims=True)
    out, scores = {}, {}
    for name, (log_f, limits, reported) in growth_functions(usable.columns.to_numpy(float)).items():
        if name not in names:
            continue

        def residuals(q, log_f=log_f):
            f = np.where(here, log_f(q), nan)
            return (centred - (f - np.nanmean(f, axis=1, keepdims=True)))[here]

        low, high = np.array(limits, float).T
        starts = [
            np.clip(v, low + 1e-9 * (high - low), high - 1e-9 * (high - low))
            for v in starting_points(name, usable.columns.to_numpy(float))
        ]
        fits = [
            optimize.least_squares(residuals, s, bounds=(low, high), x_scale="jac") for s in starts
        ]
        best = min(fits, key=lambda f: f.cost)
        points, estimated = int(here.sum()), len(limits) + len(y) + 1
        squares = max(2 * best.cost, 1e-300)
        ll = -points / 2 * (log(2 * np.pi * squares / points) + 1)
        spare = points - estimated - 1
        p = f"growth.amplitude.models.{name}."
        out |= {p + f"parameters.{key}": of(best.x) for key, of in reported.items()}
        out |= {
            p + "sd": sqrt(squares / max(spare + 2, 1)),
            p + "log_likelihood": ll,
            p + "aic": 2 * estimated - 2 * ll,
            p + "bic": estimated * log(points) - 2 * ll,
            p + "points": points,
            p + "estimated": estimated,
        }
        if spare > 0:
            scores[name] = out[p + "aicc"] = (
                2 * estimated - 2 * ll + 2 * estimated * (estimated + 1) / spare
            )
    weights = {name: exp(-(score - min(scores.values())) / 2) for name, score in scores.items()}
    for name, weight in weights.items():
        p = f"growth.amplitude.models.{name}."
        out |= {
            p + "delta_aicc": scores[name] - min(scores.values()),
            p + "weight": weight / sum(weights.values()),
        }
    return out | {"growth.amplitude.n": len(y)}


def starting_points(name, x):
    """Return where the search for a growth function's parameters begins."""
    lx = np.log(x)
    places = {
        "power": [[1.0]],
        "linear": [[0.0], [-0.5 * x.min()], [-0.9 * x.min()], [2 * x.max()]],
        "threshold": [[1.0, 0.0], [0.5, 0.5 * x.min()], [0.3, 0.95 * x.min()], [1.0, -x.max()]],
        "fechner": [[lx.min() - 0.1], [lx.min() - 2], [lx.min() - 10]],
    }
    if name in places:
        return places[name]
    return [[e, m] for e in (0.5, 2.0) for m in np.linspace(lx.min(), lx.max(), 3)]


def clustered_interval(yes, answers, confidence):
    """Return Korn and Graubard's interval of a share of answers that cluster in participants."""
    people, total = len(answers), answers.sum()
    share = yes.sum() / total
    effective = float(total)
    if people == 1 and total > 1:
        return 0.0, 1.0
    if people != total:
        independent = share * (1 - share) / total
        effective = float(people)
        if independent > 0:
            clustered = people / (people - 1) * ((yes - share * answers) ** 2).sum() / total**2
            tail = (1 - confidence) / 2
            ratio = stats.t.ppf(tail, total - 1) / stats.t.ppf(tail, people - 1)
            effective = min(total / max(clustered / independent, 1) * ratio**2, total)
    k, n, tail = share * effective, effective, (1 - confidence) / 2
    low = stats.beta.ppf(tail, k, n - k + 1) if k > 0 else 0.0
    high = stats.beta.ppf(1 - tail, k + 1, n - k) if k < n else 1.0
    return low, high


def d_prime(hits, signals, alarms, noises):
    """Return d' and c after the log-linear correction."""
    h, f = stats.norm.ppf([(hits + 0.5) / (signals + 1), (alarms + 0.5) / (noises + 1)])
    return h - f, -(h + f) / 2


def difference(rows, settings, confidence):
    """Return the counts, intervals, d' and curve of yes and no."""
    before, after = rows[settings["before"]], rows[settings["after"]]
    rows = rows.rename(columns={settings["answer"]: "yes"})
    felt, who = rows["yes"], rows["participant_id"]
    catch = before == after
    out = {}
    changes = rows[~catch]
    kinds = sorted(set(zip(before[~catch], after[~catch], strict=True)), reverse=True)

    def share(part, name):
        own = part.groupby("participant_id")["yes"].agg(["sum", "size"])
        ends = clustered_interval(
            own["sum"].to_numpy(float), own["size"].to_numpy(float), confidence
        )
        return {
            f"{name}.n": len(part),
            f"{name}.yes": part["yes"].sum(),
            f"{name}.ci.0": ends[0],
            f"{name}.ci.1": ends[1],
        }

    for i, (b, a) in enumerate(kinds):
        out |= share(rows[(before == b) & (after == a)], f"difference.steps.{i}")
    out |= {
        "difference.catch.n": catch.sum(),
        "difference.catch.yes": felt[catch].sum(),
        "difference.participants": who.nunique(),
    }
    if catch.any():
        out |= share(rows[catch], "difference.catch")
    s = "difference.signal_detection."
    if catch.any() and len(changes):
        pooled = (felt[~catch].sum(), len(changes), felt[catch].sum(), catch.sum())
        d, c = d_prime(*pooled)
        out |= {"difference.d_prime": d, s + "pooled_d_prime": d, s + "pooled_criterion": c}
        out |= dict(
            zip((s + "hits", s + "changes", s + "false_alarms", s + "catches"), pooled, strict=True)
        )
        own = []
        for person in sorted(set(who[~catch]) & set(who[catch])):
            one = who == person
            counts = (
                felt[one & ~catch].sum(),
                (one & ~catch).sum(),
                felt[one & catch].sum(),
                (one & catch).sum(),
            )
            p = f"{s}participants.{person}."
            out |= dict(
                zip(
                    (p + "hits", p + "changes", p + "false_alarms", p + "catches"),
                    counts,
                    strict=True,
                )
            )
            out[p + "d_prime"], out[p + "criterion"] = d_prime(*counts)
            own.append(out[p + "d_prime"])
        out |= {f"{s}mean_of_participants.{k}": v for k, v in mean_test(own, confidence).items()}
        per = changes.groupby(["participant_id", settings["before"], settings["after"]]).size()
        out["difference.answers_per_participant_and_step"] = per.mean()
    size = (before - after).to_numpy(float)
    base = rows[settings["weber_base"]].to_numpy(float)
    some = base > 0
    said = felt.to_numpy(float)
    out |= curve(said, size, who, confidence, "difference.psychometric.")
    fraction = np.abs(size[some]) / base[some]
    out |= curve(said[some], fraction, who[some], confidence, "difference.weber.")
    return out | sizes(felt, before, after, who, confidence)


def curve(felt, removed, who, confidence, p):
    """Return the logistic curve by generalised estimating equations, its names behind ``p``."""
    frame = pd.DataFrame({"felt": felt, "removed": removed, "who": who.to_numpy()})
    if frame["removed"].nunique() < 2 or who.nunique() < 3:
        return {}
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            model = smf.gee(
                "felt ~ removed",
                "who",
                frame,
                family=sm.families.Binomial(),
                cov_struct=sm.cov_struct.Exchangeable(),
            )
            fit = model.fit(cov_type="bias_reduced")
        except (ValueError, np.linalg.LinAlgError):
            return {}
    n = who.nunique()
    b, se, df = fit.params["removed"], fit.bse["removed"], n - 2
    if df < 1 or not np.isfinite([b, se]).all():
        return {}
    half = stats.t.ppf((1 + confidence) / 2, df) * se
    out = {
        p + "log_odds_per_unit": b,
        p + "se": se,
        p + "ci.0": b - half,
        p + "ci.1": b + half,
        p + "t": b / se,
        p + "df": df,
        p + "p": 2 * stats.t.sf(abs(b / se), df),
        p + "intercept": fit.params["Intercept"],
        p + "correlation": model.cov_struct.dep_params,
        p + "n": n,
        p + "answers": len(frame),
    }
    if b <= 0:
        return out
    a = fit.params["Intercept"]
    out[p + "half_yes"] = -a / b
    # Fieller's theorem: sizes at which the line is within t standard errors of 0.
    c, quantile = fit.cov_params().to_numpy(), half / se
    square = b**2 - quantile**2 * c[1, 1]
    if square > 0:
        middle = a * b - quantile**2 * c[0, 1]
        root = sqrt(max(middle**2 - square * (a**2 - quantile**2 * c[0, 0]), 0))
        out |= {
            p + "half_yes_ci.0": (-middle - root) / square,
            p + "half_yes_ci.1": (-middle + root) / square,
        }
    return out


def sizes(felt, before, after, who, confidence):
    """Return d' of each size of step, by a probit model with participants."""
    levels = np.concatenate([before, after])
    decimals = -ceil(np.log10(np.abs(levels).max() * 1e-9)) if np.abs(levels).max() > 0 else 0
    size = np.array([round(v, decimals) + 0.0 for v in (before - after)])
    people = who.nunique()
    if people < 3 or not (size == 0).any() or not (size != 0).any():
        return {}
    drop = stats.t.ppf((1 + confidence) / 2, people - 1) ** 2 / 2
    out = {}
    kinds = sorted(set(size[size != 0]))
    for i, kind in enumerate(kinds):
        p = f"difference.signal_detection.by_size.{i}."
        out |= {p + "steps": (size == kind).sum(), p + "yes": felt[size == kind].sum()}
        out |= {p + k: v for k, v in profile(size, kinds, i, felt, who, drop).items()}
    p = "difference.signal_detection.all_sizes."
    together = np.where(size == 0, 0.0, 1.0)
    out |= {p + "steps": (size != 0).sum(), p + "yes": felt[size != 0].sum()}
    return out | {p + k: v for k, v in profile(together, [1.0], 0, felt, who, drop).items()}


def profile(size, kinds, place, felt, who, drop, far=8.0):
    """Return one d' and its profile-likelihood interval; what has no end is left out."""
    nodes = np.linspace(-6, 6, 241)
    weights = stats.norm.logpdf(nodes) + np.log(nodes[1] - nodes[0])
    all_kinds = [0.0, *kinds]
    people = sorted(who.unique())
    counts = np.array(
        [
            [[((felt == v) & (size == k) & (who == w)).sum() for v in (1, 0)] for k in all_kinds]
            for w in people
        ]
    )

    def minus_log(theta):
        d, c, spread = np.concatenate([[0], theta[:-2]]), theta[-2], theta[-1]
        z = d[:, None] - c - spread * nodes
        terms = (
            counts[..., 0] @ stats.norm.logcdf(z) + counts[..., 1] @ stats.norm.logcdf(-z) + weights
        )
        peak = terms.max(axis=1, keepdims=True)
        return -(peak[:, 0] + np.log(np.exp(terms - peak).sum(axis=1))).sum()

    bounds = [(-far, far)] * (len(kinds) + 1) + [(0, 4)]

    def fit(start, held=None):
        # At a spread of 0 the slope is 0: a search that begins there stays there.
        start = np.append(start[:-1], max(start[-1], 0.3))
        limits = list(bounds)
        if held is not None:
            limits[place] = (held, held)
            start = np.where(np.arange(len(start)) == place, held, start)
        found = optimize.minimize(
            minus_log,
            start,
            method="L-BFGS-B",
            bounds=limits,
            options={"ftol": 1e-13, "gtol": 1e-8},
        )
        return found.fun, found.x

    least, best = fit(np.array([1.0] * len(kinds) + [0.5, 0.5]))
    ends = {end: fit(best, end) for end in (-far, far)}
    for value, there in ends.values():
        if value < least:
            least, best = value, there
    out = {}
    for name, end in (("ci.0", -far), ("ci.1", far)):
        if ends[end][0] - least > drop:
            out[name] = optimize.brentq(
                lambda v: (fit(best, v)[0] if v != best[place] else least) - least - drop,
                best[place],
                end,
                xtol=1e-5,
            )
    if min(value for value, _ in ends.values()) - least >= 1e-3:
        out["d_prime"] = best[place]
    return out


def estimates(folder, settings, names):
    """Return every number that rests on magnitude estimates."""
    trials = read(folder, "estimates.csv")
    if trials is None:
        return {}
    confidence, ddof = (
        float(settings["confidence"]),
        int(settings["standard_deviation"] == "sample"),
    )
    trials = trials.rename(columns={settings["level"]: "level", "participant_id": "who"})
    values = trials["normalised"].copy()
    if settings["zero_rule"] == "half_minimum":
        values[values <= 0] = values[values > 0].min() / 2
    trials["log"] = np.log(values.where(values > 0))

    def table(part, column):
        return part.groupby(["who", "level"])[column].mean().unstack().sort_index(axis=1)

    cells, logs = (
        table(trials, "normalised"),
        table(trials, "log").reindex(columns=table(trials, "normalised").columns),
    )
    out = descriptives(cells, logs, confidence, ddof)
    ranks = friedman(cells)
    law = power_law(logs, confidence)
    out |= {f"friedman.{k}": v for k, v in ranks.items()} | {
        f"power_law.{k}": v for k, v in law.items()
    }
    out |= rm_anova(logs, confidence) | page_trend(cells, settings.get("page_method", "exact"))
    out |= linear_trend(logs, confidence) | pairwise(
        cells, logs, confidence, float(settings["equivalence_ratio"])
    )
    for part, of in (
        ("mixed_model.", mixed_model),
        ("order.", order),
        ("reliability.", reliability),
    ):
        if any(name.startswith(part) for name in names):
            out |= of(trials, confidence)
    wanted = {name.split(".")[3] for name in names if name.startswith("growth.amplitude.models.")}
    out |= growth(logs, wanted) if wanted else {}
    out |= {f"individuals.{who}.exponent": slope for who, slope in slopes(logs).items()}
    flagged = read(folder, "quality.csv")
    flagged = set(flagged.loc[flagged["flags"].notna(), "participant_id"])
    for i, kept in enumerate((cells.index, cells.index.difference(list(flagged)))):
        c, y = cells.loc[kept], logs.loc[kept]
        p = f"robustness.{i}."
        some, of = (ranks, law) if i == 0 else (friedman(c), power_law(y, confidence))
        out |= {
            p + "n": len(c),
            p + "friedman_chi2": some.get("chi2", nan),
            p + "friedman_p": some.get("p", nan),
            p + "exponent": of.get("exponent", nan),
            p + "exponent_ci.0": of.get("ci.0", nan),
            p + "exponent_ci.1": of.get("ci.1", nan),
        }
        out |= {f"{p}means.{j}": mean for j, mean in enumerate(c.mean())}
    return out


def main(folder):
    """Print every number beside the report's; return how many differ."""
    settings = dict(pd.read_csv(folder / "settings.csv", dtype=str).itertuples(index=False))
    reported = read(folder, "numbers.csv").set_index("name")["value"]
    found = estimates(folder, settings, reported.index)
    answers = read(folder, "answers.csv")
    if answers is not None and len(answers):
        found |= difference(answers, settings, float(settings["confidence"]))
    differ, missing = [], []
    for name, value in reported.items():
        if name not in found or not np.isfinite(found[name]):
            missing.append(name)
            continue
        close = CLOSE_FITS if name.startswith(FITTED) else CLOSE
        same = abs(found[name] - value) <= close * max(abs(value), 1e-2)
        differ += [] if same else [name]
        print(
            f"{name:<60} {value:>18.10g} {float(found[name]):>18.10g}{'' if same else '   DIFFERS'}"
        )
    done = len(reported) - len(missing)
    print(f"{done} of {len(reported)} numbers recomputed, {len(differ)} differ")
    for name in missing:
        print(f"not recomputed: {name}")
    return len(differ)


if __name__ == "__main__":
    sys.exit(1 if main(Path(__file__).parent) else 0)
