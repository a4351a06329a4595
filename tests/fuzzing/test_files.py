"""Every file that a person may write is used, or rejected with an error message.

`make fuzz` tries 10,000 files of each kind. There, each takes at most 2 s of processor time, and
all of a kind together at most 500 MB of memory.
"""

import os
import sys
import time
from collections import Counter
from contextlib import nullcontext, redirect_stderr, redirect_stdout, suppress
from importlib import import_module
from io import StringIO

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="limits of POSIX")

KINDS = (
    *("study_files", "journals", "data_sets", "tables_by_hand", "calibrations", "plate_files"),
    *("published_tables", "code_books", "laboratory_files", "column_meanings"),
)
FILES = int(os.environ.get("FUZZED_FILES", "40"))
# Number of files without limits of time and memory, because the first ones trigger lazy imports.
WARMING = 40


@pytest.mark.parametrize("name", KINDS)
def test_a_changed_file_is_used_or_rejected_with_a_message(name, tmp_path):
    from tests.fuzzing.bounds import limited_memory, limited_time

    draw = import_module(f"tests.fuzzing.{name}").KIND.prepared(tmp_path)
    counts = Counter()

    def tries(files, limited):
        @settings(
            max_examples=files,
            derandomize=files == WARMING,  # much the same files in every run of `make test`
            suppress_health_check=list(HealthCheck),
            print_blob=True,
        )
        @given(random=st.randoms(use_true_random=False))
        def tried(random):
            case = draw(random)
            silent = redirect_stdout(StringIO()), redirect_stderr(StringIO())
            with silent[0], silent[1], limited():
                counts["used"] += case.use()
            counts["tried"] += 1

        tried()

    tries(WARMING, nullcontext)
    if FILES > WARMING:
        with limited_memory():
            tries(FILES, limited_time)
        # Neither broken beyond all reading nor untouched. Of 40 files, all may be broken by chance.
        assert 0.05 < counts["used"] / counts["tried"] < 0.95


def in_time(use):
    from tests.fuzzing import bounds

    with bounds.limited_time():
        use()


def busy_for(seconds):
    began_s = time.process_time()
    while time.process_time() - began_s < seconds:
        pass


def test_a_file_that_takes_too_long_fails(monkeypatch):
    from tests.fuzzing import bounds

    def use():
        with suppress(Exception):  # what hides errors does not hide this
            busy_for(60)

    monkeypatch.setattr(bounds, "MOST_S", 0.05)
    with pytest.raises(bounds.TooLong):
        in_time(use)


def test_a_file_that_takes_too_long_where_no_signal_arrives_fails_too(monkeypatch):
    from tests.fuzzing import bounds

    monkeypatch.setattr(bounds, "_too_long", lambda *_: None)
    monkeypatch.setattr(bounds, "MOST_S", 0.01)
    with pytest.raises(bounds.TooLong):
        in_time(lambda: busy_for(0.02))


def test_a_file_that_takes_too_much_memory_fails():
    from tests.fuzzing import bounds

    def use():  # as a cache that grows
        with bounds.limited_memory():
            return [bytes(bounds.MOST_BYTES // 50) for _ in range(120)]

    with pytest.raises(MemoryError):
        use()
