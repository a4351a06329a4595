"""The gallery of studies: a page for each shipped study, and the index of published experiments.

A page is derived from the study file, the declarations of protocols and statistics, and the table
of published effects (`PUBLISHED`). Nothing is simulated here.
"""

from __future__ import annotations

import io
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.analysis.preregistration.registry import design
from slipscale.analysis.reporting.methods_text import cited
from slipscale.analysis.tasks.effects.factors.declaration import ANALYSIS as FACTORS
from slipscale.analysis.tasks.kind import TaskAnalysis
from slipscale.analysis.tasks.table import KINDS
from slipscale.experiments.dataset.schema import columns
from slipscale.experiments.protocol_parts.registry import load_protocol
from slipscale.experiments.protocols.magnitude_estimation import MagnitudeEstimation
from slipscale.experiments.running.rehearsal import dry_run
from slipscale.experiments.running.study_commands import show
from slipscale.experiments.steps.steps import Present
from slipscale.experiments.study.file import read_study, shipped_studies
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.stimuli.quantity import PLATE_AMPLITUDE
from tools.site.tables import code, table

if TYPE_CHECKING:
    from slipscale.experiments.study.model import Study

INTRODUCTION = """# Studies

These studies come with Slipscale. `slipscale pilot NAME` runs a study with simulated
participants. To write your own study, start with `slipscale study new mine.toml`, and see
[all study-file keys](../reference/study-file.md).
"""
#: Task, published effect, simulated effect and recovered effect of each study.
PUBLISHED: Mapping[str, Mapping[str, str]] = tomllib.loads(
    (Path(__file__).parents[2] / "docs/tutorials/published-studies.toml").read_text("utf-8")
)
EFFECT = ("task", "published", "simulated", "recovered")
#: A comment after a key's value: `key = value  # assumed: ...`.
REMARK = re.compile(r"^([\w.]+) = ([^#\n]+?) +# (.+)$", re.MULTILINE)
TRIALS = """![Level of each trial, in the order of presentation]({name}.svg)

Grey: practice. Each participant has a different order; the same seed gives the same orders on every
machine.

```text
{shown}
```"""
CARDS = """
## The trials of each study

<div class="grid cards" markdown>

{cards}
</div>
"""
CARD = """-   [{title}]({name}.md)

    ![Level of each trial of participant 01]({name}.svg)
"""
COMMANDS = """Simulate and analyse the study, freeze the plan, run a session, and analyse the data:

```sh
slipscale pilot {name} --out pilot
slipscale study freeze {name} --out plan
slipscale run {name} --participant 01 --plate SPEC --out data
slipscale analyse data
```"""
PRACTICE, MAIN = "#9aa5a4", "#00796b"


def pages() -> dict[str, str]:
    """Return one page and one figure per study, and the index."""
    made: dict[str, str] = {}
    rows = []
    names = shipped_studies()
    for name in names:
        study, text = read_study(name)
        made[f"studies/{name}.md"] = page(name, study, text)
        made[f"studies/{name}.svg"] = figure(name, study, text)
        rows.append(
            [
                f"[{name}]({name}.md)",
                study.title,
                f"{', '.join(f'{each:g}' for each in study.levels)} {study.quantity.unit_in_short}",
                ", ".join(texture.name for texture in study.textures) or "none",
                ", ".join(code(task.protocol) for task in study.tasks),
            ]
        )
    header = ["study", "title", "levels", "textures", "tasks"]
    cards = CARDS.format(
        cards="\n".join(CARD.format(name=name, title=read_study(name)[0].title) for name in names)
    )
    return {"studies/index.md": f"{INTRODUCTION}\n{table(header, rows)}\n{cards}", **made}


def published_studies() -> str:
    """Return the table of all published effects, with links to the studies' pages."""
    rows = (
        [f"[{name}](../studies/{name}.md)", *(effect[key] for key in EFFECT)]
        for name, effect in PUBLISHED.items()
    )
    return table(["study", *EFFECT], rows)


