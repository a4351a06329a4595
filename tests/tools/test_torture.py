"""The campaign of kills and disk faults, in short (docs/validation/measured/campaigns.md)."""

import shutil
import sys
from contextlib import ExitStack
from dataclasses import replace

import pytest

from slipscale.experiments.dataset import withdrawal
from slipscale.experiments.protocol_parts.registry import protocol_names
from slipscale.experiments.study.file import read_study
from slipscale.hardware.errors import PlateTimeout
from tests.support.emulator_process import EmulatorProcess
from tools.campaigns import soak
from tools.campaigns.__main__ import main
from tools.campaigns.torture import pilots, system_calls, upkeep, writers
from tools.campaigns.torture.disk_faults import FAULTS, Journal

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="kills with POSIX signals")


def test_no_fault_and_no_kill_changes_the_data(capsys):
    assert main(["torture", "--places", "1", "--study", "biet2007"]) == 0
    _, _, _, _, *rows = capsys.readouterr().out.strip().splitlines()
    assert [row.split(" | ")[0] for row in rows] == [
        f"| {fault}"
        for fault in (
            *writers.KINDS,
            *(f"SIGKILL in {command}" for command in upkeep.COMMANDS),
            *FAULTS,
            *(f"SIGKILL {kind}" for kind in system_calls.KINDS),
        )
    ]
    assert all(row.endswith("| 0 |") for row in rows)
    assert all(int(row.split("|")[2]) >= 1 for row in rows)


def test_a_journal_that_loses_an_answer_is_found(monkeypatch):
    """The campaign itself can fail: here the journal takes half a record for a whole one."""
    put = Journal._put

    def careless(journal, line):
        if len(journal.records) == 20:
            line = line[: len(line) // 2] + b"\n"
        put(journal, line)

    plan = pilots.plans_of("biet2007", 1)[0]
    expected, _ = pilots.undisturbed(plan)
    monkeypatch.setattr(Journal, "_put", careless)
    with pilots.folder() as dataset:
        pilots.run_simulated(dataset, plan, "mock")
        assert "line 21: damaged" in pilots.difference(dataset, expected)


def test_two_that_write_at_once_are_found(monkeypatch):
    """The race itself can fail: here a session takes no lock at all."""
    monkeypatch.setattr(writers.locks, "take", lambda _stream, _path: None)
    outcome = pilots.Outcome()
    # In the second round the journal is there, and nobody has to make it first.
    writers.writer_campaign(pilots.plans_of("biet2007", 1)[0], 2, outcome)
    told = [" ".join(map(str, each)) for each in outcome.bad]
    for kind in writers.KINDS:
        assert any(kind in each and "of 4 writers" in each for each in told)


def test_a_label_that_a_withdrawal_leaves_is_found(monkeypatch):
    """The campaign itself can fail: here the fallback folder is forgotten."""
    monkeypatch.setattr(upkeep, "COMMANDS", {"withdraw": upkeep.COMMANDS["withdraw"]})
    monkeypatch.setattr(withdrawal, "_kept_elsewhere", lambda _own: iter(()))
    outcome = pilots.Outcome()
    upkeep.strike_upkeep(1, outcome)
    assert "names sub-01" in outcome.bad[0][1]


@pytest.mark.window
@pytest.mark.skipif(not shutil.which("Xvfb"), reason="needs a virtual display")
def test_signals_and_a_lost_display_end_sessions_in_windows_as_faults_do(capfd):
    words = ["windows", "--signals", "4", "--processes", "1", "--servers", "1"]
    assert main(words) == 0, capfd.readouterr().err
    assert capfd.readouterr().out.strip().endswith("1 processes, 1 servers: 0 bad")


def test_every_protocol_takes_part_with_all_its_options():
    """A new protocol: add its [[tasks]] with every option to every_option.toml."""
    study, _ = read_study(str(pilots.EVERY_OPTION))
    assert {options.protocol for options in study.tasks} == set(protocol_names())
    for options in study.tasks:
        fields = type(options).model_fields
        unset = [name for name in fields if name not in options.model_fields_set]
        # A start of its own is one choice; a rule of levels knows reversals or certainty.
        without = {"start_level", "reversals", "threshold_sd_log10"}
        assert set(unset) <= without, options.protocol


def test_what_grows_over_a_day_is_named():
    """The first tenth of a day loads what is loaded late; what counts comes after it."""
    flat = soak.Level(
        sessions=1,
        memory_mib=100,
        board_mib=50,
        files=9,
        threads=2,
        cpu_s=1,
        relative=10,
        median_s=1,
        longest_s=2,
    )
    small = replace(flat, memory_mib=60)
    assert (
        soak.grown(
            [small, flat, flat, replace(flat, memory_mib=103, cpu_s=2, relative=12, median_s=9)]
        )
        == []
    )
    worse = replace(flat, memory_mib=110, board_mib=90, files=10, threads=3, relative=13)
    assert len(soak.grown([small, flat, worse])) == 5


def test_a_board_that_is_late_is_asked_again_but_not_for_ever(monkeypatch):
    asked: list[object] = []
    silent = 2

    class Late:
        def __enter__(self):
            asked.append(self)
            if len(asked) <= silent:
                raise PlateTimeout("no answer")
            return self

        def __exit__(self, *_):
            pass

    monkeypatch.setattr(soak, "open_plate", lambda *_, **__: Late())
    stack = ExitStack()
    assert soak.connected("serial:X", None, stack) is asked[2]
    asked.clear()
    silent = soak.ASKED
    with pytest.raises(PlateTimeout):
        soak.connected("serial:X", None, stack)
    assert len(asked) == soak.ASKED


@pytest.mark.usefixtures("patient")
def test_a_session_of_the_soak_is_a_whole_one(tmp_path):
    with EmulatorProcess("--noise", "0") as board:
        plan = pilots.plans_of("biet2007", 1)[0]
        took = soak.session(tmp_path, plan, board.port)
        level = soak.level(1, board.process_id, [took])
    assert took.whole_s > 0
    assert level.relative == took.cpu_s / took.same_work_s > 0
    assert (tmp_path / "participants.tsv").exists()
    assert min(level.memory_mib, level.board_mib, level.files, level.threads) > 0
