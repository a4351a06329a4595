"""Sentences on pairs of amplitudes: one verdict, and no verdict that a test cannot reach."""

import re

import pytest

import slipscale


@pytest.fixture(scope="module")
def flat(tmp_path_factory):
    """Return the analysis of seven people who rate amplitudes differently, and one who does not."""
    path = tmp_path_factory.mktemp("flat") / "flat.csv"
    rows = ["participant_id,amplitude_um_pp,estimate"]
    for person in range(7):
        for place, amplitude in enumerate((0, 0.5, 1.2, 2.3)):
            rows.append(f"s{person},{amplitude},{10 * 2**place + person * (place + 1)}")
    rows += [f"s7,{amplitude},50" for amplitude in (0, 0.5, 1.2, 2.3)]
    path.write_text("\n".join(rows))
    return slipscale.analyse(slipscale.load(path), normalise="none")


def test_pairs_that_a_test_cannot_tell_apart_have_no_negative_verdict(flat, page):
    text = page(flat)
    # Seven people differ: 6 pairs · 2 / 2⁷ = .094 is the smallest corrected p.
    assert "Estimates could not be shown to differ" in text
    assert "did not differ reliably for any" not in text
    assert "the smallest possible Holm-corrected p is .094" in text


def test_only_tests_that_are_named_state_a_difference(flat, page):
    text = page(flat)
    assert "estimates differed, and tests did not show" not in text
    for told in re.findall(r"[^.]*\bdiffered for (?:all|both|\d)[^.]*", text):
        assert "paired t tests" in told


def test_the_paper_is_compared_with_its_own_study_only(flat, page):
    assert set(flat.table3["level"]) == {0, 0.5, 1.2, 2.3}
    assert not flat.beside_paper
    assert "The paper: Table III" not in page(flat)


def test_means_of_different_numbers_of_participants_state_their_n(tmp_path, page):
    path = tmp_path / "missing.csv"
    rows = ["participant_id,amplitude_um_pp,estimate", "s0,0.5,0"]
    rows += [f"s{person},0.5,{20 + person}" for person in range(1, 8)]
    rows += [f"s{person},2.3,{80 + person}" for person in range(7)]
    path.write_text("\n".join(rows))
    found = slipscale.analyse(slipscale.load(path), normalise="none")
    text = page(found)
    assert "Arithmetic means of 7 to 8 participants." in text
    assert "at 0.5 µm (n = 7 of 8, without estimates of zero)" in text
