"""The reference of the public Python names: one page per public module, by mkdocstrings."""

from __future__ import annotations

import slipscale
from tools.site.tables import table

#: Public modules, each with its purpose.
PUBLIC = {
    "slipscale": "read, analyse, simulate and plan in scripts and notebooks",
    "slipscale.protocol": "protocols and simulated people in a package",
    "slipscale.question": "kinds of questions in a package",
    "slipscale.backend": "drivers for other plates in a package",
    "slipscale.task": "analyses in a package",
    "slipscale.experiments.psychopy_plate": "the plate in PsychoPy Coder",
}
INTRODUCTION = """# Python API

These modules are public; [Plug-ins](../../extending/plug-ins.md#what-stays-stable) describes what
that promises. For an example, see [the analysis in Python](../../how-to/in-python.md).
"""


def pages() -> dict[str, str]:
    """Return one page per public module, and the index."""
    made = {f"reference/python/{name}.md": page(name) for name in PUBLIC}
    rows = [[f"[{name}]({name}.md)", purpose] for name, purpose in PUBLIC.items()]
    index = f"{INTRODUCTION}\n{table(['module', 'for'], rows)}\n"
    return {"reference/python/index.md": index, **made}


def page(name: str) -> str:
    """Return the page of a module: each public name, as it is imported."""
    title = f"# {name}\n\n{PUBLIC[name].capitalize()}.\n\n"
    return title + "\n\n".join(
        f"::: {where}\n    options:\n      heading: {shown}\n      toc_label: {shown}\n"
        for where, shown in entries(name)
    )


def entries(name: str) -> list[tuple[str, str]]:
    """Return (identifier, heading) for everything on a module's page."""
    if name == "slipscale":
        return [
            (f"{module}.{function}", f"slipscale.{function}")
            for function, module in slipscale.FUNCTIONS.items()
        ]
    module = __import__(name, fromlist=["__all__"])
    public = getattr(module, "__all__", None)
    return [(name, name)] if public is None else [(f"{name}.{each}", each) for each in public]
