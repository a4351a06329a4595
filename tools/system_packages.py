"""Install the system packages that a PsychoPy window needs, or print the line that does.

Standard library only. Exits 0 when all are there, 1 when some are missing and could not be
installed. With --optional only the window's own are installed, and what is missing is said and
forgiven: a pilot opens no window.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

# OpenGL, fonts, sound: what the participant's window needs.
WINDOW = ("libgl1", "libglu1-mesa", "libfontconfig1", "libportaudio2")
# A virtual screen, its keyboard and key presses; compilers for the reference firmware, for this
# computer and for Arduino boards.
TESTS = (
    *("xvfb", "xauth", "x11-xkb-utils", "xdotool", "g++"),
    *("gcc-avr", "avr-libc", "arduino-core-avr"),
)


def missing(packages: tuple[str, ...]) -> list[str]:
    """Return the packages that dpkg does not report as installed."""
    query = ["dpkg-query", "--show", "--showformat=${Package} ${db:Status-Status}\n", *packages]
    answer = subprocess.run(query, capture_output=True, text=True, check=False).stdout
    there = {line.split()[0] for line in answer.splitlines() if line.endswith(" installed")}
    return [name for name in packages if name not in there]


def privilege() -> list[str] | None:
    """Return the prefix that makes a command run as root, or None where there is none."""
    if os.geteuid() == 0:
        return []
    if (
        shutil.which("sudo")
        and not subprocess.run(["sudo", "-n", "true"], capture_output=True, check=False).returncode
    ):
        return ["sudo", "-n"]
    return None


def main() -> int:
    """Install what is missing; return the exit status."""
    optional = "--optional" in sys.argv[1:]
    if not sys.platform.startswith("linux"):
        return 0  # macOS and Windows bring GL and sound; their window needs no Xvfb
    packages = WINDOW if optional else WINDOW + TESTS
    if not shutil.which("apt-get"):
        print(f"Not a Debian or Ubuntu: please install the equivalents of {' '.join(packages)}.")
        return 0
    wanted = missing(packages)
    if not wanted:
        return 0
    line = f"apt-get install -y {' '.join(wanted)}"
    prefix = privilege()
    if prefix is not None:
        print(f"Installing system packages: {' '.join(wanted)} ...", flush=True)
        environment = [*prefix, "env", "DEBIAN_FRONTEND=noninteractive"]
        for command in ("apt-get update -qq", f"apt-get install -y -qq {' '.join(wanted)}"):
            subprocess.run([*environment, *command.split()], stdout=subprocess.DEVNULL, check=False)
        if not missing(packages):
            return 0
    print(f"A PsychoPy window needs system packages. Please run:\n  sudo {line}", file=sys.stderr)
    return 0 if optional else 1


if __name__ == "__main__":
    sys.exit(main())
