"""Bad input to `slipscale analyse`: one clear sentence, and what can be computed still is."""

import json

import pytest

import slipscale
from analysis.loading import load
from analysis.pipeline import analyse
from faults import UserError

TIDY = "participant_id,amplitude_um_pp,estimate\n"


def estimation(folder, label):
    return folder / f"sub-{label}/beh/sub-{label}_task-magnitudeestimation_run-01_beh.tsv"


def test_a_file_without_a_required_column_is_named_among_files_that_have_it(dataset):
    """Joined with its neighbours, its estimates would only look unanswered."""
    folder = dataset()
    path = estimation(folder, "03")
    path.write_text(path.read_text().replace("\testimate\t", "\tguess\t"))
    with pytest.raises(UserError, match=r"sub-03_task.*no column estimate; found trial"):
        load(folder)


@pytest.mark.parametrize(
    "text,words",
    [
        ("participant_id,amplitude_um_pp,estimate,estimate\na,0,1,2\n", "estimate is there twice"),
        (TIDY.replace(",", "\t") + "a\t0,5\t1,5\n", "'0,5' where a number with a decimal point"),
        ("{" + "x" * 5000 + "}\n1\n", r"xxx \.\.\.\. Expected at least participant_id"),
    ],
)
def test_a_table_that_cannot_be_used_says_why(table_by_hand, text, words):
    with pytest.raises(UserError, match=words):
        analyse(table_by_hand(text), write=False)


@pytest.mark.parametrize("own", [5, {"software": 3}])
def test_a_sidecar_of_another_make_is_refused(dataset, own):
    folder = dataset()
    path = estimation(folder, "02").with_suffix(".json")
    path.write_text(json.dumps({"Slipscale": own}))
    with pytest.raises(UserError, match=r"sub-02.*not a sidecar"):
        load(folder)


def test_a_file_in_another_participant_s_folder_is_not_counted_twice(dataset):
    folder = dataset()
    path = estimation(folder, "03")
    (folder / "sub-02/beh" / path.name.replace("run-01", "run-02")).write_text(path.read_text())
    data = load(folder)
    assert data.counts["analysed"] == 48
    assert any("in another participant's folder; not read" in p for p in data.problems)


def test_who_is_missing_or_did_not_finish_is_said(dataset):
    folder = dataset(participants=3)
    (folder / "participants.tsv").write_text(
        "participant_id\tcomplete\nsub-01\tno\nsub-02\tyes\nsub-02\tyes\nsub-03\tyes\nsub-04\tno\n"
    )
    said = " ".join(analyse(folder, write=False).problems)
    assert "1 of 4 participants of participants.tsv have no trials (sub-04)" in said
    assert "2 of 4 participants did not finish a run (sub-01, sub-04)" in said
    assert "lists sub-02 more than once" in said


def test_a_participant_who_is_listed_twice_has_one_row_in_the_wide_table(dataset):
    from analysis.outputs import wide  # noqa: PLC0415 - matplotlib takes a second to load

    folder = dataset(participants=3)
    (folder / "participants.tsv").write_text("participant_id\tage\nsub-01\t3\nsub-01\t4\n")
    assert len(wide(analyse(folder, write=False))) == 3


def test_a_list_of_participants_without_participant_id_is_refused(dataset):
    folder = dataset()
    (folder / "participants.tsv").write_text("id\tage\nsub-01\t30\n")
    with pytest.raises(
        UserError, match=r"participants.tsv: no column participant_id; found id, age"
    ):
        load(folder)


def test_a_slip_of_the_keyboard_beyond_all_numbers_is_left_out_and_named(table_by_hand):
    text = TIDY + "".join(f"{p},{a},{9 * a + 3}\n" for p in "abcd" for a in (0.5, 1.2, 2.3))
    analysis = analyse(table_by_hand(text + "a,2.3,1e308\n"), write=False)
    assert any(
        "'1e+308' where a number of 0 or more, at most 1e+100" in p for p in analysis.problems
    )
    assert len(analysis.estimates) == 12


def test_rounding_in_an_amplitude_makes_no_other_amplitude(table_by_hand):
    text = TIDY + "a,0.3,1\nb,0.30000000000000004,2\nc,0.3,3\n"
    assert list(analyse(table_by_hand(text), write=False).cells.columns) == [0.3]


def test_two_participants_are_told_what_needs_three(table_by_hand):
    text = TIDY + "".join(f"{p},{a},{a + 1}\n" for p in "ab" for a in (0, 1, 2))
    analysis = analyse(table_by_hand(text), write=False)
    assert any("Two participants" in p for p in analysis.problems)
    assert analysis.table3["standard_deviation"].notna().all()


def test_a_scale_top_that_changes_is_said(dataset):
    rows = dataset.default_estimates(2)
    rows[3] |= {"scale_top": 10}
    said = analyse(dataset(rows={"02": rows}), write=False).problems
    assert any("sub-02 declared more than one scale top" in p for p in said)


def test_catch_steps_are_what_was_presented_whatever_the_column_says(dataset):
    row = dataset.difference_row
    own = [row(1, 2.3, 1.2, "yes", catch="true"), row(2, 1.2, 1.2, "no", catch="perhaps")]
    data = load(dataset(differences={f"{n:02d}": own for n in range(1, 7)}))
    assert list(data.differences["catch"][:2]) == [False, True]
    said = " ".join(data.problems)
    assert "6 catch steps change the amplitude" in said
    assert "6 steps leave the amplitude as it was" in said


def test_people_who_all_but_one_give_one_number_have_no_interval_and_no_warning(table_by_hand):
    text = TIDY + "".join(f"{p},{a},7\n" for p in "abcde" for a in (0.5, 1.2, 2.3))
    found = analyse(table_by_hand(text.replace("a,0.5,7", "a,0.5,8")), write=False).inference
    assert found["rm_anova"]["eta2_generalised_ci"] == [None, None]
    assert found["rm_anova"]["F"] == pytest.approx(1.0)


def test_an_out_that_is_a_file_is_refused_before_anything_is_computed(dataset, tmp_path, capsys):
    out = tmp_path / "taken"
    out.write_text("")
    assert slipscale.main(["analyse", str(dataset()), "--out", str(out)]) == 2
    assert f"{out}: is a file; expected a folder" in capsys.readouterr().err
