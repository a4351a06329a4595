"""The page on how to cite Slipscale, generated from ``CITATION.cff``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

CITATION = Path(__file__).parents[2] / "CITATION.cff"


def pages() -> dict[str, str]:
    """Return the page."""
    return {"cite.md": page(yaml.safe_load(CITATION.read_text(encoding="utf-8")))}


def page(cited: dict[str, Any]) -> str:
    """Return the page's text: sentences for a paper, and BibTeX entries."""
    (paper,) = cited["references"]
    authors = ", ".join(
        f"{each['given-names'][0]}. {each['family-names']}" for each in paper["authors"]
    )
    by = " and ".join(each["name"] for each in cited["authors"])
    article = {
        "author": " and ".join(
            f"{each['family-names']}, {each['given-names']}" for each in paper["authors"]
        ),
        "title": f"{{{paper['title']}}}",
        "journal": paper["journal"],
        "volume": paper["volume"],
        "number": paper["issue"],
        "pages": f"{paper['start']}--{paper['end']}",
        "year": paper["year"],
        "doi": paper["doi"],
    }
    software = {
        "author": f"{{{by}}}",
        "title": f"{{{cited['title']}}}",
        "version": cited["version"],
    }
    return f"""# Cite Slipscale

Cite the software with the version that collected or analysed your data, and the paper whose
experiment it reproduces:

> {by}. *{cited["title"]}*, version {cited["version"]}.

> {authors}. {paper["title"]}. *{paper["journal"]}* {paper["volume"]}({paper["issue"]}),
> {paper["start"]}–{paper["end"]}, {paper["year"]}. doi:{paper["doi"]}

```bibtex
{_entry("software", "slipscale", software)}

{_entry("article", "biet2007", article)}
```

Each sidecar, journal and report contains the version. `slipscale export` writes a methods section
with the references for the statistics that were used (`methods.md`, `references.bib`).
"""


def _entry(kind: str, key: str, fields: dict[str, object]) -> str:
    lines = [f"  {name} = {{{value}}}," for name, value in fields.items()]
    return "\n".join([f"@{kind}{{{key},", *lines, "}"])
