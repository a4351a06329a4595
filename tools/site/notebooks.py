"""Notebooks of ``docs/`` as pages of the site, with their stored outputs."""

from __future__ import annotations

from tools.notebooks import DOCS, Notebook, read

#: Markdown for each MIME type; the first type that an output has is shown.
SHOWN = {
    "text/html": '<div style="overflow-x: auto">{}</div>',
    "image/svg+xml": '<div style="overflow-x: auto">{}</div>',
    "text/plain": "```text\n{}\n```",
}


def pages() -> dict[str, str]:
    """Return the page of each notebook, keyed by path."""
    return {
        str(path.relative_to(DOCS).with_suffix(".md")): page(read(path))
        for path in sorted(DOCS.rglob("*.ipynb"))
    }


def page(notebook: Notebook) -> str:
    """Return a notebook as Markdown.

    >>> outputs = [{"data": {"text/plain": "2"}}]
    >>> code = {"cell_type": "code", "source": ["1 + 1"], "outputs": outputs}
    >>> print(page({"cells": [{"cell_type": "markdown", "source": ["# Two"]}, code]}))
    # Two
    <BLANKLINE>
    ```python
    1 + 1
    ```
    <BLANKLINE>
    ```text
    2
    ```
    <BLANKLINE>
    """
    blocks = []
    for cell in notebook["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            blocks.append(source)
            continue
        blocks.append(f"```python\n{source}\n```")
        blocks += map(_output, cell["outputs"])
    return "\n\n".join(blocks) + "\n"


def _output(output: Notebook) -> str:
    data = output.get("data") or {"text/plain": output["text"]}
    form = next(form for form in SHOWN if form in data)
    text = "".join(data[form]).rstrip("\n")
    if form != "text/plain":
        # An empty line would end the element in Markdown.
        text = "\n".join(line for line in text.splitlines() if line.strip())
    return SHOWN[form].format(text)
