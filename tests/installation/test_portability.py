"""Modules are imported on Windows too, where Python has no terminals, users or file control."""

import json
import subprocess
import sys

#: Modules that only POSIX systems can import, and why; every other imports everywhere.
POSIX_ONLY = {
    "slipscale.hardware.contact.emulated_line": "sends positions through a pseudo-terminal",
    "slipscale.hardware.emulator.pty": "is the pseudo-terminal of an emulated board",
}

# Hides them from our modules only: the standard library and packages have branches of their own.
IMPORT_ALL = """
import builtins, importlib, json, pkgutil, sys
import slipscale

hidden = {"fcntl", "grp", "pty", "pwd", "resource", "termios", "tty"}
real = builtins.__import__


def without_posix(name, globals=None, *rest, **named):
    importer = (globals or {}).get("__name__", "")
    if name.partition(".")[0] in hidden and importer.startswith("slipscale"):
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    return real(name, globals, *rest, **named)


builtins.__import__ = without_posix
imported, failed = [], {}
# Scripts that are started, not imported: each reads its own folder.
started = ("slipscale.__main__", "slipscale.analysis.export.scripts")
for module in pkgutil.walk_packages(slipscale.__path__, "slipscale."):
    if module.name.startswith(started):
        continue
    try:
        importlib.import_module(module.name)
        imported.append(module.name)
    except ImportError as fault:
        failed[module.name] = fault.name
json.dump([imported, failed], sys.stdout)
"""


def test_all_but_the_named_modules_are_imported_without_what_only_posix_systems_have():
    done = subprocess.run(
        [sys.executable, "-c", IMPORT_ALL], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    imported, failed = json.loads(done.stdout)
    assert len(imported) > 400
    assert failed == dict.fromkeys(POSIX_ONLY, "tty")
