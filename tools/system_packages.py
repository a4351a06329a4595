"""Install the system packages that Slipscale requires, or print the command that does.

Uses only the standard library. The exit status is 0 if all packages are present, and 1 if some are
missing and could not be installed. With --optional, only the packages of the participant's window
are installed, and a missing one is reported but is not an error, because a pilot opens no window.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence

INSTALL = ("apt-get", "install", "-y", "--no-install-recommends")
# Requirements of the participant's window: OpenGL, fonts, sound.
WINDOW = ("libgl1", "libglu1-mesa", "libfontconfig1", "libportaudio2")
# Additional packages that the tests require.
TESTS = (
    *("xvfb", "xauth", "x11-xkb-utils", "xdotool"),  # virtual screen and key presses
    *("gcc", "g++", "gcc-avr", "avr-libc", "arduino-core-avr"),  # the reference firmware
    *("libpango-1.0-0", "libpangoft2-1.0-0", "libharfbuzz-subset0"),  # reports as PDF
    *("r-base-core", "r-cran-lme4"),  # scripts that recompute a report in R
    *("chromium", "openssl"),  # the laboratory console, also encrypted
    *("libegl1", "libdbus-1-3", "libxkbcommon0"),  # PsychoPy Builder; Pango installs GLib
)


def missing(packages: Sequence[str]) -> list[str]:
    """Return the packages that dpkg does not report as installed."""
    query = ["dpkg-query", "--show", "--showformat=${Package} ${db:Status-Status}\n", *packages]
    answer = subprocess.run(query, capture_output=True, text=True, check=False).stdout
    there = {line.split()[0] for line in answer.splitlines() if line.endswith(" installed")}
    return [name for name in packages if name not in there]


def offered(packages: Sequence[str]) -> list[str]:
    """Return the packages that apt can install; Ubuntu, for example, has no Chromium package."""
    known = [name for name in packages if not _quietly(["apt-cache", "show", name])]
    if others := [name for name in packages if name not in known]:
        print(f"apt offers no {', '.join(others)}: tests that need it are skipped.", flush=True)
    return known


def _quietly(command: list[str]) -> int:
    return subprocess.run(command, stdout=subprocess.DEVNULL, check=False).returncode


def privilege() -> list[str] | None:
    """Return the prefix that makes a command run as root, or None if there is none."""
    if os.geteuid() == 0:
        return []
    if shutil.which("sudo") and not _quietly(["sudo", "-n", "true"]):
        return ["sudo", "-n"]
    return None


def main() -> int:
    """Install missing packages; return the exit status."""
    optional = "--optional" in sys.argv[1:]
    if not sys.platform.startswith("linux"):
        return 0  # macOS and Windows include GL and sound; no Xvfb is required
    packages = WINDOW if optional else WINDOW + TESTS
    if not shutil.which("apt-get"):
        print(f"Not a Debian or Ubuntu: please install the equivalents of {' '.join(packages)}.")
        return 0
    wanted = missing(packages)
    if not wanted:
        return 0
    prefix = privilege()
    if prefix is not None:
        print(f"Installing system packages: {' '.join(wanted)} ...", flush=True)
        # A new machine may still be installing updates.
        options = ["-qq", "-o", "DPkg::Lock::Timeout=300"]
        _quietly([*prefix, "apt-get", "update", *options])
        wanted = offered(wanted)
        _quietly([*prefix, "env", "DEBIAN_FRONTEND=noninteractive", *INSTALL, *options, *wanted])
        wanted = missing(wanted)
        if not wanted:
            return 0
    purpose = "A PsychoPy window needs" if optional else "The tests need"
    line = " ".join(("sudo", *INSTALL, *wanted))
    print(f"{purpose} system packages. Please run:\n  {line}", file=sys.stderr)
    return 0 if optional else 1


if __name__ == "__main__":
    sys.exit(main())
