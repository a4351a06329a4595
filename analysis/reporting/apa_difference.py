"""The sentences on the descending difference, in APA style."""

from __future__ import annotations

from analysis.reporting.apa import RELIABLE, Part, bracketed, number, p_value


def psychometric(part: Part, level: str) -> str:
    """Return the sentence of the curve of "yes" against the size of the step."""
    if "reason" in part:
        return f"No curve of “yes” against the size of the step was fitted: {part['reason']}."
    verb = "depended" if part["p"] < RELIABLE else "did not depend reliably"
    half = (
        f"; half of the answers are “yes” at {number(part['half_yes_um'])} µm"
        if part["half_yes_um"] is not None and part["half_yes_um"] > 0
        else ""
    )
    return (
        f"“Yes” {verb} on the size of the step, log odds {number(part['log_odds_per_um'])} per µm "
        f"(peak to peak) removed, {level} CI {bracketed(part['ci'])}, t({part['df']}) = "
        f"{number(part['t'])}, {p_value(part['p'])}{half} (logistic curve by generalised "
        "estimating equations, answers of a participant exchangeable)."
    )


def _finding(found: Part) -> str:
    """Return the paper's finding: who felt a difference, and who said what went."""
    n = found["n"]
    if n == 1:
        felt = "a difference" if found["felt_a_difference"] else "no difference"
        said = "said" if found["said_less_slippery"] else "did not say"
        return (
            f"The one participant felt {felt} when the amplitude fell, and {said} that the surface "
            "became less slippery."
        )
    everyone = (
        f"All {n}" if found["all_felt_a_difference"] else f"{found['felt_a_difference']} of {n}"
    )
    said = (
        f"all {n}" if found["all_said_less_slippery"] else f"{found['said_less_slippery']} of {n}"
    )
    return (
        f"{everyone} participants felt a difference when the amplitude fell "
        f"({found['felt_every_change']} of {n} at every step), and {said} said that the surface "
        "became less slippery."
    )


def difference_sentences(part: Part, confidence: float = 0.95) -> list[str]:
    """Return the sentences on the descending difference; none where it was not run."""
    if "reason" in part:
        return []
    level = f"{100 * confidence:g}%"
    found = part["finding"]
    texts = []
    if found["n"]:
        texts.append(_finding(found))
    texts.append(psychometric(part["psychometric"], level))
    detection = part["signal_detection"]
    if "reason" in detection:
        texts.append(f"Sensitivity was not computed: {detection['reason']}.")
        return texts
    mean = detection["mean_of_participants"]
    spread = (
        ""
        if "reason" in mean
        else f"; mean of participants {number(mean['mean'])}, {level} CI {bracketed(mean['ci'])}"
    )
    texts.append(
        f"“Yes” was said on {detection['hits']} of {detection['changes']} steps and on "
        f"{detection['false_alarms']} of {detection['catches']} catch steps; pooled "
        f"d′ = {number(detection['pooled_d_prime'])}, c = "
        f"{number(detection['pooled_criterion'])} (log-linear correction{spread})."
    )
    return texts
