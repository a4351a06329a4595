"""The gallery of studies: each shipped study file, and what a participant experiences."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

from slipscale.experiments.protocols.steps import Present
from slipscale.experiments.running.rehearsal import dry_run
from slipscale.experiments.running.study_commands import show
from slipscale.experiments.study.file import read_study, shipped_studies
from slipscale.experiments.study.run_plan import RunPlan
from tools.site.tables import code, table

if TYPE_CHECKING:
    from slipscale.experiments.study.model import Study

INTRODUCTION = """# Studies

These studies come with Slipscale. `slipscale pilot NAME` runs a study with simulated
participants. To write your own study, start with `slipscale study new mine.toml`, and see
[all study-file keys](../reference/study-file.md).
"""
PRACTICE, MAIN = "#9aa5a4", "#00796b"


def pages() -> dict[str, str]:
    """Return one page and one figure per study, and the index."""
    made: dict[str, str] = {}
    rows = []
    for name in shipped_studies():
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
    return {"studies/index.md": f"{INTRODUCTION}\n{table(header, rows)}\n", **made}


def page(name: str, study: Study, text: str) -> str:
    """Return a study's page: its texts, its trials and its file."""
    comment = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        comment.append(line.removeprefix("#").strip())
    return f"""# {study.title}

{" ".join(comment)}

```sh
slipscale pilot {name}
slipscale study show {name} --participant 01
```

## The trials of participant 01

![Level of each trial, in the order of presentation]({name}.svg)

Grey: practice. Each participant has a different order; the same seed gives the same orders on every
machine.

```text
{show(name, "01")}
```

## The file

```toml
{text.strip()}
```
"""


def figure(name: str, study: Study, text: str) -> str:
    """Return an SVG of the levels of participant 01's trials, task by task."""
    import matplotlib as mpl  # noqa: PLC0415 - takes a second to import, only when drawn
    from matplotlib.figure import Figure  # noqa: PLC0415

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
        drawn = Figure(figsize=(7.0, 2.2), layout="constrained")
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
