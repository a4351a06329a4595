"""The sentences a results section needs, numbers filled in, in APA style (7th edition).

Each writer takes a part of ``inference.json`` and returns a sentence, or None where the part has
only a reason.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

Part = dict[str, Any]

#: Sentences call reliable what has a p below this.
RELIABLE = 0.05
#: What `analysis.statistics.power_law.MODELS` are called in a sentence.
MODEL_NAMES = {
    "power": "Stevens's power law",
    "threshold": "the power law with a threshold",
    "linear": "the straight line",
    "fechner": "Fechner's law",
}


def p_value(p: float | None) -> str:
    """Return "p = .023", or "p < .001".

    >>> p_value(0.0234), p_value(0.00012), p_value(0.9999), p_value(float("nan"))
    ('p = .023', 'p < .001', 'p > .999', 'p not defined')
    """
    if p is None or math.isnan(p):
        return "p not defined"
    if p < 0.001:  # noqa: PLR2004
        return "p < .001"
    if p > 0.999:  # noqa: PLR2004
        return "p > .999"
    return f"p = {unit_number(p, 3)}"


def unit_number(value: float, decimals: int = 2) -> str:
    """Return a number that cannot exceed 1 without its leading zero.

    >>> unit_number(0.517), unit_number(-0.2)
    ('.52', '−.20')
    """
    text = f"{abs(value):.{decimals}f}"
    sign = "−" if value < 0 and float(text) else ""
    return sign + (text.removeprefix("0"))


def number(value: float, decimals: int = 2) -> str:
    """Return a number with a real minus.

    >>> number(-2.5)
    '−2.50'
    """
    return f"{value:.{decimals}f}".replace("-", "−")


def bracketed(bounds: list[float], write: Callable[[float], str] = number) -> str:
    """Return "[low, high]"."""
    return f"[{write(bounds[0])}, {write(bounds[1])}]"


def _ci(bounds: list[float | None], level: str, write: Callable[[float], str] = number) -> str:
    """Return ", 95% CI [low, high]", or nothing where it is not defined."""
    low, high = bounds
    return "" if low is None or high is None else f", {level} CI {bracketed([low, high], write)}"


def _degrees(df: float, epsilon: float) -> str:
    corrected = df * epsilon
    return f"{corrected:.2f}" if epsilon < 1 else f"{df:g}"


def rm_anova(part: Part, level: str) -> str:
    """Return the sentence of the repeated-measures ANOVA, corrected where sphericity fails."""
    violated = part["mauchly_p"] is not None and part["mauchly_p"] < RELIABLE
    epsilon = part["epsilon_gg"] if violated else 1.0
    p = part["p_gg"] if violated else part["p"]
    sphericity = (
        f" (Greenhouse-Geisser correction, ε = {unit_number(part['epsilon_gg'])}; Mauchly's "
        f"W = {unit_number(part['mauchly_w'], 3)}, {p_value(part['mauchly_p'])})"
        if violated
        else ""
    )
    verb = "differed" if p < RELIABLE else "did not differ reliably"
    ci = _ci(part["eta2_generalised_ci"], level, unit_number)
    return (
        f"Log-transformed estimates {verb} between amplitudes, "
        f"F({_degrees(part['df1'], epsilon)}, {_degrees(part['df2'], epsilon)}) = "
        f"{number(part['F'])}, {p_value(p)}, generalised η² = "
        f"{unit_number(part['eta2_generalised'])}{ci}{sphericity}."
    )


def friedman(part: Part, _level: str) -> str:
    """Return the sentence of Friedman's test."""
    return (
        f"Friedman's test on the ranks gave χ²({part['df']}, N = {part['n']}) = "
        f"{number(part['chi2'])}, {p_value(part['p'])}, Kendall's W = "
        f"{unit_number(part['kendalls_w'])}."
    )


def page_trend(part: Part, _level: str) -> str:
    """Return the sentence of Page's test."""
    outcome = "grew" if part["p"] < RELIABLE else "did not grow reliably"
    return (
        f"Estimates {outcome} with amplitude (Page's L = {part['L']:g}, "
        f"{p_value(part['p'])}, one-sided)."
    )


def linear_trend(part: Part, level: str) -> str:
    """Return the sentence of the linear contrast."""
    return (
        f"The linear trend of log estimates was {number(part['mean'])} per µm (peak to peak), "
        f"{level} CI {bracketed(part['ci'])}, t({part['df']}) = {number(part['t'])}, "
        f"{p_value(part['p'])}."
    )


def power_law(part: Part, level: str) -> str:
    """Return the sentence of the exponent."""
    return (
        f"The exponents of participants' power functions of amplitude averaged "
        f"{number(part['exponent'])}, {level} CI "
        f"{bracketed(part.get('ci95') or part['ci'])} (n = {part['n']}; {part['points']} "
        "amplitudes above 0 µm; Student's interval over participants)."
    )


