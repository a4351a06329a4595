"""Bad input to `slipscale analyse`: one clear sentence, and what can be computed still is."""

import json
import re

import pytest

from slipscale import commands
from slipscale.analysis.json_form import record
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.equivalence import Equivalence
from slipscale.analysis.statistics.repeated_measures.pairwise import (
    PairComparison,
    PairedT,
    SignedRank,
)
from slipscale.analysis.tasks.difference.verbal_coding import load_codebook
from slipscale.analysis.tasks.estimation import sentences as apa
from slipscale.faults import UserError
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

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
        ("participant_id,amplitude_um_pp,estimate,estimate\na,0,1,2\n", "estimate occurs twice"),
        (
            TIDY.replace(",", "\t") + "a\t0,5\t1.5\n",
            "are equally frequent; expected only one kind",
        ),
        ("{" + "x" * 5000 + "}\n1\n", r"xxx \.\.\.\. Expected at least participant_id"),
    ],
)
def test_a_table_that_cannot_be_used_says_why(table_by_hand, text, words):
    with pytest.raises(UserError, match=words):
        analyse(table_by_hand(text))


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
    assert any("in another participant's folder; it was not read" in p for p in data.problems)


def test_who_is_missing_or_did_not_finish_is_said(dataset):
    folder = dataset(participants=3)
    (folder / "participants.tsv").write_text(
        "participant_id\tcomplete\nsub-01\tno\nsub-02\tyes\nsub-02\tyes\nsub-03\tyes\nsub-04\tno\n"
    )
    said = " ".join(analyse(folder).problems)
    assert "1 of 4 participants in participants.tsv have no trials (sub-04)" in said
    assert "2 of 4 participants did not finish a run (sub-01, sub-04)" in said
    assert "lists sub-02 more than once" in said


def test_a_participant_who_is_listed_twice_has_one_row_in_the_wide_table(dataset):
    from slipscale.analysis.tasks.estimation.table import wide

    folder = dataset(participants=3)
    (folder / "participants.tsv").write_text("participant_id\tage\nsub-01\t3\nsub-01\t4\n")
    assert len(wide(analyse(folder))) == 3


def test_a_list_of_participants_without_participant_id_is_refused(dataset):
    folder = dataset()
    (folder / "participants.tsv").write_text("id\tage\nsub-01\t30\n")
    with pytest.raises(
        UserError, match=r"participants.tsv: no column participant_id; found id, age"
    ):
        load(folder)


def test_a_slip_of_the_keyboard_beyond_all_numbers_is_left_out_and_named(table_by_hand):
    text = TIDY + "".join(f"{p},{a},{9 * a + 3}\n" for p in "abcd" for a in (0.5, 1.2, 2.3))
    analysis = analyse(table_by_hand(text + "a,2.3,1e308\n"))
    assert any(
        "'1e+308' instead of a number of 0 or more (at most 1e+100)" in p for p in analysis.problems
    )
    assert len(analysis.estimates) == 12


def test_rounding_in_an_amplitude_makes_no_other_amplitude(table_by_hand):
    text = TIDY + "a,0.3,1\nb,0.30000000000000004,2\nc,0.3,3\n"
    assert list(analyse(table_by_hand(text)).cells.columns) == [0.3]


def test_two_participants_are_told_what_needs_three(table_by_hand):
    text = TIDY + "".join(f"{p},{a},{a + 1}\n" for p in "ab" for a in (0, 1, 2))
    analysis = analyse(table_by_hand(text))
    assert any("only two participants" in p for p in analysis.problems)
    assert analysis.table3["standard_deviation"].notna().all()


def test_a_scale_top_that_changes_is_said(dataset):
    rows = dataset.default_estimates(2)
    rows[3] |= {"scale_top": 10}
    said = analyse(dataset(rows={"02": rows})).problems
    assert any("sub-02 declared more than one top of the scale" in p for p in said)


