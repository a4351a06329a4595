"""The library of ``make disk``: the chosen call fails, and those after it as ordered."""

import errno
import os
import shutil
import subprocess
import sys

import pytest

from tools.campaigns.torture import failing_writes

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux") or not shutil.which("gcc"),
    reason="a library for Linux, which gcc compiles",
)
#: Creates, writes and renames a file; prints the number of calls, or the error's number.
PROGRAM = """
import ctypes, os, sys
library, (folder, at, error, calls) = ctypes.CDLL(None), sys.argv[1:]
library.fail_at(folder.encode(), ctypes.c_long(int(at)), int(error), ctypes.c_long(int(calls)))
for turn in range(2):
    try:
        with open(f"{folder}/a", "wb", buffering=0) as file:
            file.write(b"1234")
        os.rename(f"{folder}/a", f"{folder}/b")
        print("done", library.calls_made())
    except OSError as failed:
        print("failed", failed.errno)
"""


@pytest.mark.parametrize(
    "at, calls, said",
    [
        (-1, 0, ["done 3", "done 6"]),
        (0, failing_writes.ONCE, ["failed 28", "done 4"]),
        (1, failing_writes.ONCE, ["failed 28", "done 5"]),
        (2, failing_writes.ALWAYS, ["failed 28", "failed 28"]),
    ],
)
def test_the_chosen_call_fails(tmp_path, at, calls, said):
    env = {**os.environ, "LD_PRELOAD": str(failing_writes.library(tmp_path))}
    below = tmp_path / "data"
    below.mkdir()
    words = [str(below), str(at), str(errno.ENOSPC), str(calls)]
    command = [sys.executable, "-c", PROGRAM, *words]
    found = subprocess.check_output(command, env=env, text=True)
    assert found.splitlines() == said
    if at == 1:
        assert (below / "b").read_bytes() == b"1234"
