"""The sentence with which a report of magnitude estimates begins."""

import pytest

from slipscale.analysis.pipeline import analyse
from slipscale.analysis.tasks.estimation.plain_answer import plain_answer

#: What a participant says at each of three amplitudes -> the sentence about six of them.
SAID = {
    (10, 40, 80): "Mean slipperiness rose from 11 to 81 between 0 and 2 µm; each amplitude "
    "differed from the next.",
    (80, 40, 10): "Mean slipperiness fell from 81 to 11 between 0 and 2 µm; each amplitude "
    "differed from the next.",
    (10, 80, 40): "Mean slipperiness differed between amplitudes: it was lowest at 0 µm, 11, and "
    "highest at 1 µm, 81; each amplitude differed from the next.",
}


def told(table_by_hand, said, people="abcdefgh", **choices):
    rows = [
        f"{who},{level},{estimate + number / 4}\n"
        for number, who in enumerate(people)
        for level, estimate in said(number).items()
    ]
    header = "participant_id,amplitude_um_pp,estimate\n"
    path = table_by_hand(header + "".join(rows))
    return plain_answer(analyse(path, normalise="none", **choices))


@pytest.mark.parametrize("estimates", SAID)
def test_the_direction_and_the_ends_are_those_of_the_figure(table_by_hand, estimates):
    assert told(table_by_hand, lambda _: dict(enumerate(estimates))) == SAID[estimates]


def test_neighbours_without_a_difference_are_named(table_by_hand):
    def said(number):
        return {0: 10, 1: 10 + (-1) ** number, 2: 60, 3: 90}

    assert told(table_by_hand, said).endswith("; no difference was shown between 0 and 1 µm.")


def test_without_a_difference_no_direction_is_stated(table_by_hand):
    def said(number):
        return {0: 50, 1: 50 + (-1) ** number, 2: 50 + (-1) ** (number // 2)}

    words = told(table_by_hand, said)
    assert words == (
        "No difference between amplitudes was shown: mean slipperiness ranged from 51 to 51 "
        "between 0 and 2 µm."
    )


@pytest.mark.parametrize(
    "levels, words",
    [
        ({0: 10, 2: 90}, "was 10 at 0 µm and 90 at 2 µm; a difference could not be tested."),
        ({2: 90}, "was 90 at 2 µm."),
    ],
)
def test_what_one_participant_said_is_not_tested(table_by_hand, levels, words):
    assert told(table_by_hand, lambda _: levels, "a") == f"Mean slipperiness {words}"


def test_small_means_keep_their_digits_and_percentages_name_their_whole(table_by_hand):
    words = told(table_by_hand, lambda _: {0: 0.5, 1: 1, 2: 2}, "abcdef")
    assert "from 1.12 to 2.62 between" in words
    assert words.endswith("; no difference was shown between 0 and 1 µm, or between 1 and 2 µm.")
    rows = "".join(
        f"{who},{level},{level + (ord(who) % 5) / 10}\n" for who in "abcdef" for level in (1, 2, 4)
    )
    path = table_by_hand("participant_id,amplitude_um_pp,estimate\n" + rows)
    assert "from 27 to 95 % of the largest participant mean between 1 and 4 µm" in plain_answer(
        analyse(path, normalise="grand_maximum")
    )
