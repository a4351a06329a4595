"""Recompute a Slipscale report's thresholds, scales and matches from the files in this folder.

Run it here: python recompute_tasks.py. It needs NumPy, pandas, SciPy and statsmodels, nothing of
Slipscale. It reads choices.csv, comparisons.csv, matches.csv and settings.csv, computes every
number anew and prints it beside the one of numbers.csv. Exit status 1: a number differs.
"""

import sys
import warnings
from itertools import combinations, permutations, product
from math import comb, log
from pathlib import Path

import numpy as np
import pandas as pd
import statsmodels.api as sm
from scipy import optimize, special, stats

#: Numbers agree within this, relative; those of fits and of integrals on grids within the second.
CLOSE, CLOSE_FITS = 1e-5, 2e-2
FITTED = (".function.", ".maximum_likelihood.", "weber", ".population.", "expected_exponent")
PARTS = ("thresholds.", "scales.", "matching.", "exponent_and_weber.")
LARGEST_LAPSE = 0.06


def read(folder, name):
    """Return a table, identifiers and labels as text; None where there is none."""
    path = folder / name
    words = dict.fromkeys(("participant_id", "task", "stimulus1", "stimulus2", "stimulus3"), str)
    if not path.exists():
        return None
    return pd.read_csv(path, dtype=words, keep_default_na=False, na_values=[""])


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


# Psychometric functions ---------------------------------------------------------------------------


class Function:
    """How answers depend on the level: a Weibull function of it, or of comparisons a normal one."""

    def __init__(self, method):
        """Say what is known of a method of asking."""
        self.compared = method == "comparison"
        self.guess = {"two_interval": 1 / 2, "three_interval": 1 / 3}.get(method)

    def at(self, levels):
        """Return the axis: the level, or its logarithm, far below for 0."""
        levels = np.asarray(levels, float)
        return levels if self.compared else np.log(np.where(levels > 0, levels, 1e-300))

    def share(self, away, slope):
        """Return the curve without guesses and lapses; half-way where ``away`` is 0."""
        if self.compared:
            return special.ndtr(slope * away)
        return -np.expm1(-log(2) * np.exp(np.clip(slope * away, -700, 700)))

    def proportion(self, away, slope, lapse):
        """Return the proportion of correct (or "more") answers."""
        guess = lapse if self.compared else self.guess
        return np.clip(guess + (1 - guess - lapse) * self.share(away, slope), 1e-9, 1 - 1e-9)

    @property
    def spread(self):
        """Distance from 5 to 95 % of a curve with slope 1."""
        if self.compared:
            return stats.norm.ppf(0.95) - stats.norm.ppf(0.05)
        return log(-log(0.05)) - log(-log(0.95))


def log_likelihood(p, yes, n):
    """Return the log likelihood of answers, over the last axis."""
    return (yes * np.log(p) + (n - yes) * np.log1p(-p)).sum(axis=-1)


def likeliest(curve, x, yes, n):
    """Return threshold, log slope and lapse rate by maximum likelihood; None of a jump."""
    seen = x[x > -600]
    span = np.ptp(seen)
    steps = np.diff(seen)
    closest = min(steps[steps > span / 200].min(initial=np.inf), span)
    bounds = [
        (seen.min() - span, seen.max() + span),
        (np.log(curve.spread / 20 / span), np.log(10 * curve.spread / closest)),
        (0, LARGEST_LAPSE),
    ]

    def minus(theta):
        return -log_likelihood(curve.proportion(x - theta[0], np.exp(theta[1]), theta[2]), yes, n)

    starts = product(
        seen.min() + span * np.linspace(0, 1, 7),
        np.log(curve.spread / span / np.array([2, 0.5, 0.15])),
        (0.001, 0.05),
    )
    best = sorted(starts, key=minus)[:3]
    found = [
        optimize.minimize(minus, each, bounds=bounds, options={"ftol": 1e-14, "gtol": 1e-9})
        for each in best
    ]
    best = min(found, key=lambda each: each.fun)
    again = optimize.minimize(
        minus, best.x, method="Nelder-Mead", bounds=bounds, options={"xatol": 1e-8, "fatol": 1e-12}
    )
    best = again if again.fun < best.fun else best
    steepest = [bounds[0], (bounds[1][1], bounds[1][1]), bounds[2]]
    held = min(
        optimize.minimize(minus, (at, bounds[1][1], best.x[2]), bounds=steepest).fun
        for at in np.linspace(seen.min(), seen.max(), 9)
    )
    # Answers that jump between two levels leave it open where, and how steeply.
    return None if held - best.fun < 0.05 or bounds[1][1] - best.x[1] < log(30) else best.x