def page(name: str, study: Study, text: str) -> str:
    """Return a study's page: source, effect, design, stimuli, analysis, commands and file."""
    comment, _, keys = text.partition("name =")
    source = " ".join(re.sub("(?m)^#", "", comment).split())
    sections = [
        (source.partition(" See docs/")[0], ""),
        *_effect(name),
        ("## Design", "\n".join(f"- **{asked}:** {said}" for asked, said in design(study))),
        *_remarks(keys),
        ("## The trials of participant 01", TRIALS.format(name=name, shown=show(name, "01"))),
        ("## Analysis", "\n\n".join(cited(each) for each in dict.fromkeys(_methods(study)))),
        ("## Commands", COMMANDS.format(name=name)),
        ("## The study file", f"```toml\n{text.strip()}\n```"),
    ]
    told = (f"{heading}\n\n{body}".strip() for heading, body in sections)
    return "\n\n".join([f"# {study.title}", *told]) + "\n"


def _effect(name: str) -> Iterator[tuple[str, str]]:
    if effect := PUBLISHED.get(name):
        row = table(EFFECT, [[effect[key] for key in EFFECT]])
        link = "See [all published experiments](../tutorials/published-studies.md)."
        yield "## Published and recovered", f"{row}\n\n{link}"


def _remarks(keys: str) -> Iterator[tuple[str, str]]:
    """Yield a table of the values that have a comment in the study file, such as "assumed"."""
    if rows := [[code(f"{key} = {value}"), said] for key, value, said in REMARK.findall(keys)]:
        yield "## Remarks on values", table(["value", "remark"], rows)


def _methods(study: Study) -> Iterator[str]:
    estimated = any(isinstance(options, MagnitudeEstimation) for options in study.tasks)
    kinds: list[TaskAnalysis] = [FACTORS] if study.factors and estimated else []
    for options in study.tasks:
        named = columns(load_protocol(options.protocol).for_task(options))
        header = frozenset(PLATE_AMPLITUDE.in_code[name] for name in named)
        kinds += [kind for kind in KINDS if kind.trials and kind.trials.belongs(header)]
    chosen = study.analysis.tests
    for kind in reversed(kinds):
        told = [
            each
            for each in kind.statistics
            if each.methods and (chosen is None or each.key in chosen)
        ]
        for each in [each for each in told if each.headlines] or told:
            yield each.methods.format(q=study.quantity, bounds="the study's bounds")


def figure(name: str, study: Study, text: str) -> str:
    """Return an SVG of the levels of participant 01's trials, task by task."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    plan = RunPlan(
        study_name=name,
        study_text=text,
        participant="01",
        seed=study.seed,
        language=study.language,
        mode="pilot",
    )
    shown = [step for step in dry_run(plan) if isinstance(step, Present) and step.trial]
    tasks = {protocol.task: protocol.titled(plan.study.quantity) for protocol, _ in plan.tasks()}
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": name, "font.size": 9}):
        drawn = Figure(figsize=(7.0, 2.2))
        drawn.subplots_adjust(left=0.08, right=0.99, bottom=0.2, top=0.88)
        axes = drawn.subplots(1, len(tasks), sharey=True, squeeze=False)[0]
        for axis, task in zip(axes, tasks, strict=True):
            trials = [step for step in shown if step.trial and step.trial.task == task]
            colours = [
                PRACTICE if s.trial and s.trial.phase == "practice" else MAIN for s in trials
            ]
            places, levels = range(1, len(trials) + 1), [s.surface.level for s in trials]
            width_pt = min(6.0, 300.0 / len(tasks) / len(trials))
            axis.vlines(places, 0, levels, color=colours, linewidth=width_pt)
            axis.set(title=tasks[task], xlabel="trial", xticks=[1, len(trials)])
            axis.spines[["top", "right"]].set_visible(False)
        quantity = study.quantity
        axes[0].set_ylabel(f"{quantity.title} ({quantity.unit_in_short})")
        axes[0].set_ylim(bottom=0)
        file = io.StringIO()
        drawn.savefig(file, format="svg", transparent=True, metadata={"Date": None})
    return file.getvalue()
