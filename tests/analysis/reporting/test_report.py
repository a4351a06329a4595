"""The report's words: true of few data as of many."""

import re
from types import SimpleNamespace

import pytest

from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reporting.files import write_analysis
from slipscale.analysis.reporting.page import render, results
from slipscale.analysis.tasks.estimation.statistics import FRIEDMAN, PAIRWISE, POWER_LAW


def few(table_by_hand, people, amplitudes, repetitions=1):
    rows = [
        f"{who},{amplitude},{10 + 20 * amplitude + 3 * ord(who) % 7 + nth}\n"
        for nth in range(repetitions)
        for who in people
        for amplitude in amplitudes
    ]
    return table_by_hand("participant_id,amplitude_um_pp,estimate\n" + "".join(rows))


@pytest.mark.parametrize(
    "people, amplitudes", [("a", (0, 1, 2)), ("ab", (0, 1, 2)), ("abcde", (0, 1)), ("abcd", (1,))]
)
def test_one_is_never_a_plural(table_by_hand, page, people, amplitudes):
    text = page(analyse(few(table_by_hand, people, amplitudes)))
    assert not re.search(r"\b[Aa]ll 1\b|\b1 (participants|pairs|amplitudes|repetitions)\b", text)


@pytest.mark.parametrize(
    "amplitudes, words",
    [
        (
            (0, 1),
            (
                "For the pair of amplitudes",
                "(two one-sided paired t tests of log estimates, p ",
                "; Bayes factor in",
            ),
        ),
        (
            (0, 1, 2),
            (
                "For all 3 pairs",
                "(two one-sided paired t tests of log estimates, all p ",
                "; all Bayes factors in",
            ),
        ),
    ],
)
def test_the_evidence_that_a_pair_differs_is_one_number_and_of_several_pairs_a_limit(
    table_by_hand, page, amplitudes, words
):
    text = page(analyse(few(table_by_hand, "abcdefgh", amplitudes)))
    assert [each for each in words if each not in text] == []


def test_no_interval_is_claimed_of_one_participant(table_by_hand, page):
    text = page(analyse(few(table_by_hand, "a", (0, 1, 2))))
    assert "Cousineau" not in text
    assert "so no spread or intervals are shown" in text


def test_a_sentence_is_repeated_only_if_another_part_of_the_report_merely_contains_it():
    kind = SimpleNamespace(
        sentences=lambda _: {"Slopes": ["One slope rose.", "It was 2.", "Both fell.", "New."]}
    )
    stated = {"One slope rose.", "Slopes: It was 2.", "Both fell. All others did not."}
    written = results(SimpleNamespace(kinds=(kind,)), stated)
    assert [str(each) for each in written.blocks] == [
        "<h3>Slopes</h3>",
        '<p class="sentence">Both fell.</p>',
        '<p class="sentence">New.</p>',
    ]