def posterior(curve, x, yes, n, confidence):
    """Return medians and ends of threshold and log slope, and the mean lapse rate.

    Threshold uniform to one range of levels beyond the outermost; slope log-normal (0.6) around 2,
    of comparisons around a rise from 5 to 95 % over the levels; lapse rate uniform to 6 %.
    """
    seen = x[x > -600]
    span = np.ptp(seen)
    usual = curve.spread / span if curve.compared else 2.0
    lapses = (np.arange(12) + 0.5) / 12 * LARGEST_LAPSE
    thresholds = np.linspace(seen.min() - span, seen.max() + span, 120)
    slopes = np.log(usual) + 0.6 * np.linspace(-3.5, 3.5, 60)

    def weights(thresholds, slopes):
        away = x - thresholds[:, None, None]
        share = curve.share(away, np.exp(slopes)[:, None])
        value = np.empty((len(thresholds), len(slopes), len(lapses)))
        for i, lapse in enumerate(lapses):
            guess = lapse if curve.compared else curve.guess
            p = np.clip(guess + (1 - guess - lapse) * share, 1e-9, 1 - 1e-9)
            value[:, :, i] = log_likelihood(p, yes, n)
        value -= ((slopes[:, None] - np.log(usual)) / 0.6) ** 2 / 2
        weight = np.exp(value - value.max())
        return weight / weight.sum()

    def zoomed(values, mass, points):
        there = np.flatnonzero(mass > 1e-7 * mass.max())
        first, last = max(there[0] - 1, 0), min(there[-1] + 1, len(values) - 1)
        return np.linspace(values[first], values[last], points)

    found = weights(thresholds, slopes)
    thresholds = zoomed(thresholds, found.sum(axis=(1, 2)), 160)
    slopes = zoomed(slopes, found.sum(axis=(0, 2)), 50)
    found = weights(thresholds, slopes)

    def quantiles(values, mass):
        below = np.cumsum(mass) - mass / 2
        return np.interp([0.5, (1 - confidence) / 2, (1 + confidence) / 2], below, values)

    return (
        quantiles(thresholds, found.sum(axis=(1, 2))),
        quantiles(slopes, found.sum(axis=(0, 2))),
        found.sum(axis=(0, 1)) @ lapses,
    )


def participant(rows, method, standard, confidence):
    """Return one participant's numbers."""
    catch, main = rows[rows["catch"]], rows[~rows["catch"]]

    def right(part):
        if method != "comparison":
            return part["correct"].sum()
        more = part["level_um_pp"] - part["standard_um_pp"]
        return (part["correct"] & (more > 0)).sum() + (~part["correct"] & (more < 0)).sum()

    out = {
        "trials": len(main),
        "correct": right(main),
        "catch_trials": len(catch),
        "catch_correct": right(catch),
    }
    counts = main.groupby("level_um_pp")["correct"].agg(["sum", "count"])
    yes, n = counts["sum"].to_numpy(float), counts["count"].to_numpy(float)
    curve = Function(method)
    x = curve.at(counts.index)
    if len(x) < 2 or yes.sum() in {0, n.sum()}:
        return out
    back = float if curve.compared else np.exp
    at, slope, lapse = posterior(curve, x, yes, n, confidence)
    ours = {"threshold": back(at[0]), "slope": np.exp(slope[0]), "lapse": lapse}
    for i in (1, 2):
        ours |= {f"threshold_ci.{i - 1}": back(at[i]), f"slope_ci.{i - 1}": np.exp(slope[i])}
    fitted = {"function": ours}
    best = likeliest(curve, x, yes, n)
    if best is not None:
        fitted["maximum_likelihood"] = {
            "threshold": back(best[0]),
            "slope": np.exp(best[1]),
            "lapse": best[2],
        }
        p = curve.proportion(x - best[0], np.exp(best[1]), best[2])
        own = np.clip(yes / n, 1e-9, 1 - 1e-9)
        out["fit.deviance"] = 2 * (log_likelihood(own, yes, n) - log_likelihood(p, yes, n))
    for name, found in fitted.items():
        found |= {"trials": len(main), "levels": len(x)}
        found["guess"] = found["lapse"] if curve.compared else curve.guess
        out |= {f"{name}.{key}": value for key, value in found.items()}
    if standard is not None:
        weber = np.exp(at) / standard
        if curve.compared:
            weber = stats.norm.ppf(0.75) / np.exp(slope[[0, 2, 1]]) / standard
        out |= dict(zip(WEBER, weber, strict=True))
    return out


