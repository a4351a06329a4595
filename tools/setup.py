"""Build the environment in .venv, from nothing but Python and pip.

Standard library only: this is the program that runs before anything is installed.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
STAMP = VENV / "ready"
BOOTSTRAP = ROOT / ".setup"
INPUTS = ("pyproject.toml", "requirements.txt", "tools/setup.py", "src/slipscale/__init__.py")
#: A link that the editable installation makes; without it nothing can be imported.
LINK = ROOT / "src" / "slipscale" / "analysis"
OLDEST, NEWEST = (3, 11), (3, 13)


def fingerprint() -> str:
    """Return a digest of all that decides what the environment holds."""
    digest = hashlib.sha256(sys.version.encode())
    for name in INPUTS:
        digest.update((ROOT / name).read_bytes())
    return digest.hexdigest()


def python_in(venv: Path) -> Path:
    """Return the interpreter inside a virtual environment."""
    return venv / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def find_uv() -> str | None:
    """Return a uv to install with: the user's own, or one that pip puts in .setup."""
    present = shutil.which("uv")
    if present:
        return present
    own = BOOTSTRAP / "bin" / ("uv.exe" if os.name == "nt" else "uv")
    if not own.exists():
        # --target works where the system's Python is externally managed and has no venv module.
        command = [sys.executable, "-m", "pip", "install", "--quiet", "--target", str(BOOTSTRAP)]
        if subprocess.run([*command, "uv"], check=False).returncode:
            return None
    return str(own) if own.exists() else None


def install_with_uv(uv: str) -> bool:
    """Create .venv and fill it with uv; return whether that worked."""
    venv = [uv, "venv", "--quiet", "--allow-existing", "--python", sys.executable, str(VENV)]
    pip = [uv, "pip", "install", "--quiet", "--python", str(python_in(VENV))]
    if sys.dont_write_bytecode:
        # Python would compile PsychoPy and pandas anew at every start: once is enough.
        pip.append("--compile-bytecode")
    steps = (venv, [*pip, "-r", "requirements.txt"], [*pip, "--no-deps", "-e", "."])
    return all(subprocess.run(step, cwd=ROOT, check=False).returncode == 0 for step in steps)


def install_with_pip() -> bool:
    """Create .venv and fill it with pip, for places where uv cannot go; return success."""
    pip = [str(python_in(VENV)), "-m", "pip", "install", "--quiet"]
    steps = (
        [sys.executable, "-m", "venv", str(VENV)],
        [*pip, "-r", "requirements.txt"],
        [*pip, "--no-deps", "-e", "."],
    )
    return all(subprocess.run(step, cwd=ROOT, check=False).returncode == 0 for step in steps)


def main() -> int:
    """Build or refresh the environment; return the exit status."""
    if not OLDEST <= sys.version_info[:2] <= NEWEST:
        print(
            f"Slipscale needs Python 3.{OLDEST[1]} to 3.{NEWEST[1]}; "
            f"this is {sys.version.split()[0]}. Name another with: make setup PYTHON=python3.12",
            file=sys.stderr,
        )
        return 1
    if LINK.exists() and STAMP.exists() and STAMP.read_text() == fingerprint():
        return 0
    print("Setting up Slipscale in .venv (once; some 2 GB, a minute or two) ...", flush=True)
    uv = find_uv()
    if not (uv and install_with_uv(uv)) and not install_with_pip():
        print(
            "Set-up failed; the installer's own message is above. Behind a proxy, set HTTPS_PROXY. "
            "Without the venv module, install it (Debian: apt-get install python3-venv).",
            file=sys.stderr,
        )
        return 1
    STAMP.write_text(fingerprint())
    return 0


if __name__ == "__main__":
    sys.exit(main())
