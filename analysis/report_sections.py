"""The report's sections: each takes the analysis and returns headings, tables, figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from analysis import html, normalisation, published
from analysis import quality as quality_rules
from analysis.apa import MODEL_NAMES, p_value
from analysis.html import Column, Section, interval, number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from analysis.pipeline import Analysis

#: Longer lists of participants are in quality.csv.
PARTICIPANTS_SHOWN = 60

TEST_TITLES = {
    "rm_anova": "Repeated-measures ANOVA, log estimates",
    "friedman": "Friedman",
    "page_trend": "Page's ordered trend",
    "linear_trend": "Linear trend, log estimates",
    "pairwise": "Pairwise comparisons",
    "power_law": "Exponent",
    "mixed_model": "Mixed model",
    "growth": "Growth functions",
    "order": "Order and carry-over",
    "reliability": "Test-retest reliability",
}


def estimates(analysis: Analysis, svgs: Mapping[str, str]) -> Section:
    """Return Fig. 15 and Table III, large, and the full descriptives."""
    section = Section("Magnitude estimates")
    if analysis.prepared is None:
        return section
    rule = normalisation.RULES[analysis.rule]
    level = 100 * analysis.dataset.choices.confidence
    section.blocks.append(
        html.figure(
            svgs["fig15"],
            f"Perceived slipperiness against vibration amplitude. Thick: means of "
            f"{len(analysis.cells)} participants with {level:g} % within-participant confidence "
            "intervals (Cousineau-Morey). Thin: each participant's means. Normalisation: "
            f"{analysis.rule} ({rule.formula}).",
        )
    )
    section.blocks.append(table3(analysis))
    section.blocks.append(
        html.table(
            [
                Column(title="Amplitude", unit="µm, p-p"),
                Column(title="Mean"),
                Column(title="Within-participant", unit=f"{level:g} % interval"),
                Column(title="Bootstrap", unit=f"{level:g} % interval"),
                Column(title="Geometric mean"),
                Column(title="Median"),
                Column(title="SD", unit="sample"),
                Column(title="SD", unit="population"),
            ],
            [
                [
                    f"{row['amplitude_um_pp']:g}",
                    number(row["mean"]),
                    interval(row["within_low"], row["within_high"]),
                    interval(row["bootstrap_low"], row["bootstrap_high"]),
                    number(row["geometric_mean"]),
                    number(row["median"]),
                    number(row["sd_sample"]),
                    number(row["sd_population"]),
                ]
                for row in analysis.description.to_dict(orient="records")
            ],
            "All descriptive statistics. Within-participant intervals compare amplitudes; "
            "bootstrap intervals (percentile, participants resampled) say where the mean of other "
            "people may lie. Geometric means leave estimates of zero to the zero rule.",
        )
    )
    if len(analysis.textures):
        section.blocks.append(textures(analysis))
    return section


def textures(analysis: Analysis) -> Any:
    """Return the same statistics for textures, which have no one amplitude."""
    titles = ("Mean", "Max. dev.", "SD")
    return html.table(
        [
            Column(title="Texture", left=True),
            Column(title="n"),
            *(Column(title=title) for title in titles),
        ],
        [
            [name, str(n), *(number(value) for value in values)]
            for name, n, *values in analysis.textures.itertuples(index=False)
        ],
        "Normalised estimates of textures, on the scale of the plain surfaces of the same run. "
        "They are in no other table, figure or test.",
    )


def table3(analysis: Analysis) -> Any:
    """Return Table III, beside the paper's where the amplitudes are the paper's."""
    convention = analysis.dataset.choices.standard_deviation
    paper = {float(row.amplitude_um_pp): row for row in published.TABLE3}
    beside = any(amplitude in paper for amplitude in analysis.table3["amplitude_um_pp"])
    titles = ("Mean", "Max. dev.", "SD")
    columns = [Column(title="Amplitude", unit="µm, p-p"), Column(title="n")]
    columns += [Column(title=title) for title in titles]
    if beside:
        columns += [Column(title=title, paper=True) for title in titles]
    rows = []
    for amplitude, n, *values in analysis.table3.itertuples(index=False):
        row = [f"{amplitude:g}", str(n), *(number(value) for value in values)]
        if beside:
            known = paper.get(amplitude)
            row += [getattr(known, name) if known else "–" for name in published.STATISTICS]
        rows.append(row)
    return html.table(
        columns,
        rows,
        "Normalised estimates over participants, each participant's mean being one value. "
        "Max. dev.: largest distance of a value from the mean. SD: "
        f"{convention} standard deviation "
        f"({'n − 1' if convention == 'sample' else 'n'} in the denominator)."
        + (f" The paper's: Table III, n = {published.PARTICIPANTS}." if beside else ""),
        over=[("", 2), ("this study", 3), ("the paper", 3)] if beside else (),
    )


def comparisons(analysis: Analysis) -> Section:
    """Return pairwise comparisons, and which tests could not be computed."""
    section = Section("Comparisons")
    if analysis.prepared is None:
        return section
    pairs = analysis.inference["pairwise"]
    if isinstance(pairs, list):
        level = f"{100 * analysis.dataset.choices.confidence:g} %"
        section.blocks.append(
            html.table(
                [
                    Column(title="From → to", unit="µm, p-p", left=True),
                    Column(title="Ratio", unit="of geometric means"),
                    Column(title=level, unit="of the ratio"),
                    Column(title="t"),
                    Column(title="df"),
                    Column(title="p", unit="Holm"),
                    Column(title="d_z"),
                    Column(title=level, unit="of d_z"),
                    Column(title="Up / down", unit="participants"),
                    Column(title="p Wilcoxon", unit="Holm"),
                ],
                [
                    [
                        f"{row['from_um_pp']:g} → {row['to_um_pp']:g}",
                        number(row.get("ratio")),
                        interval(*row.get("ratio_ci", (None, None))),
                        number(row.get("t")),
                        str(row.get("df", "–")),
                        p_value(row.get("p_holm")).removeprefix("p ").removeprefix("= "),
                        number(row.get("d_z")),
                        interval(*row.get("d_z_ci", (None, None))),
                        f"{row['up']} / {row['down']}",
                        p_value(row.get("p_wilcoxon_holm")).removeprefix("p ").removeprefix("= "),
                    ]
                    for row in analysis.inference["pairwise"]
                ],
                f"Paired comparisons of log estimates ({pairs[0]['n']} participants with an "
                "estimate at every amplitude) and Wilcoxon's test on the estimates themselves. "
                "d_z: mean difference over the standard deviation of the differences.",
            )
        )
    missing = [
        f"{TEST_TITLES[name]}: {part['reason']}."
        for name in TEST_TITLES
        if isinstance(part := analysis.inference[name], dict) and "reason" in part
    ]
    if missing:
        section.blocks.append(html.heading("Not computed"))
        section.blocks.append(html.bullets(missing, "note"))
    return section


def growth(analysis: Analysis, svgs: Mapping[str, str]) -> Section:
    """Return the growth of sensation: figure and models."""
    section = Section("Growth of sensation")
    if "growth" not in svgs:
        return section
    found = analysis.inference["growth"]
    section.blocks.append(
        html.figure(
            svgs["growth"],
            "Left: growth functions fitted to all participants at once, each participant with an "
            "own factor. Right: the same geometric means on logarithmic axes; the slope is the "
            "exponent. Bars: Student's intervals over participants. 0 µm has no place on a "
            "logarithmic axis and takes no part.",
        )
    )
    if "reason" in found:
        section.blocks.append(html.paragraph(f"Growth functions: {found['reason']}.", "note"))
        return section
    against = [("amplitude", "Against amplitude (µm, peak to peak)")]
    if "reason" not in found["friction"]:
        against.append(
            (
                "friction",
                (
                    "Against the reduction of friction that the film predicts, 1 − µ′/µ (Reynolds' "
                    "equation, h_r 0.6 µm, 30.5 kHz, 0.5 N)"
                ),
            )
        )
    section.blocks += [_models(found[key], title) for key, title in against]
    if "reason" not in found["individual"]:
        best = ", ".join(
            f"{MODEL_NAMES[name]} {count}" for name, count in found["individual"]["best"].items()
        )
        section.blocks.append(
            html.paragraph(
                f"Favoured in single participants' trials: {best}; undecided for lack of trials "
                f"{found['individual']['undecided']}. With so few amplitudes a participant's "
                "exponent is descriptive.",
                "note",
            )
        )
    return section


def _models(found: Mapping[str, Any], title: str) -> Any:
    rows = []
    for name, model in found["models"].items():
        title_ = MODEL_NAMES[name]
        parameters = ", ".join(f"{key} {value:.3g}" for key, value in model["parameters"].items())
        rows.append(
            [
                title_[0].upper() + title_[1:],
                parameters,
                number(model["sd"], 3),
                number(model["log_likelihood"], 2),
                number(model["delta_aicc"], 2),
                number(model["weight"], 2),
                number(model["bic"], 1),
            ]
        )
    return html.table(
        [
            Column(title="Model", left=True),
            Column(title="Parameters", left=True),
            Column(title="Residual SD", unit="log"),
            Column(title="Log-likelihood"),
            Column(title="ΔAICc"),
            Column(title="Weight"),
            Column(title="BIC"),
        ],
        rows,
        f"{title}: growth functions of {found['n']} participants' mean log estimates, compared by "
        "the corrected Akaike criterion.",
        marked=list(found["models"]).index(found["best"]),
    )


def difference(analysis: Analysis, svgs: Mapping[str, str]) -> Section:
    """Return the descending difference: figure, steps, words."""
    section = Section("Descending difference")
    found = analysis.inference["difference"]
    if "difference" not in svgs:
        return section
    section.blocks.append(
        html.figure(
            svgs["difference"],
            "Share of “yes” at each step down, with Clopper and Pearson's exact intervals."
            + (
                " Answers of the same participant count as independent here."
                if found["answers_per_participant_and_step"] > 1
                else ""
            ),
        )
    )
    words = found["verbal_reports"]
    if "reason" in words:
        section.blocks.append(html.paragraph(f"Verbal reports: {words['reason']}.", "note"))
        return section
    section.blocks.append(
        html.table(
            [
                Column(title="Category", left=True),
                Column(title="Reports"),
                Column(title="In the participants' words", left=True),
            ],
            [
                [
                    name,
                    str(entry["count"]),
                    "; ".join(
                        f"“{text}”" + (f" ×{count}" if count > 1 else "")
                        for text, count in list(entry["words"].items())[:40]
                    ),
                ]
                for name, entry in words["categories"].items()
            ],
            f"“What has been removed?” {words['n']} reports, coded by: {words['codebook']}. A "
            "report may have several categories. Read as less slippery: "
            f"{words['meaning'].get('less_slippery', 0)}; as more slippery: "
            f"{words['meaning'].get('more_slippery', 0)}; unclear: "
            f"{words['meaning'].get('unclear', 0)}.",
            long=True,
        )
    )
    coders = found.get("coders")
    if coders and "reason" not in coders:
        section.blocks.append(
            html.paragraph(
                f"Two coders ({' and '.join(coders['coders'])}) agreed on {coders['agreed']} of "
                f"{coders['reports']} reports, Cohen's κ = {number(coders['kappa'])}, 95 % "
                f"{interval(*coders['ci95'])}."
            )
        )
    return section


def assumptions(analysis: Analysis, svgs: Mapping[str, str]) -> Section:
    """Return what the tests assume and how the data looks by it."""
    section = Section("Assumptions")
    anova = analysis.inference["rm_anova"]
    if "residuals" not in svgs:
        return section
    texts = []
    if anova["mauchly_p"] is not None:
        verdict = "violated" if anova["mauchly_p"] < 0.05 else "not rejected"  # noqa: PLR2004
        texts.append(
            f"Sphericity {verdict}: Mauchly's W = {number(anova['mauchly_w'], 3)}, "
            f"{p_value(anova['mauchly_p'])}; ε = {number(anova['epsilon_gg'], 3)} "
            f"(Greenhouse-Geisser), {number(anova['epsilon_hf'], 3)} (Huynh-Feldt); corrected "
            f"{p_value(anova['p_gg'])} and {p_value(anova['p_hf'])}."
        )
    if "shapiro_p" in anova:
        texts.append(
            f"Normality of residuals: Shapiro-Wilk W = {number(anova['shapiro_w'], 3)}, "
            f"{p_value(anova['shapiro_p'])}."
        )
    if analysis.prepared is not None and analysis.prepared.zero_sentence:
        texts.append(analysis.prepared.zero_sentence)
    if anova["n_incomplete"]:
        texts.append(
            f"Participants without a logarithm at some amplitude: {anova['n_incomplete']}. They "
            "take no part in tests on logarithms; Friedman's and Wilcoxon's tests keep zeros."
        )
    section.blocks.append(html.bullets(texts))
    section.blocks.append(
        html.figure(
            svgs["residuals"],
            "Residuals of log estimates less participants' and amplitudes' means: left against a "
            "normal distribution (on the line: normal), right at each amplitude (even spread: "
            "equal variances).",
        )
    )
    return section


def quality(analysis: Analysis) -> Section:
    """Return flags, exclusions and the results without the flagged."""
    section = Section("Participants and data quality")
    data, counts = analysis.dataset, analysis.dataset.counts
    section.blocks.append(
        html.paragraph(
            f"{number(counts.get('estimation_rows', 0), 0)} rows of magnitude estimation were "
            f"read: {counts.get('practice', 0)} practice and {counts.get('voided', 0)} voided "
            f"trials are never analysed; {counts.get('unanswered', 0)} main trials have no usable "
            f"answer ({counts.get('timed_out', 0)} timed out); "
            f"{counts.get('faulty', 0)} were presented again after a fault or a pause."
        )
    )
    rules = ", ".join(data.choices.exclusions)
    section.blocks.append(
        html.paragraph(
            f"Exclusion rule of the study file: {rules}. Excluded before anything was described: "
            + (
                "; ".join(f"{who} ({', '.join(why)})" for who, why in analysis.excluded.items())
                or "nobody"
            )
            + "."
            if rules
            else "The study file sets no exclusion: nobody was excluded. Flags inform, they never "
            "exclude by themselves."
        )
    )
    flags = analysis.flags
    flagged = flags[flags.any(axis=1)]
    rows = [
        [
            str(who),
            "; ".join(
                f"{name.replace('_', ' ')} ({_measure(analysis, who, name)})"
                for name in flags.columns
                if row[name]
            ),
            "excluded" if str(who) in analysis.excluded else "kept",
        ]
        for who, row in flagged.iloc[:PARTICIPANTS_SHOWN].iterrows()
    ]
    if rows:
        meanings = "; ".join(
            f"{name.replace('_', ' ')}: {quality_rules.MEANINGS[name]}"
            for name in flags.columns
            if flagged[name].any()
        )
        more = len(flagged) - len(rows)
        section.blocks.append(
            html.table(
                [
                    Column(title="Participant", left=True),
                    Column(title="Flags (measure)", left=True),
                    Column(title="", left=True),
                ],
                rows,
                f"Flagged: {len(flagged)} of {len(flags)} participants. {meanings}."
                + (f" {more} more are in quality.csv." if more else ""),
                long=True,
            )
        )
    else:
        section.blocks.append(html.paragraph("No participant carries a flag."))
    if len(analysis.robustness) > 1:
        section.blocks.append(_with_and_without(analysis))
    return section


def _measure(analysis: Analysis, who: Any, name: str) -> str:
    return f"{float(analysis.measures.loc[who, name]):.3g}"


def _with_and_without(analysis: Analysis) -> Any:
    amplitudes = list(analysis.robustness[0]["means"])
    return html.table(
        [
            Column(title="Participants", left=True),
            Column(title="n"),
            *(Column(title="Mean", unit=f"{a} µm") for a in amplitudes),
            Column(title="Exponent"),
            Column(title="Interval"),
            Column(title="Friedman χ²"),
        ],
        [
            [
                row["participants"],
                str(row["n"]),
                *(number(row["means"].get(a)) for a in amplitudes),
                number(row["exponent"]),
                interval(*(row["exponent_ci"] or (None, None))),
                number(row["friedman_chi2"]),
            ]
            for row in analysis.robustness
        ],
        "The chief results with and without flagged participants.",
    )


def normalisations(analysis: Analysis) -> Section:
    """Return what other rules would have given."""
    section = Section("What if estimates were normalised otherwise?")
    if not analysis.sensitivity:
        return section
    amplitudes = list(analysis.sensitivity[0]["mean"])
    section.blocks.append(
        html.table(
            [
                Column(title="Rule", left=True),
                *(Column(title=f"{a} µm", unit="mean (SD)") for a in amplitudes),
            ],
            [
                [
                    row["rule"],
                    *(
                        f"{number(row['mean'][a], 1)} ({number(row['sd_sample'][a], 1)})"
                        for a in amplitudes
                    ),
                ]
                for row in analysis.sensitivity
            ],
            "Means and sample standard deviations under every rule that the data allows; the one "
            "in use is set off. Exponents, the ANOVA on logarithms and within-participant signs "
            "are the same under all of them, as each multiplies a participant's estimates by one "
            "number.",
            marked=next(
                (place for place, row in enumerate(analysis.sensitivity) if row["used"]), None
            ),
        )
    )
    return section


def methods(analysis: Analysis, software: Mapping[str, str]) -> Section:
    """Return what a methods section needs: choices, versions, seeds, digests."""
    section = Section("Methods and provenance")
    data, choices = analysis.dataset, analysis.dataset.choices
    frozen = ", ".join(data.frozen)
    versions = ", ".join(f"{name} {number_}" for name, number_ in software.items())
    section.blocks.append(
        html.paragraph(
            "Estimates were normalised, averaged per participant and amplitude, and tested as "
            "natural logarithms or ranks. Repeated-measures ANOVA, sphericity, effect sizes and "
            "intraclass correlations: pingouin; mixed model, Holm's correction, exact intervals: "
            "statsmodels; other tests, fits and the bootstrap "
            f"({choices.bootstrap_resamples} resamples, seed {choices.bootstrap_seed}): SciPy."
        )
    )
    section.blocks.append(
        html.paragraph(
            f"Frozen in the study file before the data was looked at: {frozen}."
            if frozen
            else "The study file froze no choice of analysis: all are Slipscale's defaults."
        )
    )
    rows = [
        ("Software", versions),
        ("Session software", ", ".join(data.details.get("software", ("not recorded",)))),
        ("Study's hash", ", ".join(data.details.get("study_hash", ("not recorded",)))),
        ("Seeds", _few(data.details.get("seed", ("not recorded",)))),
        ("Zero rule", f"{choices.zero_rule}"),
        ("Standard deviation", choices.standard_deviation),
        ("Data, SHA-256", data.sha256),
        ("Files read", f"{len(data.sources)} (each with its SHA-256 in results.json)"),
    ]
    section.blocks.append(
        html.table(
            [Column(title="What", left=True), Column(title="Value", left=True)],
            rows,
            "For the methods section, and for whoever repeats this.",
            long=True,
        )
    )
    return section


def _few(values: tuple[str, ...]) -> str:
    shown = 12
    return ", ".join(values[:shown]) + (
        f" and {len(values) - shown} more" if len(values) > shown else ""
    )