def test_catch_steps_are_what_was_presented_whatever_the_column_says(dataset):
    row = dataset.difference_row
    own = [row(1, 2.3, 1.2, "yes", catch="true"), row(2, 1.2, 1.2, "no", catch="perhaps")]
    data = load(dataset(differences={f"{n:02d}": own for n in range(1, 7)}))
    assert list(data.differences["catch"][:2]) == [False, True]
    said = " ".join(data.problems)
    assert "6 catch steps change the amplitude" in said
    assert "6 steps without a change are analysed as catch steps" in said


def test_people_who_all_but_one_give_one_number_have_no_interval_and_no_warning(table_by_hand):
    text = TIDY + "".join(f"{p},{a},7\n" for p in "abcde" for a in (0.5, 1.2, 2.3))
    found = analyse(table_by_hand(text.replace("a,0.5,7", "a,0.5,8"))).inference
    assert record(found.rm_anova)["eta2_generalised_ci"] == [None, None]
    assert pytest.approx(1.0) == found.rm_anova.F


def test_an_out_that_is_a_file_is_refused_before_anything_is_computed(dataset, tmp_path, capsys):
    out = tmp_path / "taken"
    out.write_text("")
    assert commands.main(["analyse", str(dataset()), "--out", str(out)]) == 2
    assert f"{out}: is a file; expected a folder" in capsys.readouterr().err


def test_steps_without_an_amplitude_are_counted_and_left_out_of_everything(dataset):
    """Their hits went into d', and the row of their step into none."""
    row = dataset.difference_row
    own = [
        row(1, 2.3, 1.2, "yes"),
        row(2, 1.2, 0.5, "no"),
        row(3, 0.5, 0.0, "yes"),
        row(4, 0.5, 0.5, "no"),
    ]
    bad = [own[0], own[1] | {"amplitude_before_um_pp": "NA"}, *own[2:]]
    people = {f"{n:02d}": bad if n == 2 else own for n in range(1, 7)}
    analysis = analyse(dataset(differences=people))
    assert analysis.dataset.counts["difference_unanswered"] == 1
    found = analysis.inference.difference
    assert found.signal_detection.pooled.changes == sum(step.n for step in found.steps) == 17


def test_estimates_above_the_declared_top_are_counted_and_named(dataset):
    rows = dataset.default_estimates(2)
    rows[3] |= {"estimate": 130}
    analysis = analyse(dataset(rows={"02": rows}))
    assert any(
        "1 of 48 estimates are above the top of the scale declared for their trial (sub-02)"
        in sentence
        for sentence in analysis.problems
    )
    assert analysis.estimates["normalised"].max() == pytest.approx(130)


def test_a_scale_top_of_zero_counts_as_none(table_by_hand):
    text = TIDY.replace("\n", ",scale_top\n") + "a,1,5,0\na,2,6,100\nb,1,5,100\nb,2,7,100\n"
    said = analyse(table_by_hand(text)).problems
    assert any("1 of 4 trials have no declared top of the scale above 0" in p for p in said)


def test_only_rules_that_the_data_allow_are_offered(table_by_hand):
    text = TIDY + "".join(f"{p},{a},{a + 1}\n" for p in "abc" for a in (0, 1, 2))
    with pytest.raises(UserError, match="expected one of none, grand_maximum") as error:
        analyse(table_by_hand(text), normalise="scale_top")
    assert "standard_referenced" not in str(error.value)


@pytest.mark.parametrize(
    "rows,words",
    [
        ("", r"nothing to analyse \(0 rows read\)"),
        ("a,0,,main,\nb,0,NA,main,\n", r"\(2 rows read: 2 trials without a usable answer\)"),
        (
            "a,0,5,practice,\nb,0,5,main,x\n",
            r"\(2 rows read: 1 practice trial, 1 trial of textures",
        ),
    ],
)
def test_where_nothing_is_left_to_analyse_it_is_said_why(table_by_hand, rows, words):
    text = TIDY.replace("\n", ",phase,texture\n") + rows
    with pytest.raises(UserError, match=words):
        analyse(table_by_hand(text))


