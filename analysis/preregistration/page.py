"""Render a frozen plan as one page."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from slipscale.analysis.preregistration import registry
from slipscale.analysis.preregistration.manifest import STUDY
from slipscale.analysis.preregistration.plan_in_words import plan_blocks
from slipscale.analysis.writing import html
from slipscale.experiments.running.study_commands import show
from slipscale.experiments.study.file import read_study

if TYPE_CHECKING:
    from collections.abc import Mapping

    from slipscale.analysis.preregistration.manifest import Manifest
    from slipscale.analysis.tasks.kind import Analysis

PAGE = "plan.html"
NOT_PROVED = (
    "The SHA-256 values detect accidental changes. They do not prove the date, and anyone who "
    "edits files can recompute them: deposit the bundle, or its digest, with a third party "
    "that records the date."
)


def render(
    plan: Manifest, analysis: Analysis, contents: Mapping[str, bytes], *, study: str, people: str
) -> str:
    """Return the page.

    Parameters
    ----------
    plan : Manifest
        Manifest with all files except the page.
    analysis : Analysis
        Analysis of one simulated study.
    contents : Mapping
        Name -> content of every file except the page.
    study : str
        The study file, or the shipped study's name.
    people : str
        The population's name.
    """
    sections = [
        _participants(plan, people),
        *_hypotheses(contents),
        _registry(plan, analysis, study),
        _analysis(plan, analysis),
        *_power(plan, contents),
        _design(study),
        _provenance(plan),
    ]
    return html.page(
        "plan.html",
        "slipscale.analysis.preregistration",
        title=plan.title,
        version=plan.software.get("slipscale", ""),
        facts=[
            ("Study", plan.name),
            ("Frozen", plan.frozen_utc),
            ("Participants planned", str(plan.participants)),
            ("Sessions", ", ".join(plan.sessions) or "1"),
            ("Study file, SHA-256", next(f.sha256 for f in plan.files if f.path == STUDY)),
        ],
        sections=html.numbered(sections),
    )


def _participants(plan: Manifest, people: str) -> html.ReportSection:
    section = html.ReportSection("Participants and stopping rule")
    visits = f"{len(plan.sessions)} sessions" if plan.sessions else "1 session"
    runs = f"{plan.runs} runs" if plan.runs > 1 else "1 run"
    section.blocks += [
        html.paragraph(f"{plan.participants} participants; {visits} of {runs} each."),
        html.labelled("Stopping rule", plan.stopping_rule),
        html.paragraph(
            f"The plan was made with simulated people from the population “{people}”; "
            "population.json contains its parameters.",
            "note",
        ),
    ]
    return section


def _hypotheses(contents: Mapping[str, bytes]) -> list[html.ReportSection]:
    found = []
    for name, content in contents.items():
        if name.startswith("notes"):
            section = html.ReportSection("Hypotheses and notes")
            paragraphs = content.decode("utf-8").split("\n\n")
            section.blocks += [html.paragraph(text.strip()) for text in paragraphs if text.strip()]
            found.append(section)
    return found


def _registry(plan: Manifest, analysis: Analysis, study: str) -> html.ReportSection:
    section = html.ReportSection("Answers for registries")
    asked = registry.answers(plan, analysis, read_study(study)[0])
    section.blocks += [html.labelled(question, answer) for question, answer in asked]
    return section


def _analysis(plan: Manifest, analysis: Analysis) -> html.ReportSection:
    section = html.ReportSection("Analysis plan")
    section.blocks += [
        html.paragraph(
            "How slipscale analyse treats the data, in the words of the report's methods "
            "section: this page was written by analysing one simulated study with the same "
            "code. Tests that need features that simulated people lack (groups, for example) "
            "are missing.",
            "note",
        ),
        *plan_blocks(analysis, plan.software),
    ]
    return section


def _power(plan: Manifest, contents: Mapping[str, bytes]) -> list[html.ReportSection]:
    if "power/power.json" not in contents:
        return []
    section = html.ReportSection("Power")
    told = json.loads(contents["power/power.json"])
    rows = [
        [
            str(each.get("participants", "")),
            str(each.get("repetitions", "")),
            f"{each.get('effect', 1):g}",
            f"{each['weakest']:.3f}",
        ]
        for each in told.get("conditions", [])
    ]
    titles = ("Participants", "Ratings per surface", "Effect", "Power of the weakest")
    columns = html.columns(*titles)
    section.blocks += [html.paragraph(each) for each in _remarks(told, plan.participants)]
    section.blocks.append(
        html.table(
            columns,
            rows,
            f"Proportion of simulated studies in which every planned comparison was significant; "
            f"target {told.get('target', '')}.",
        )
    )
    if "power/power.svg" in contents:
        alt = "Power against participants"
        section.blocks.append(
            Markup('<figure><img src="power/power.svg" alt="{}"></figure>').format(alt)
        )
    return [section]


def _remarks(power: dict[str, Any], participants: int) -> list[str]:
    """Return notes on the power result for the planned number of participants."""
    planned = [
        each for each in power.get("conditions", []) if each.get("participants") == participants
    ]
    if not planned:
        return [f"No condition has the planned {participants} participants."]
    weakest = max(each["weakest"] for each in planned)
    if weakest >= float(power.get("target", 0)):
        return []
    remark = (
        f"The planned {participants} participants do not reach the target: in {weakest:.0%} of "
        "simulated studies every planned comparison is significant; the target is "
        f"{float(power['target']):.0%}. State why the study is run nevertheless, or plan more "
        "participants, fewer comparisons or more repetitions."
    )
    return [remark]


def _design(study: str) -> html.ReportSection:
    section = html.ReportSection("The study")
    section.blocks.append(Markup("<pre>{}</pre>").format(show(study, "01")))
    return section


def _provenance(plan: Manifest) -> html.ReportSection:
    section = html.ReportSection("Versions and files")
    software = [(name, version) for name, version in plan.software.items()]
    two = html.columns("Software", "Version", left=2)
    listed = [
        (file.path, file.role + (f" ({file.named_by})" if file.named_by else ""), file.sha256)
        for file in plan.files
    ]
    three = html.columns("File", "What", "SHA-256", left=3)
    section.blocks += [
        html.table(
            two,
            software,
            "Packages used in the analysis; packages.txt lists all installed packages.",
        ),
        html.table(three, listed, "Every file except this page and manifest.json."),
        html.paragraph(NOT_PROVED, "note"),
    ]
    return section
