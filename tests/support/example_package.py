"""An example of docs/extending, built into a wheel and installed in its own folder."""

import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

EXTENDING = Path(__file__).parents[2] / "docs" / "extending"
SLIPSCALE = Path(sys.executable).with_name("slipscale")
# Commands, one after another in one process: most of a short one's time is its imports.
COMMANDS = """
import shlex, sys
from slipscale.commands import main
sys.exit(max([main(shlex.split(line)) for line in sys.argv[1:]]))
"""
PATIENCE_S = 60


class ExamplePackage:
    """An example's files, and the installed package in ``site``.

    Parameters
    ----------
    name : str
        Name of the example's folder.
    folder : Path
        An empty folder.
    """

    def __init__(self, name, folder):
        self.folder, self.site = folder, folder / "site"
        for file in (EXTENDING / name).glob("*.*"):
            shutil.copy(file, folder)
        build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", "dist"]
        subprocess.run(build, cwd=folder, check=True, capture_output=True)
        (wheel,) = (folder / "dist").glob("*.whl")
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(self.site)
        # What is imported is what was installed, not the file that lies beside it.
        for module in folder.glob("*.py"):
            module.unlink()

    def run(self, program, *words):
        """Run a Python program with the package installed; return its output."""
        done = subprocess.run(
            [sys.executable, "-c", program, *words],
            cwd=self.folder,
            env=self._environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    def kill_pilot(self, journal, *words):
        """Kill a pilot in the middle of the run whose journal is named."""
        pilot = subprocess.Popen(
            [SLIPSCALE, "pilot", *words],
            cwd=self.folder,
            env=self._environment,
            stdout=subprocess.DEVNULL,
        )
        deadline = time.monotonic() + PATIENCE_S
        while not (journal.exists() and journal.stat().st_size > 30_000):
            assert time.monotonic() < deadline
            assert pilot.poll() is None, "it ended before it was killed"
            time.sleep(0.001)
        pilot.send_signal(signal.SIGKILL)
        pilot.wait()
        assert '"kind":"end"' not in journal.read_text()

    @property
    def _environment(self):
        return {**os.environ, "PYTHONPATH": str(self.site), "COLUMNS": "200"}


def tables(folder):
    """Return the tables and sidecars of a data set's participants."""
    return {
        path.name: path.read_bytes()
        for path in sorted(folder.glob("sub-*/beh/*"))
        if path.suffix in (".tsv", ".json")
    }