def test_what_participants_said_of_themselves_is_counted_without_the_excluded(dataset, page):
    rows = dataset.default_estimates(2)
    constant = [row | {"estimate": 50} for row in rows]
    folder = dataset(rows={"02": constant}, choices='exclusions = ["constant"]')
    lines = ["participant_id\tgender\tage\tmode\tcomplete"]
    lines += [
        f"sub-{n:02d}\t{'woman' if n % 2 else 'man'}\t{20 + n}\tparticipant\tyes"
        for n in range(1, 7)
    ]
    (folder / "participants.tsv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    text = page(analyse(folder))
    assert "man (2), woman (3)" in text
    assert "21 to 26, mean 23.8" in text


def test_a_study_of_differences_alone_does_not_speak_of_estimates(dataset, page):
    row = dataset.difference_row
    people = {f"{n:02d}": [row(1, 2.3, 1.2, "yes"), row(2, 1.2, 1.2, "no")] for n in range(1, 7)}
    people["03"].append(row(3, 1.2, 0.5, "yes", flag="voided"))
    people["03"].append(row(4, 1.2, 0.5, "n/a", flag="timed_out"))
    folder = dataset(differences=people)
    for path in folder.glob("sub-*/beh/*magnitude*"):
        path.unlink()
    text = page(analyse(folder))
    assert (
        "The descending difference: 14 rows were read; not analysed: 1 voided trial, 1 trial "
        "without a usable answer." in text
    )
    assert "Magnitude estimation: " not in text
    assert "normalised, averaged" not in text


def test_the_parts_of_order_that_were_not_computed_say_why(table_by_hand, page):
    text = page(analyse(few(table_by_hand, "ab", (0, 1, 2))))
    assert "Order and carry-over: not identifiable, because every participant" in text


@pytest.mark.parametrize(
    "rule, zero, words",
    [
        ("exclude", 0, "same under every rule"),
        ("half_minimum", 0, "differ slightly"),
        ("half_minimum", 9, "same under every rule"),
    ],
)
def test_what_normalisation_does_not_change_is_said_only_where_it_holds(
    dataset, page, rule, zero, words
):
    rows = dataset.default_estimates(1)
    rows[0] |= {"estimate": zero}
    folder = dataset(rows={"01": rows}, choices=f'zero_rule = "{rule}"')
    assert words in page(analyse(folder)).partition("Other normalisations")[2]


def test_rules_that_differ_within_a_participant_are_not_called_harmless(dataset, page):
    rows = dataset.default_estimates(1)
    rows[0] |= {"scale_top": 50}
    text = page(analyse(dataset(rows={"01": rows})))
    assert "can also affect tests and exponents" in text
    assert "same under every rule" not in text


def test_two_participants_have_no_interval(table_by_hand):
    found = analyse(few(table_by_hand, "ab", (0, 1, 2)))
    assert found.description[["within_low", "mean_low"]].isna().all(axis=None)
    assert found.description["sd_sample"].notna().all()


@pytest.mark.parametrize("rule, said", [("grand_maximum", True), ("modulus_equalisation", False)])
def test_scales_too_far_apart_for_one_factor_are_named(table_by_hand, rule, said):
    rows = "".join(
        f"{who},{a},{top * a}\n"
        for who, top in (("a", 1), ("b", 10), ("c", 10), ("d", 11))
        for a in (1, 2, 3)
    )
    path = table_by_hand("participant_id,amplitude_um_pp,estimate\n" + rows)
    problems = analyse(path, normalise=rule).problems
    assert any("10 times larger or smaller" in p for p in problems) is said
    assert any("equalisation removes differences in level" in p for p in problems) is not said


def test_pictures_have_alternative_texts_and_columns_headings(dataset, tmp_path):
    row = dataset.difference_row
    people = {f"{n:02d}": [row(1, 2.3, 1.2, "yes"), row(2, 1.2, 1.2, "no")] for n in range(1, 7)}
    text = write_analysis(analyse(dataset(differences=people)), tmp_path).read_text(
        encoding="utf-8"
    )
    pictures = re.findall(r"<svg[^>]*>", text)
    assert len(pictures) == 5
    assert all(re.search(r'role="img" aria-label="[^"]{20,}"', tag) for tag in pictures)
    # HTML forbids a role on a figure with a caption.
    assert "<figure>" in text
    assert "<figure " not in text
    assert not re.search(r'<th scope="col"[^>]*></th>', text)


@pytest.fixture
def written(dataset, page):
    """Return the report of six people, both tasks, with a pilot's banner."""
    row = dataset.difference_row
    people = {f"{n:02d}": [row(1, 2.3, 1.2, "yes"), row(2, 1.2, 1.2, "no")] for n in range(1, 7)}
    return page(analyse(dataset(differences=people, mode="pilot")))


def test_the_summary_is_read_without_opening_anything(written):
    main = written.partition('<main id="main">')[2]
    assert main.index("<b>Answer.</b>") < main.index("<details")
    assert re.findall(r"<details(.*?)><summary><h2[^>]*>(.*?)<", main)[:2] == [
        ("", "Further results, in sentences"),
        ("", "Magnitude estimates"),
    ]


def test_question_answer_and_figure_come_first_and_warnings_follow_what_they_qualify(written):
    body = written.partition("<body>")[2]
    order = [
        "PILOT DATA",
        "<b>Question.</b>",
        "<b>Answer.</b> Mean slipperiness rose",
        "<figure>",
        "Geometric means of slipperiness were",
        "smallest possible Holm-corrected p",
        "<b>Design.</b>",
        '<dl class="facts">',
        '<nav aria-label="Contents">',
        "<details",
    ]
    assert [each for each in order if each not in body] == []
    places = [body.index(each) for each in order]
    assert places == sorted(places)
    for each in order[2:6]:
        assert body.partition("<details")[0].count(each) == 1


def test_a_report_without_estimates_begins_with_its_first_figure(dataset):
    row = dataset.difference_row
    people = {f"{n:02d}": [row(1, 2.3, 1.2, "yes"), row(2, 1.2, 1.2, "no")] for n in range(1, 7)}
    folder = dataset(differences=people)
    for path in folder.glob("sub-*/beh/*magnitude*"):
        path.unlink()
    text = render(analyse(folder), {"difference": "<svg></svg>"}, {"slipscale": "0"})
    assert text.index("<figure>") < text.index('<dl class="facts">')
    assert text.count("<figure>") == 1


def test_a_link_of_the_contents_leads_into_what_it_opens(written):
    """A browser opens the details that hold a link's target, not those that are it."""
    links = re.findall(r'<a href="#([\w-]+)">', written.partition("<nav")[2])
    assert len(links) > 5
    for name in links[1:]:
        before = written.partition(f'id="{name}"')[0]
        assert before.count("<details") == before.count("</details>") + 1, name


def test_everything_is_in_a_landmark_and_no_heading_is_empty(written):
    header = written.partition("<header>")[2].partition("</header>")[0]
    assert "PILOT DATA" in header
    assert not re.search(r"<th[^>]*></th>", written)


def test_two_people_are_told_once_what_two_cannot_tell(table_by_hand, page):
    text = page(analyse(few(table_by_hand, "ab", (0, 1, 2))))
    doubts = text.partition("Caveats")[2].partition("</ul>")[0]
    assert "intervals, tests and exponents require at least three" in doubts
    assert "intervals are wide" not in doubts


def test_rows_of_an_excluded_participant_are_counted(dataset, page):
    constant = [row | {"estimate": 50} for row in dataset.default_estimates(2)]
    row = dataset.difference_row
    steps = {f"{n:02d}": [row(1, 2.3, 1.2, "yes"), row(2, 1.2, 1.2, "no")] for n in range(1, 7)}
    folder = dataset(rows={"02": constant}, differences=steps, choices='exclusions = ["constant"]')
    text = page(analyse(folder))
    left = f"{len(constant)} answered trials of excluded participants"
    assert f"Magnitude estimation: 48 rows were read; not analysed: {left}." in text
    assert "12 rows were read; not analysed: 2 answered trials of excluded participants." in text


def test_a_missing_cell_costs_a_participant_only_tests_of_complete_data(dataset, page):
    rows = dataset.default_estimates(2)
    found = analyse(dataset(rows={"02": [row for row in rows if row["amplitude_um_pp"] != 1.2]}))
    text = page(found)
    assert "other results use every participant with the necessary estimates" in text
    by = {pair.to_level: pair.n for pair in found.inference[PAIRWISE] if pair.from_level == 0}
    assert by == {0.5: 6, 1.2: 5, 2.3: 6}
    assert found.inference[POWER_LAW].n == 6
    assert found.inference[FRIEDMAN].n == 5


def test_equal_estimates_are_not_compared(table_by_hand, page):
    rows = [f"{who},{amplitude},50\n" for who in "abcdef" for amplitude in (0, 1, 2)]
    header = "participant_id,amplitude_um_pp,estimate\n"
    text = page(analyse(table_by_hand(header + "".join(rows))))
    assert "Estimates were the same at all amplitudes, so no pair was tested." in text
    assert "p not defined" not in text


@pytest.mark.parametrize("people, least", [("abcdef", ".094"), ("abcdefgh", "")])
def test_tests_that_so_few_participants_cannot_reach_are_named(table_by_hand, page, people, least):
    text = page(analyse(few(table_by_hand, people, (0, 1, 2))))
    sentence = f"smallest possible Holm-corrected p is {least}. Results that are not significant"
    assert (sentence in text) == bool(least)
    assert ("smallest possible" in text) == bool(least)