def pairs_alike(people):
    """Everybody answers twice as much at 1 µm as at 0.5 µm, and their own at 2 µm."""
    third = {"a": 30, "b": 29, "c": 41, "d": 35, "e": 32}
    return TIDY + "".join(
        f"{who},{a},{answer}\n"
        for who in people
        for a, answer in ((0.5, third[who] / 4), (1, third[who] / 2), (2, third[who] ** 1.1))
    )


def test_pairs_that_all_tell_apart_alike_are_not_called_alike(table_by_hand, page):
    analysis = analyse(table_by_hand(pairs_alike("abcde")))
    text = page(analysis)
    assert not re.search(r"\bnan\b", text)
    assert (
        "Pairs whose log estimates were not tested: 0.5 and 1 µm (the ratio is 2 for all "
        "participants" in text
    )
    assert "Log estimates differed for both pairs of amplitudes" in text


def test_a_p_that_is_smaller_than_any_number_is_significant():
    logs = PairedT(
        ratio=2.0,
        ratio_interval=ConfidenceInterval(1.9, 2.1),
        t=99.0,
        df=11,
        p=0.0,
        p_holm=0.0,
        d_z=28.6,
        d_z_interval=None,
        equivalence=Equivalence(bound=1.25, interval=ConfidenceInterval(1.9, 2.1, 0.9), p=1.0),
        equivalence_p_holm=1.0,
        bayes_factor=float("inf"),
    )
    ranks = SignedRank(up=12, down=0, p=0.0, p_holm=0.0)
    row = PairComparison(from_level=0.5, to_level=1.2, n=12, n_logs=12, logs=logs, ranks=ranks)
    assert apa.pairwise_logs([row, row], 0.95, PLATE_AMPLITUDE).startswith(
        "Log estimates differed for both pairs of amplitudes"
    )


def test_people_who_repeat_themselves_exactly_have_no_reliability_and_no_warning(table_by_hand):
    text = TIDY + "".join(
        f"{p},{a},{answer + k}\n"
        for k, p in enumerate("abcd")
        for a, answer in ((0.5, 10), (1.2, 22), (2.3, 47))
        for _ in range(2)
    )
    found = analyse(table_by_hand(text)).inference.reliability
    assert "every repetition gave the same estimate" in found.reason


def test_coders_who_leave_cells_empty_or_never_vary_give_no_warning(dataset):
    folder = dataset(
        differences={f"{n:02d}": [dataset.difference_row(1, 2.3, 1.2, "yes")] for n in range(1, 7)}
    )
    (folder / "code").mkdir()
    (folder / "code/verbal_codes.tsv").write_text(
        "verbal_report\tcoder\tcategory\nx\ta\tp\nx\tb\tp\ny\ta\tq\ny\tb\tp\nz\t\tq\nz\tb\tn/a\n"
    )
    found = analyse(folder).inference.difference.coders
    assert found.coders == ("a", "b")
    assert (found.reports, found.agreed, found.kappa) == (2, 1, 0.0)


def test_a_stem_that_every_report_would_hold_is_refused(tmp_path):
    path = tmp_path / "book.toml"
    path.write_text("title = 'x'\n[categories.a]\nstems = [' ']\n")
    with pytest.raises(UserError, match=r"line 3, item 1 of categories.a.stems: .*got ' '"):
        load_codebook(path)


def test_files_of_windows_editors_begin_with_a_mark(dataset, tmp_path):
    folder = dataset(choices="confidence = 0.9")
    path = folder / "code/study.toml"
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert load(folder).choices.confidence == 0.9
    book = tmp_path / "book.toml"
    book.write_bytes(b"\xef\xbb\xbf" + b"title = 'x'\n[categories.a]\nstems = ['slip']\n")
    assert load_codebook(book).title == "x"


def test_keys_that_do_not_exist_are_spoken_of_plainly(dataset):
    folder = dataset(choices="foo = 1\nconfidence = 'high'")
    with pytest.raises(UserError, match=r"line 2, analysis.foo: unknown key") as error:
        load(folder)
    assert "got 'high'" in str(error.value)