WEBER = ("weber_fraction.value", "weber_fraction.interval.0", "weber_fraction.interval.1")


def student(values, confidence):
    """Return a mean and the ends of Student's interval."""
    half = stats.t.ppf((1 + confidence) / 2, len(values) - 1) * stats.sem(values)
    return np.mean(values) + np.array([0, -half, half])


def thresholds(choices, confidence, names):
    """Return the numbers of every task of forced choice and constant stimuli."""
    out = {}
    for i, (_, rows) in enumerate(choices.groupby("task")):
        method = rows["method"].iloc[0]
        standards = rows["standard_um_pp"].dropna().unique()
        standard = standards[0] if len(standards) == 1 and standards[0] > 0 else None
        people = [
            participant(own, method, standard, confidence)
            for _, own in rows.groupby("participant_id")
        ]
        place = f"thresholds.{i}."
        out |= {} if standard is None else {f"{place}standard": standard}
        for j, own in enumerate(people):
            out |= {f"{place}participants.{j}.{key}": value for key, value in own.items()}
        # Who has a threshold the report says: answers that do not rise have none.
        there = [
            own
            for j, own in enumerate(people)
            if f"{place}participants.{j}.function.threshold" in names
        ]
        if len(there) >= 3:
            levels = np.array([own["function.threshold"] for own in there])
            logarithmic = method != "comparison"
            values = np.log(levels) if logarithmic else levels
            ends = student(values, confidence)
            ends = np.exp(ends) if logarithmic else ends
            sd = values.std(ddof=1) / (log(10) if logarithmic else 1)
            out |= {
                f"{place}population.threshold.value": ends[0],
                f"{place}population.threshold.interval.0": ends[1],
                f"{place}population.threshold.interval.1": ends[2],
                f"{place}population.sd": sd,
                f"{place}population.n": len(there),
                f"{place}population.left_out": len(people) - len(there),
            }
            if WEBER[0] in there[0]:
                webers = np.exp(student(np.log([own[WEBER[0]] for own in there]), confidence))
                out |= {place + key: value for key, value in zip(WEBER, webers, strict=True)}
    return out


def exponents(folder, settings):
    """Return each participant's exponent: least squares of mean log estimates on log levels."""
    trials = read(folder, "estimates.csv")
    if trials is None or not len(trials):
        return {}
    values = trials["normalised"].copy()
    if settings["zero_rule"] == "half_minimum":
        values[values <= 0] = values[values > 0].min() / 2
    trials = trials.assign(log=np.log(values.where(values > 0)), level=trials[settings["level"]])
    out = {}
    for who, rows in trials[trials["level"] > 0].groupby("participant_id"):
        means = rows.groupby("level")["log"].mean().dropna()
        if len(means) >= 2:
            out[who] = np.polyfit(np.log(means.index.to_numpy(float)), means, 1)[0]
    return out


