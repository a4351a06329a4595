import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.study import Study, line_of, parse_study, read_study, shipped_studies
from faults import UserError

BAD = """
name = "two words"
titel = "Slipperiness"
language = "xx"
amplitudes_um_pp = [0.0, 9.0]

[[tasks]]
protocol = "magnitude_estimation"
repetitions = 0
practise = 2

[[tasks]]
protocol = "staircase"

[[tasks]]
protocol = "descending_difference"
series = "3"
"""

GOOD = """
name = "small"
title = "Small"
amplitudes_um_pp = [0, 1]
[[tasks]]
protocol = "magnitude_estimation"
"""

SHORT = "\nexploration_maximum_s = 1.0\nexploration_minimum_s = 2.0"
ASKED = """[[about_you]]
name = "sex"
options = [{}]
"""


@pytest.mark.parametrize("name", shipped_studies())
def test_shipped_studies_are_valid_and_named_after_their_file(name):
    assert read_study(name)[0].name == name


def test_the_papers_study_is_the_papers():
    """Biet 2007, Section IV-B: twelve volunteers, four amplitudes, descending series first."""
    study, _ = read_study("biet2007")
    assert study.participants == 12
    assert study.amplitudes_um_pp == (0.0, 0.5, 1.2, 2.3)
    assert [t.protocol for t in study.tasks] == ["descending_difference", "magnitude_estimation"]


def test_every_fault_is_told_at_once_with_line_key_and_what_was_expected():
    with pytest.raises(UserError) as caught:
        parse_study(BAD, "bad.toml")
    message = str(caught.value)
    for part in (
        "bad.toml has 9 faults",
        "title: is missing",
        "line 2, name: string should match",
        "line 3, titel: there is no such key",
        "line 4, language: expected one of en, fr, got 'xx'",
        "line 5, amplitudes_um_pp: 9.0 is beyond the plate's 2.5 µm p-p",
        "line 9, tasks.1.repetitions: input should be greater than or equal to 1, got 0",
        "line 10, tasks.1.practise: there is no such key",
        "line 13, tasks.2.protocol: expected one of descending_difference",
        "line 17, tasks.3.series: input should be a valid integer, got '3'",
    ):
        assert part in message


@pytest.mark.parametrize(
    "change, complaint",
    [
        (("[0, 1]", "[]"), "at least 1 item"),
        (("[0, 1]", "[1, 1]"), "all different"),
        (("[0, 1]", "[0, nan]"), "finite number"),
        (("[0, 1]", '["0"]'), "valid number"),
        (("[[tasks]]", "[tasks]"), "expected \\[\\[tasks\\]\\] tables"),
        (('protocol = "magnitude_estimation"', "modulus = 3"), "expected one of"),
        (('"magnitude_estimation"', '"magnitude_estimation"\nmodulus = 10'), "go together"),
        (
            ('"magnitude_estimation"', f'"magnitude_estimation"{SHORT}'),
            "line 7, tasks.1.exploration_maximum_s: expected no less than",
        ),
        (
            ('"magnitude_estimation"', f'"descending_difference"{SHORT}'),
            "line 7, tasks.1.exploration_maximum_s: expected no less than",
        ),
        (
            (
                '"magnitude_estimation"',
                '"magnitude_estimation"\nmodulus = 10.0\nstandard_um_pp = 7.0',
            ),
            "7.0 is beyond",
        ),
        (('title = "Small"', 'title = "Small"\nseed = true'), "valid integer"),
        (('title = "Small"', "title = "), "is not TOML.*line 3"),
        (('title = "Small"', 'title = "Small"\ntexts.en.session.wellcome = "x"'), "wellcome"),
        (('title = "Small"', 'title = "Small"\ntexts.fr.session.rest = "{x}"'), "session.rest"),
        (("[[tasks]]", '[[tasks]]\nprotocol = "magnitude_estimation"\n[[tasks]]'), "once"),
        (("[[tasks]]", ASKED.format('"a", "a"') + "[[tasks]]"), "line 7, .*options: .*different"),
        (("[[tasks]]", 2 * ASKED.format('"a", "b"') + "[[tasks]]"), "'sex' is asked more than"),
    ],
)
def test_each_fault_is_one_clear_sentence(change, complaint):
    with pytest.raises(UserError, match=complaint):
        parse_study(GOOD.replace(*change), "study.toml")


def test_a_study_that_windows_editors_marked_as_utf8_is_read(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(GOOD, encoding="utf-8-sig")
    assert read_study(str(path))[0].name == "small"


def test_no_such_study_names_the_shipped_ones():
    with pytest.raises(UserError, match="biet2007"):
        read_study("no-such-file.toml")


@given(st.text())
def test_no_text_whatever_ends_in_a_traceback(text):
    with contextlib.suppress(UserError):
        assert isinstance(parse_study(text, "any.toml"), Study)


def test_lines_are_found_in_repeated_and_nested_tables():
    text = "a = 1\n[[tasks]]\nx = 1\n[[tasks]]\nx = 2\n[texts.en]\ny = 3\n"
    assert line_of(text, ("tasks", 1, "x")) == 5
    assert line_of(text, ("texts", "en", "y")) == 7
    assert line_of(text, ("tasks", 1, "missing")) == 4
    assert line_of(text, ("elsewhere",)) == 0
