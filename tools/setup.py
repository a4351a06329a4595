"""Build the environment in .venv with only Python and pip: `setup.py pilot|session|test`.

Each set of packages contains the previous one, so .venv grows from one to the next. This program
runs before anything is installed and therefore uses only the standard library.
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
BOOTSTRAP = ROOT / ".setup"
#: A link that git may check out as a text file; the installation then replaces it.
LINK = ROOT / "src" / "slipscale" / "analysis"
OLDEST = (3, 11)
#: Newest Python (PsychoPy has no release for 3.13), and size and set-up time of each set.
SETS = {
    "pilot": ((3, 13), "450 MB, half a minute"),
    "session": ((3, 12), "650 MB, a minute"),
    "test": ((3, 12), "1.2 GB, a minute or two"),
}


def pins(name: str) -> str:
    """Return the path of a set's list of pinned packages, relative to the project's root."""
    return f"requirements/{name}.txt"


def stamp(name: str) -> Path:
    """Return the file that stores the fingerprint of an installed set of packages."""
    return VENV / f"ready-{name}"


def fingerprint(name: str) -> str:
    """Return a digest of everything that determines a set's environment."""
    digest = hashlib.sha256(sys.version.encode())
    for path in ("pyproject.toml", pins(name), "tools/setup.py", "src/slipscale/__init__.py"):
        digest.update((ROOT / path).read_bytes())
    return digest.hexdigest()


def is_ready(name: str) -> bool:
    """Return whether .venv contains this or a larger set of packages, with the current pins."""
    larger = list(SETS)[list(SETS).index(name) :]
    return LINK.is_dir() and any(
        stamp(each).exists() and stamp(each).read_text() == fingerprint(each) for each in larger
    )


def python_in(venv: Path) -> Path:
    """Return the interpreter inside a virtual environment."""
    return venv / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def find_uv() -> str | None:
    """Return a uv to install with: the user's own, or one installed with pip in .setup."""
    present = shutil.which("uv")
    if present:
        return present
    own = BOOTSTRAP / "bin" / ("uv.exe" if os.name == "nt" else "uv")
    if not own.exists():
        # pip's --target works even if Python is externally managed and has no venv module.
        command = [sys.executable, "-m", "pip", "install", "--quiet", "--target", str(BOOTSTRAP)]
        if subprocess.run([*command, "uv"], check=False).returncode:
            return None
    return str(own) if own.exists() else None


def install(name: str, uv: str | None) -> bool:
    """Create .venv and install a set of packages with uv or pip; return whether this succeeded."""
    python = str(python_in(VENV))
    if uv:
        venv = [uv, "venv", "--quiet", "--allow-existing", "--python", sys.executable, str(VENV)]
        pip = [uv, "pip", "install", "--quiet", "--python", python]
    else:
        venv = [sys.executable, "-m", "venv", str(VENV)]
        pip = [python, "-m", "pip", "install", "--quiet", "--no-compile"]
    # The pins are complete, except for packages that PsychoPy requires but Slipscale never imports.
    # The installer must not add these dependencies.
    pip.append("--no-deps")
    steps = (venv, [*pip, "-r", pins(name)], [*pip, "-e", "."])
    return all(subprocess.run(step, cwd=ROOT, check=False).returncode == 0 for step in steps)


def main(name: str = "session") -> int:
    """Build or refresh the environment; return the exit status."""
    if name not in SETS:
        print(f"{name!r} is not a set; expected one of: {', '.join(SETS)}.", file=sys.stderr)
        return 1
    newest, size = SETS[name]
    if not OLDEST <= sys.version_info[:2] <= newest:
        print(
            f"The {name} environment requires Python 3.{OLDEST[1]} to 3.{newest[1]}; "
            f"this is {sys.version.split()[0]}. Choose another: make PYTHON=python3.12",
            file=sys.stderr,
        )
        return 1
    if is_ready(name):
        return 0
    print(f"Setting up the {name} environment in .venv (once; {size}) ...", flush=True)
    uv = find_uv()
    if not (uv and install(name, uv)) and not install(name, None):
        print(
            "Set-up failed; the installer's own message is above. Behind a proxy, set HTTPS_PROXY. "
            "If Python has no venv module, install it (Debian: apt-get install python3-venv).",
            file=sys.stderr,
        )
        return 1
    stamp(name).write_text(fingerprint(name))
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
