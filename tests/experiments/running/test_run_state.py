"""How far a run has come, also where its journal is torn or damaged."""

import pytest

from slipscale.experiments.running.lab_session import make_plan
from slipscale.experiments.running.pilot import run_simulated
from slipscale.experiments.running.run_state import check_alike, remedy, run_state
from slipscale.faults import UserError


@pytest.fixture
def path(tmp_path, record_runs, plan):
    record_runs(tmp_path, "01")
    return plan().journal_path(tmp_path)


def test_a_torn_header_leaves_the_participants_number_free(path, plan):
    whole = path.read_bytes()
    header = whole.splitlines(keepends=True)[0]
    for torn in (header[:1], header[:-1], header[:700] + bytes(len(header) - 700)):
        path.write_bytes(torn)
        assert run_state(path) == "free"
        run_simulated(path.parents[2], plan(), "mock")
        assert run_state(path) == "complete"


@pytest.mark.parametrize("place", [0, 1, 50])
def test_a_damaged_journal_is_called_so_and_another_run_is_the_remedy(path, place):
    lines = path.read_bytes().splitlines(keepends=True)
    lines[place] = lines[place].replace(b'"kind"', b'"kinb"')
    path.write_bytes(b"".join(lines))
    state = run_state(path)
    assert state == "damaged"
    assert "for details: slipscale data verify" in remedy(path, state)
    assert "--run" in remedy(path, state)


def test_a_run_cut_between_records_is_interrupted(path):
    path.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[:20]))
    assert run_state(path) == "interrupted"


@pytest.mark.parametrize("run", ["A", "1b", "", "1.5", "٣"])
def test_a_new_run_has_a_number_because_the_analysis_reads_no_other_runs(run):
    with pytest.raises(UserError, match=r"--run '.*': expected"):
        make_plan("biet2007", participant="01", run=run)


@pytest.mark.parametrize(
    "labels, said",
    [
        ({"session": "a", "run": "1"}, "--run 1: participant 01 already has a run 01"),
        ({"session": "A"}, "--session A: participant 01 already has a session a"),
    ],
)
def test_the_same_session_or_run_under_an_equivalent_label_is_refused(
    tmp_path, record_runs, labels, said
):
    record_runs(tmp_path, "01", session="a")
    check_alike(tmp_path, "01", session="a", run="02")
    check_alike(tmp_path, "01", session="b", run="1")
    check_alike(tmp_path, "02", session="A", run="1")
    with pytest.raises(UserError, match=said):
        check_alike(tmp_path, "01", **labels)