def pairwise(part: Any, level: str) -> str | None:
    """Return one sentence on all pairs."""
    tested = [row for row in part if "reason" not in row]
    if len(part) == len(tested) == 1:
        row = tested[0]
        verb = "differed" if row["p"] < RELIABLE else "did not differ reliably"
        return (
            f"The two amplitudes {verb}, t({row['df']}) = {number(row['t'])}, {p_value(row['p'])}, "
            f"d_z = {number(row['d_z'])}{_ci(row['d_z_ci'], level)}."
        )
    reliable = [row for row in tested if row["p_holm"] < RELIABLE]
    doubtful = [row for row in tested if row not in reliable]

    def pair(row: Part) -> str:
        return f"{row['from_um_pp']:g} and {row['to_um_pp']:g} µm"

    # Where every participant has the same difference, there is no t to judge it by.
    untested = "; ".join(pair(row) for row in part if "reason" in row)
    behind = f" Without spread between participants, not tested: {untested}." if untested else ""
    if not tested:
        return behind.strip()
    if not doubtful:
        largest = p_value(max(row["p_holm"] for row in tested)).replace("=", "≤")
        many = f"All {len(tested)} pairs" if len(tested) > 1 else "One pair"
        return f"{many} of amplitudes differed (Holm-corrected, every {largest}).{behind}"
    listed = "; ".join(f"{pair(row)}, {p_value(row['p_holm'])}" for row in doubtful)
    start = (
        f"{len(reliable)} of {len(tested)} pairs of amplitudes differed (Holm-corrected)"
        if reliable
        else f"None of {len(tested)} pairs of amplitudes differed (Holm-corrected)"
    )
    return f"{start}; not told apart: {listed}.{behind}"


def growth(part: Part, _level: str) -> str | None:
    """Return the sentence of the model comparison."""
    found = part["amplitude"]
    best = found["models"][found["best"]]
    others = sorted(
        (model["delta_aicc"], name)
        for name, model in found["models"].items()
        if name != found["best"] and model["delta_aicc"] is not None
    )
    listed = ", ".join(f"{MODEL_NAMES[name]} ΔAICc = {number(delta, 1)}" for delta, name in others)
    return (
        f"Among growth functions, {MODEL_NAMES[found['best']]} was favoured (Akaike weight "
        f"{unit_number(best['weight'])}; {listed})."
    )


def order(part: Part, _level: str) -> str | None:
    """Return the sentence on order and carry-over."""
    texts = []
    for name, words in (("position", "the trial's position"), ("carry_over", "the surface before")):
        own = part[name]
        if "reason" in own:
            continue
        verb = "depended" if own["p"] < RELIABLE else "did not depend reliably"
        texts.append(
            f"estimates {verb} on {words}, t({own['df']}) = {number(own['t'])}, {p_value(own['p'])}"
        )
    if not texts:
        return None
    text = "; ".join(texts)
    return text[0].upper() + text[1:] + "."


def reliability(part: Part, _level: str) -> str:
    """Return the sentence on test-retest reliability."""
    icc = part["icc"]["ICC2"]
    return (
        f"Test-retest reliability of single log estimates over {part['repetitions']} repetitions "
        f"was ICC(A,1) = {unit_number(icc['value'])}, 95% CI {bracketed(icc['ci95'], unit_number)} "
        f"(over {part['targets']} pairs of participant and amplitude, so that differences between "
        "amplitudes count as reliable)."
    )


def mixed_model(part: Part, level: str) -> str:
    """Return the sentence of the mixed model; its numbers only where the fit converged."""
    if not part["converged"]:
        return (
            "The linear mixed model with random intercepts and slopes did not converge; its "
            "exponent is not reported."
        )
    bound = (
        "; a variance or correlation of the random effects lies at its bound"
        if part["at_bound"]
        else ""
    )
    return (
        f"A linear mixed model with random intercepts and slopes gave an exponent of "
        f"{number(part['exponent'])}, {level} CI {bracketed(part['ci'])} (REML, {part['trials']} "
        f"trials of {part['n']} participants; Student's interval with {part['n'] - 1} degrees of "
        f"freedom{bound})."
    )


#: Part of inference.json -> its writer, in the order of a results section.
WRITERS: dict[str, Callable[[Any, str], str | None]] = {
    "rm_anova": rm_anova,
    "friedman": friedman,
    "page_trend": page_trend,
    "linear_trend": linear_trend,
    "pairwise": pairwise,
    "power_law": power_law,
    "mixed_model": mixed_model,
    "growth": growth,
    "order": order,
    "reliability": reliability,
}


def sentences(inference: Part, confidence: float = 0.95) -> list[str]:
    """Return the results' sentences for all parts that were computed."""
    level = f"{100 * confidence:g}%"
    written = [
        writer(inference[name], level)
        for name, writer in WRITERS.items()
        if name in inference
        and not (isinstance(inference[name], dict) and "reason" in inference[name])
    ]
    return [text for text in written if text]