def agreement(choices, own_exponents, found, confidence):
    """Return the exponent beside the Weber fraction of each task that has one, by Ekman's law."""
    out, place = {}, 0
    for i, (_, rows) in enumerate(choices.groupby("task")):
        webers = {
            who: found[f"thresholds.{i}.participants.{j}.{WEBER[0]}"]
            for j, who in enumerate(sorted(rows["participant_id"].unique()))
            if f"thresholds.{i}.participants.{j}.{WEBER[0]}" in found
        }
        both = [who for who in webers if who in own_exponents]
        if len(both) < 3:
            continue
        power = np.array([own_exponents[who] for who in both])
        weber = np.array([webers[who] for who in both])
        fraction = np.exp(student(np.log(weber), confidence))
        name = f"exponent_and_weber.{place}."
        out[f"{name}standard"] = found[f"thresholds.{i}.standard"]
        for key, three in (
            ("exponent", student(power, confidence)),
            ("weber_fraction", fraction),
            ("expected_exponent", np.log(1.03) / np.log1p(fraction[[0, 2, 1]])),
            ("ekman_fraction", np.expm1(student(power * np.log1p(weber), confidence))),
        ):
            keys = (f"{name}{key}.{end}" for end in ("value", "interval.0", "interval.1"))
            out |= dict(zip(keys, three, strict=True))
        for j, (one, other) in enumerate(zip(power, weber, strict=True)):
            out[f"{name}participants.{j}.exponent"] = one
            out[f"{name}participants.{j}.weber_fraction"] = other
        place += 1
    return out


# Scales -------------------------------------------------------------------------------------------


def in_order(labels):
    """Return surfaces in rising order of amplitude, textures after them by name."""

    def place(label):
        try:
            return (0, float(label), label)
        except ValueError:
            return (1, 0.0, label)

    return sorted(labels, key=place)


def pair_scale(chosen, link, confidence):
    """Return a scale of pairs: values that sum to 0, intervals by participants, its test.

    ``chosen``: (participants, surfaces, surfaces), how often the row was chosen over the column.
    """
    pooled = chosen.sum(axis=0)
    k, people = len(pooled), len(chosen)
    one, other = np.triu_indices(k, 1)
    there = (pooled + pooled.T)[one, other] > 0
    one, other = one[there], other[there]
    design = np.zeros((len(one), k))
    design[range(len(one)), one], design[range(len(one)), other] = 1, -1
    won, lost = pooled[one, other], pooled[other, one]
    n = won + lost

    def parts(free):
        """Return the values, each pair's probability, its density, and the information."""
        values = np.append(0.0, free)
        values = values - values.mean()
        linear = design @ values
        p, slope = link.cdf(linear), link.pdf(linear)
        return values, p, slope, design.T @ (design * (n * slope**2 / (p * (1 - p)))[:, None])

    def minus(free):
        """Firth's: the likelihood times the square root of the information's determinant."""
        _, p, _, information = parts(free)
        likelihood = special.xlogy(won, p) + special.xlogy(lost, 1 - p)
        return -likelihood.sum() - np.linalg.slogdet(information[1:, 1:])[1] / 2

    found = optimize.minimize(minus, np.zeros(k - 1), method="BFGS", options={"gtol": 1e-8})
    values, p, slope, information = parts(found.x)
    covariance = np.linalg.pinv(information)
    quantile = stats.norm.ppf((1 + confidence) / 2)
    if people >= 3 and np.ptp(chosen, axis=0).any():
        wins, trials = chosen[:, one, other], (chosen + chosen.transpose(0, 2, 1))[:, one, other]
        scores = ((wins - trials * p) * slope / (p * (1 - p))) @ design
        covariance = covariance @ (scores.T @ scores * people / (people - 1)) @ covariance
        quantile = stats.t.ppf((1 + confidence) / 2, people - 1)
    half = quantile * np.sqrt(np.maximum(np.diag(covariance), 0))
    out = {"answers": pooled.sum(), "participants": people}
    for i, value in enumerate(values):
        out |= {f"values.{i}": value}
        out |= {f"intervals.{i}.0": value - half[i], f"intervals.{i}.1": value + half[i]}
    df = len(one) - (k - 1)
    if df >= 1:
        own = won / n
        gained = special.xlogy(won, own / p) + special.xlogy(lost, (1 - own) / (1 - p))
        deviance = 2 * gained.sum()
        out |= {"fit.deviance": deviance, "fit.df": df, "fit.p": stats.chi2.sf(deviance, df)}
    return out


