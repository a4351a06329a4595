"""A terminal that lacks characters, is full or is closed stops no command."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

COMMAND = "import slipscale.commands as c, sys; c._answer = lambda _: work(); sys.exit(c.main())"


def run(work, tmp_path, **options):
    """Run a process whose command does `work`, given as text, and then makes the file "done"."""
    code = f"def work():\n{work}\n    open('done', 'w').close()\n    return 0\n{COMMAND}"
    given = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    return subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, check=False, timeout=120, **given
    )


PRINT = "    for n in range(20000): print('\u2713 \u00b5m', n, flush=not n % 999)"


def test_characters_that_the_terminal_lacks_are_replaced(tmp_path):
    env = os.environ | {"PYTHONIOENCODING": "latin-1"}
    found = run("    print('\u2713 \u00b5m')", tmp_path, env=env)
    assert (found.returncode, found.stdout) == (0, b"? \xb5m\n")


def test_a_reader_that_has_enough_stops_nothing(tmp_path):
    read, write = os.pipe()
    os.close(read)
    found = run(PRINT, tmp_path, stdout=write)
    os.close(write)
    assert (found.returncode, found.stderr) == (0, b"")
    assert (tmp_path / "done").exists()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_a_full_disk_behind_the_output_stops_nothing(tmp_path, stream):
    with Path("/dev/full").open("w") as full:
        run(PRINT, tmp_path, **{stream: full})
    assert (tmp_path / "done").exists()


@pytest.mark.skipif(os.name == "nt", reason="a shell of POSIX closes the stream")
@pytest.mark.parametrize("closed", ["1", "2"])
def test_a_stream_that_is_closed_from_the_beginning_stops_nothing(tmp_path, closed):
    work = "    sys.stdout.flush(); print('a'); print('b', file=sys.stderr, flush=True)"
    code = f"def work():\n{work}\n    open('done', 'w').close()\n    return 0\n{COMMAND}"
    done = subprocess.run(
        ["sh", "-c", f'exec "$0" -c "$1" {closed}>&-', sys.executable, code],
        cwd=tmp_path,
        check=False,
    )
    assert done.returncode == 0
    assert (tmp_path / "done").exists()


def test_lost_output_is_said_with_a_status():
    with Path("/dev/full").open("w") as full:
        found = subprocess.run(
            [sys.executable, "-m", "slipscale", "--help"],
            stdout=full,
            stderr=subprocess.PIPE,
            check=False,
            timeout=120,
        )
    assert found.returncode == 1
    assert b"the output could not be written (No space left on device)" in found.stderr


def test_closed_streams_are_no_error(tmp_path):
    command = [sys.executable, "-m", "slipscale", "--version"]
    assert (
        subprocess.run(["sh", "-c", '"$@" >&- 2>&-', "sh", *command], check=False).returncode == 0
    )


def test_a_name_that_is_not_utf_8_is_one_sentence(tmp_path):
    found = subprocess.run(
        [sys.executable, "-m", "slipscale", "pilot", os.fsdecode(b"st\xe4.toml")],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        check=False,
        timeout=120,
    )
    assert found.returncode == 2
    assert found.stderr.endswith(
        b"the name is not UTF-8; rename the file, then repeat the command\n"
    )
    assert b"Traceback" not in found.stderr