def test_rows_of_participants_tsv_without_a_name_are_left_out(dataset):
    folder = dataset(participants=3)
    (folder / "participants.tsv").write_text(
        "participant_id \tage\n sub-01\t30\n\nn/a\t31\nsub-02 \t32\nsub-03\t33\n"
    )
    data = load(folder)
    assert list(data.participants["participant_id"]) == ["sub-01", "sub-02", "sub-03"]
    assert data.problems == (
        "participants.tsv, line 3: empty; skipped",
        "participants.tsv, line 4: omitted, because there is no participant_id",
    )
    assert not any("have no trials" in p for p in analyse(data).problems)


def test_a_column_of_participants_tsv_with_our_name_does_not_rename_ours(dataset):
    from slipscale.analysis.tasks.estimation.table import wide

    folder = dataset(participants=3)
    (folder / "participants.tsv").write_text("participant_id\testimate_0\nsub-01\t3\n")
    table = wide(analyse(folder))
    assert table["estimate_0"].notna().all()
    assert table["estimate_0_participants_tsv"].count() == 1


@pytest.mark.parametrize(
    "own",
    [
        {"plate": {"identity": None, "backend": "mock"}},
        {"plate": {"identity": 5}},
        {"seed": None, "study": None},
    ],
)
def test_a_sidecar_that_says_little_is_read(dataset, own):
    folder = dataset(participants=3)
    path = estimation(folder, "02").with_suffix(".json")
    path.write_text(json.dumps({"Slipscale": {"mode": "participant", **own}}))
    details = load(folder).details
    assert "None" not in str(details)


def test_a_sidecar_nested_beyond_reading_is_refused(dataset):
    folder = dataset(participants=3)
    estimation(folder, "02").with_suffix(".json").write_text("[" * 100_000)
    with pytest.raises(UserError, match="not a sidecar"):
        load(folder)


def test_many_absent_sidecars_fill_no_screen(dataset):
    folder = dataset(participants=15)
    for path in folder.glob("sub-*/beh/*.json"):
        path.unlink()
    problems = load(folder).problems
    assert len(problems) == 13
    assert problems[-1] == "... and 3 more of this kind (sidecars)"


def test_a_file_that_cannot_be_written_is_named(dataset, tmp_path, capsys):
    (tmp_path / "out/table3.csv").mkdir(parents=True)
    assert commands.main(["analyse", str(dataset(3)), "--out", str(tmp_path / "out")]) == 2
    assert "table3.csv: cannot be written (Is a directory)" in capsys.readouterr().err


@pytest.mark.parametrize("value", ["[" * 5000 + "]" * 5000, "9" * 5000], ids=["deep", "long"])
def test_a_study_beside_the_data_that_no_one_can_read_is_refused(dataset, value):
    folder = dataset(choices="confidence = 0.9")
    study = folder / "code" / "study.toml"
    study.write_text(f"{study.read_text()}\nconfidence_of = {value}\n")
    with pytest.raises(UserError, match=r"(?s)study\.toml.*(brackets|digits)"):
        load(folder)


def test_an_unpaired_quote_in_a_header_is_a_sentence(table_by_hand):
    for separator in "\t;,":
        header = TIDY.strip().replace(",", separator).replace("amp", '"amp')
        text = f"{header}\n{separator.join('a12')}\n"
        with pytest.raises(UserError, match="line 1, the header, has an unmatched quotation mark"):
            load(table_by_hand(text, f"{ord(separator)}.tsv"))


def test_a_number_of_thousands_of_digits_is_a_cell_that_is_none(table_by_hand):
    data = load(table_by_hand(f"{TIDY}a,1,2\na,2,{'9' * 5000}\n"))
    assert data.counts["unanswered"] == 1
    assert len(data.problems[0]) < 300


def test_amplitudes_that_no_float_can_hold_are_left_out_and_named(table_by_hand):
    """As whole numbers of 401 digits they come as Python's own, in a column without others."""
    data = load(table_by_hand(f"{TIDY}a,1{'0' * 400},2\n"))
    assert data.counts["analysed"] == 0
    assert "column amplitude_um_pp" in data.problems[0]