def transitivity(chosen):
    """Return how many triads have an order to break, and how many break it, weakly to strongly."""
    pooled = chosen.sum(axis=0)
    n = pooled + pooled.T
    share = pooled / np.where(n > 0, n, 1)
    triads, broken = 0, np.zeros(3, int)
    for three in combinations(range(len(pooled)), 3):
        if any(n[a, b] == 0 for a, b in combinations(three, 2)):
            continue
        triads += 1
        held = np.zeros(3, bool)
        for a, b, c in permutations(three):
            x, y, far = share[a, b], share[b, c], share[a, c]
            if min(x, y) >= 0.5:
                held |= [far >= 0.5, far >= min(x, y), far >= max(x, y)]
        broken += ~held
    names = ("weak_violations", "moderate_violations", "strong_violations")
    return {"triads": triads, **dict(zip(names, broken, strict=True))} if triads else {}


def consistency(chosen):
    """Return circular triads of one participant and Kendall's coefficient; p up to 6 surfaces."""
    k = len(chosen)
    one, other = np.triu_indices(k, 1)
    if k < 3 or not (chosen + chosen.T)[one, other].all():
        return {}
    wins, ties = (chosen > chosen.T).sum(axis=1), (chosen == chosen.T).sum(axis=1) - 1
    # A tie goes either way: a score is the wins and a binomial part of the ties.
    score = wins + ties / 2
    circular = comb(k, 3) - (score**2 + ties / 4 - score).sum() / 2
    most = (k**3 - (k if k % 2 else 4 * k)) // 24
    out = {"circular_triads": circular, "triads": comb(k, 3), "zeta": 1 - circular / most}
    out["ties"] = ties.sum() / 2
    if k <= 6 and not ties.any():
        fewer = 0
        for ways in product((0, 1), repeat=len(one)):
            scores = np.bincount(np.where(ways, one, other), minlength=k)
            fewer += comb(k, 3) - (scores * (scores - 1) // 2).sum() <= circular
        out["p"] = fewer / 2 ** len(one)
    return out


def differences(main, surfaces):
    """Return the scale of triads: a probit model of which step was larger (MLDS)."""
    place = {name: i for i, name in enumerate(surfaces)}
    a, b, c = (main[f"stimulus{i}"].map(place).to_numpy(int) for i in (1, 2, 3))
    design = np.zeros((len(main), len(surfaces)))
    rows = np.arange(len(main))
    for first, second, sign in ((a, b, -1), (b, c, 1)):
        np.add.at(design, (rows, np.maximum(first, second)), sign)
        np.add.at(design, (rows, np.minimum(first, second)), -sign)
    larger = (main["response"] == 2).to_numpy(float)
    family = sm.families.Binomial(sm.families.links.Probit())
    fitted = sm.GLM(larger, design[:, 1:], family=family).fit(tol=1e-13)
    scale = np.append(0.0, fitted.params)
    return {
        "noise": 1 / scale[-1],
        "log_likelihood": fitted.llf,
        "answers": len(main),
        **{f"values.{i}": value for i, value in enumerate(scale / scale[-1])},
    }


def scales(comparisons, confidence):
    """Return the numbers of every task of paired comparison."""
    out = {}
    for i, (_, rows) in enumerate(comparisons.groupby("task")):
        place = f"scales.{i}."
        main = rows[~rows["catch"]]
        triads = main["stimulus3"].notna().any()
        names = [f"stimulus{j}" for j in ((1, 2, 3) if triads else (1, 2))]
        surfaces = in_order(set(main[names].to_numpy().ravel()))
        found = {
            "participants": main["participant_id"].nunique(),
            "answers": len(main),
            "catch_trials": len(rows) - len(main),
        }
        if triads:
            found |= {f"differences.{k}": v for k, v in differences(main, surfaces).items()}
        else:
            number = {name: j for j, name in enumerate(surfaces)}
            people = sorted(main["participant_id"].unique())
            chosen = np.zeros((len(people), len(surfaces), len(surfaces)))
            for who, one, two, response in main[["participant_id", *names, "response"]].itertuples(
                index=False
            ):
                pair = (number[one], number[two])
                chosen[(people.index(who), *(pair if response == 1 else pair[::-1]))] += 1
            counted = chosen.sum(axis=0)
            for j in range(len(surfaces)):
                found[f"chosen.{j}"] = counted[j].sum()
                found[f"compared.{j}"] = counted[j].sum() + counted[:, j].sum()
            for model, link in (
                ("bradley_terry", stats.logistic),
                ("thurstone", stats.norm),
            ):
                scale = pair_scale(chosen, link, confidence)
                found |= {f"{model}.{key}": value for key, value in scale.items()}
            found |= {f"transitivity.{k}": v for k, v in transitivity(chosen).items()}
            for who, own in zip(people, chosen, strict=True):
                found |= {f"consistency.{who}.{k}": v for k, v in consistency(own).items()}
        out |= {place + key: value for key, value in found.items()}
    return out


# Matching -----------------------------------------------------------------------------------------


def matching(matches, confidence):
    """Return the numbers of every task and reference that was matched."""
    out = {}
    turned = matches[~matches["catch"]]
    for i, ((task, reference), rows) in enumerate(turned.groupby(["task", "reference_um_pp"])):
        place = f"matching.{i}."
        same = (matches["task"] == task) & (matches["reference_um_pp"] == reference)
        caught = matches[matches["catch"] & same]
        own = rows.groupby("participant_id")["matched_um_pp"].mean()
        sides = rows.pivot_table(
            index="participant_id", columns="direction", values="matched_um_pp"
        ).reindex(columns=["ascending", "descending"])
        spread = rows.groupby(["participant_id", "direction"])["matched_um_pp"].var(ddof=1).dropna()
        found = {
            "reference": reference,
            "matches": len(rows),
            "participants": len(own),
            "mean": own.mean(),
            "variability": np.sqrt(spread.mean()) if len(spread) else np.nan,
            "ascending": sides["ascending"].mean(),
            "descending": sides["descending"].mean(),
            "catch_trials": len(caught),
            "catch_error": (caught["matched_um_pp"] - reference).abs().mean(),
            "felt_again": rows["felt_again"].mean(),
        }
        for name, values in (
            ("bias", own - reference),
            ("direction", sides["descending"] - sides["ascending"]),
        ):
            found |= {f"{name}.{key}": v for key, v in mean_test(values, confidence).items()}
        out |= {place + key: value for key, value in found.items()}
    return out


def main(folder):
    """Print every number beside the report's; return how many differ."""
    warnings.simplefilter("ignore")  # of fits without a limit, which the report has not either
    settings = dict(pd.read_csv(folder / "settings.csv", dtype=str).itertuples(index=False))
    confidence = float(settings["confidence"])
    reported = read(folder, "numbers.csv").set_index("name")["value"]
    reported = reported[reported.index.str.startswith(PARTS)]
    found = {}
    choices = read(folder, "choices.csv")
    if choices is not None:
        found |= thresholds(choices, confidence, set(reported.index))
        found |= agreement(choices, exponents(folder, settings), found, confidence)
    comparisons = read(folder, "comparisons.csv")
    found |= {} if comparisons is None else scales(comparisons, confidence)
    matches = read(folder, "matches.csv")
    found |= {} if matches is None else matching(matches, confidence)
    differ, missing = [], []
    for name, value in reported.items():
        if name not in found or not np.isfinite(found[name]):
            missing.append(name)
            continue
        close = CLOSE_FITS if any(part in name for part in FITTED) else CLOSE
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
