"""Several sessions: taken together and said so, or one by itself."""

from dataclasses import replace

import pytest

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.preprocessing.sessions import only_session, sessions_of
from slipscale.commands import main
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_models")

ROWS = "".join(
    f"{person},{session},{amplitude},{10 + factor * amplitude + person}\n"
    for person in (1, 2, 3)
    for session, factor in (("01", 20), ("02", 40))
    for amplitude in (0, 1, 2)
)
TEXT = "participant_id,session,amplitude_um_pp,estimate\n" + ROWS


@pytest.fixture
def table(table_by_hand):
    return table_by_hand(TEXT)


def test_sessions_taken_together_are_said_to_be(table):
    [sentence] = [each for each in analyse(table, normalise="none").problems if "Sessions" in each]
    assert "Sessions 01, 02 are combined" in sentence
    assert "--in-session 01" in sentence


def test_one_session_is_analysed_by_itself(table):
    data = load(table)
    assert sessions_of(data) == ["01", "02"]
    for session, top in (("01", 52.0), ("02", 92.0)):
        found = analyse(only_session(data, session), normalise="none")
        assert found.table3["mean"].iloc[-1] == pytest.approx(top)
        note = f"Only session {session} is analysed; the data contain sessions 01, 02."
        assert note in found.problems
        assert not [each for each in found.problems if "are combined" in each]


def test_the_study_file_decides_which_session_is_the_first(table):
    # Sorted labels made "evening" the first session of a study with a morning and an evening.
    study = 'sessions = ["02", "01"]'
    found = analyse(replace(load(table), study_text=study), normalise="none")
    assert sessions_of(found.dataset) == ["02", "01"]
    (exponent,) = [each for each in found.inference.sessions.measures if "exponent" in each.name]
    [change] = exponent.changes
    assert change.session == "01"
    assert exponent.means[1] - exponent.means[0] == pytest.approx(change.change.mean)
    assert change.change.mean < 0  # estimates grew more steeply in session 02
    unknown = replace(load(table), study_text='sessions = ["02", "03"]')
    assert sessions_of(unknown) == ["02", "01"]


def test_a_session_that_is_not_there_is_told_with_those_that_are(table):
    with pytest.raises(UserError, match=r"unknown session '03'; expected one of 01, 02"):
        only_session(load(table), "03")


def test_without_sessions_nothing_is_said(table_by_hand):
    data = table_by_hand("participant_id,amplitude_um_pp,estimate\na,0,1\na,1,5\nb,0,2\nb,1,6\n")
    assert not [each for each in analyse(data).problems if "ession" in each]
    with pytest.raises(UserError, match="expected one of none"):
        only_session(load(data), "01")


def test_its_results_lie_beside_those_of_all(table, capsys):
    assert main(["analyse", str(table), "--in-session", "02", "--normalise", "none"]) == 0
    assert "ses-02" in capsys.readouterr().out
