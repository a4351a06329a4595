"""Try the wheel in a new environment, away from this repository: ``make wheel``.

Builds the wheel, installs it with the pinned packages of a session (``slipscale setup session``,
which asks a package index), and runs in an empty folder what a laboratory runs: a pilot, a session
in a window on a virtual screen, its analysis and an export. Requires Xvfb and xdotool.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from tools import setup
from tools.campaigns.windows import STUDY, display

KEYS = ("space", "5", "Return", "1")  # one of them answers any screen of the study
PATIENCE_S = 600.0
LOOK_S = 0.2
#: Commands after the session, with a file that each must have written.
AFTER = (
    (("data", "verify", "data"), "data/participants.tsv"),
    (("analyse", "data"), "data/derivatives/slipscale/report.html"),
    (("export", "data", "--out", "export", "--forms", "word", "scripts", "methods", "spss"),
     "export/report.docx"),
)  # fmt: skip


def install(folder: Path) -> Path:
    """Build the wheel and install it in a new environment; return the environment's Python."""
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=setup.ROOT, check=True, stdout=subprocess.DEVNULL)
    (wheel,) = folder.glob("*.whl")
    subprocess.run([sys.executable, "-m", "venv", str(folder / "venv")], check=True)
    python = setup.python_in(folder / "venv")
    subprocess.run([python, "-m", "pip", "install", "--quiet", str(wheel)], check=True)
    slipscale(python, folder, "setup", "session", "--run")
    return python


def slipscale(python: Path, folder: Path, *words: str) -> None:
    """Run a command in a folder. Raises `subprocess.CalledProcessError`."""
    print("slipscale", *words, flush=True)
    subprocess.run(
        [python, "-P", "-m", "slipscale", *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": ""},
        stdout=subprocess.DEVNULL,
        check=True,
    )


def session(python: Path, folder: Path) -> None:
    """Run a participant's session in a window, and type until it ends."""
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    words = ["run", "study.toml", "--participant", "01", "--plate", "mock", "--windowed", "--pilot"]
    words += ["--out", "data"]
    print("slipscale", *words, flush=True)
    with display():
        process = subprocess.Popen(
            [python, "-P", "-m", "slipscale", *words],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": "", "HOME": str(folder)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
        )
        end_s = time.monotonic() + PATIENCE_S
        for key in typed():
            if process.poll() is not None or time.monotonic() > end_s:
                break
            subprocess.run(["xdotool", "key", key], check=True)
            time.sleep(LOOK_S)
        if process.poll() is None:
            process.kill()
        if process.wait():
            raise subprocess.CalledProcessError(process.returncode, words)


def use(python: Path, folder: Path) -> None:
    """Run what a laboratory runs. Raises an error if a command fails or writes no results."""
    folder.mkdir()
    slipscale(python, folder, "pilot", "--participants", "4", "--seed", "1", "--out", "pilot")
    session(python, folder)
    for words, file in AFTER:
        slipscale(python, folder, *words)
        if not (folder / file).is_file():
            raise FileNotFoundError(file)


def typed() -> Iterator[str]:
    """Yield keys in turn, without end."""
    while True:
        yield from KEYS


def main() -> int:
    """Try the wheel; return the exit status."""
    if missing := [name for name in ("Xvfb", "xdotool") if not shutil.which(name)]:
        print(f"not installed: {', '.join(missing)}", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory(prefix="slipscale-wheel-") as made:
        folder = Path(made)
        try:
            use(install(folder), folder / "work")
        except (subprocess.CalledProcessError, FileNotFoundError) as error:
            print(f"failed: {error}", file=sys.stderr)
            return 1
    print("the wheel works: pilot, session, analysis and export")
    return 0


if __name__ == "__main__":
    sys.exit(main())
