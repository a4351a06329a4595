"""Replace links in ``src/slipscale`` that git could not check out, for an editable installation.

The repository keeps ``analysis``, ``experiments`` and the other subpackages at its top level, and
links to them in ``src/slipscale``, so that a clone can be imported without installation. Where git
checks out links as text files (Windows), this hook replaces them with junctions, which require no
special privileges. A wheel needs no links, because `pyproject.toml` maps the folders into the
package.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from hatchling.builders.config import BuilderConfig
from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PACKAGE = Path("src", "slipscale")


class LinkFolders(BuildHookInterface[BuilderConfig]):
    """Make the link to each folder that the wheel maps into the package."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002
        """Create missing links, for an editable installation only."""
        if version != "editable":
            return
        root = Path(self.root)
        for source, target in self.build_config.sources.items():
            folder, link = root / source, root / "src" / target
            if folder != root / PACKAGE and not link.is_dir():
                link_folder(link, folder)


def link_folder(link: Path, folder: Path) -> None:
    """Make ``link`` point to ``folder``, in place of the text file that git left there."""
    link.unlink(missing_ok=True)
    if sys.platform == "win32":
        from _winapi import CreateJunction

        CreateJunction(str(folder), str(link))
    else:
        link.symlink_to(Path("..", "..", folder.name), target_is_directory=True)
