"""Regenerate the pictures of docs/how-to/planning.md by running the page's commands in order.

Usage: python tools/planning_pictures.py [--only WORD ...]

The picture ``A-B.svg`` in docs/images/planning is a copy of ``plan/A/B.svg``, which a command
writes; the picture ``A.svg`` is a copy of ``A.svg``. With ``--only``, only commands that contain
one of the words are run. This takes some minutes.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "how-to" / "planning.md"
PICTURES = ROOT / "docs" / "images" / "planning"
MOST_BYTES = 150_000


def commands(page: str) -> list[list[str]]:
    """Return the commands of the page's `sh` blocks in order, each as a list of words."""
    blocks = re.findall(r"^```sh\n(.*?)^```", page, flags=re.MULTILINE | re.DOTALL)
    return [shlex.split(line, comments=True) for block in blocks for line in block.splitlines()]


def pictures(page: str) -> list[str]:
    """Return the names of the page's pictures without their folder."""
    return sorted(set(re.findall(r"\]\(\.\./images/planning/([\w-]+\.svg)\)", page)))


def study_file(page: str, begun: str) -> str:
    """Return the page's study: the initial file with the page's additions."""
    added = re.search(r"^```toml\n(.*?)^```", page, flags=re.MULTILINE | re.DOTALL)
    if not added:
        raise ValueError(f"{PAGE}: no TOML block to add to the study")
    return f"{begun}\n{added[1]}"


def made(folder: Path, picture: str) -> Path:
    """Return the file from which a picture is copied."""
    where, _, name = picture.partition("-")
    return folder / "plan" / where / name if name else folder / picture


def main() -> None:
    """Run the page's commands, and copy the pictures that they produce."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", default=[], metavar="WORD")
    wanted = parser.parse_args().only
    page = PAGE.read_text(encoding="utf-8")
    PICTURES.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as there:
        folder = Path(there)
        slipscale = Path(sys.executable).parent / "slipscale"
        for words in commands(page):
            first = words[1:3] == ["study", "new"]
            if wanted and not first and not any(word in " ".join(words) for word in wanted):
                continue
            print(shlex.join(words), flush=True)
            environment = os.environ | {"OMP_NUM_THREADS": "1"}
            done = subprocess.run([slipscale, *words[1:]], cwd=folder, env=environment, check=False)
            if done.returncode not in {0, 1}:  # 1: no sample size was sufficient
                raise SystemExit(done.returncode)
            if first:
                file = folder / words[3]
                file.write_text(study_file(page, file.read_text("utf-8")), encoding="utf-8")
        for picture in pictures(page):
            source = made(folder, picture)
            if source.exists():
                shutil.copyfile(source, PICTURES / picture)
                size = source.stat().st_size
                print(f"{picture}: {size:,} bytes{' TOO LARGE' if size > MOST_BYTES else ''}")


if __name__ == "__main__":
    main()
