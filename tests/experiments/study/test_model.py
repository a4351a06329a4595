import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.experiments.study.file import parse_study, read_study, shipped_studies
from slipscale.experiments.study.model import Study
from slipscale.faults import UserError

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
    assert read_study(name)[0].authors == ()  # a copy names its own


def test_the_papers_study_is_the_papers():
    """Biet 2007, Section IV-B: twelve volunteers, four amplitudes, descending series first."""
    study, _ = read_study("biet2007")
    assert study.participants == 12
    assert study.levels == (0.0, 0.5, 1.2, 2.3)
    assert [t.protocol for t in study.tasks] == ["descending_difference", "magnitude_estimation"]


def test_every_fault_is_told_at_once_with_line_key_and_what_was_expected():
    with pytest.raises(UserError) as caught:
        parse_study(BAD, "bad.toml")
    message = str(caught.value)
    for part in (
        "bad.toml has 8 faults",
        "line 2, name: expected letters, digits and _, beginning with a letter, got 'two words'",
        "line 3, titel: unknown key (did you mean 'title'?)",
        "line 4, language: expected one of en, fr, got 'xx'",
        "line 5, amplitudes_um_pp: 9.0 is beyond the plate's 2.5 µm p-p",
        "line 9, repetitions of item 1 of tasks: expected 1 or more, got 0",
        "line 10, practise of item 1 of tasks: unknown key",
        "line 13, protocol of item 2 of tasks: expected one of category_scale, constant_stimuli",
        "line 17, series of item 3 of tasks: expected a whole number without quotation marks",
    ):
        assert part in message


IMPOSSIBLE = """
name = "impossible"
title = "Each key is sound, together they are not"
language = "fr"
seed = -1
amplitudes_um_pp = [0.5, 0.5, 3.0]
texts.en.session.wellcome = "Hello"
texts.fr.session.welcome = '''
language = "{name}"
'''
texts.Klingon.session.rest = "Hu"

[[textures]]
name = "ridges"
spatial_period_mm = 2.5
mean_um_pp = 1.5
depth_um_pp = 1.2
finger_speed_mm_s = 50.0

[[tasks]]
protocol = "descending_difference"
start_um_pp = 2.7

[[tasks]]
protocol = "descending_difference"
start_um_pp = 2.9

[[tasks]]
protocol = "magnitude_estimation"
standard_um_pp = 4.0
practise = 1

[[about_you]]
name = "sex"
options = ["a", "b"]

[[about_you]]
name = "shoe_size"
options = ["a", "b"]

[[about_you]]
name = "sex"
options = ["a", "b"]
"""


def test_faults_between_keys_are_told_at_once_too_each_with_its_line():
    with pytest.raises(UserError) as caught:
        parse_study(IMPOSSIBLE, "impossible.toml")
    expected = [
        "impossible.toml has 14 faults:",
        "  line 5, seed: expected 0 or more, got -1",
        "  line 6, amplitudes_um_pp: 3.0 is beyond the plate's 2.5 µm p-p",
        "  line 6, amplitudes_um_pp: expected different values",
        "  line 7, texts.en.session.wellcome: unknown text key; expected a key such as session.w",
        "  line 8, texts.fr.session.welcome: contains unknown placeholders or",
        "  line 11, texts.Klingon: expected a language code, such as de or pt-BR",
        "  line 13, item 1 of textures: 2.7 is beyond the plate's 2.5 µm p-p",
        "  line 22, start_um_pp of item 1 of tasks: 2.7 is beyond the plate's 2.5 µm p-p",
        (
            "  line 25, protocol of item 2 of tasks: there is already a "
            "'descendingdifference': set another label"
        ),
        "  line 26, start_um_pp of item 2 of tasks: 2.9 is beyond the plate's 2.5 µm p-p",
        (
            "  line 28, modulus of item 3 of tasks: standard_um_pp and modulus "
            "belong together: set both, or neither"
        ),
        "  line 31, practise of item 3 of tasks: unknown key",
        "  line 37, prompt of item 2 of about_you: 'shoe_size' needs its own prompt",
        "  line 42, name of item 3 of about_you: there is already a 'sex'",
    ]
    for told, line in zip(str(caught.value).splitlines(), expected, strict=True):
        assert told.startswith(line)


def test_a_task_without_trials_is_refused():
    text = GOOD.replace("[0, 1]", "[1]").replace(
        '"magnitude_estimation"', '"descending_difference"\ncatch_steps = 0'
    )
    with pytest.raises(
        UserError, match=r"line 5, item 1 of tasks: the task has no trials with these amplitudes"
    ):
        parse_study(text, "study.toml")


@pytest.mark.parametrize(
    "change, complaint",
    [
        (("[0, 1]", "[]"), "amplitudes_um_pp: is missing"),
        (("[0, 1]", "[1, 1]"), "different values"),
        (("[0, 1]", "[0, nan]"), "finite number"),
        (("[0, 1]", "1.0"), r"amplitudes_um_pp: expected a list in \[brackets\], got 1.0"),
        (('title = "Small"', 'title = "Small"\nplate = 2.5'), "plate: expected a table, got 2.5"),
        (("[0, 1]", "[0.0, -0.0]"), "different values"),
        (("[0, 1]", '["0"]'), "expected a number"),
        (("[[tasks]]", "[tasks]"), "expected \\[\\[tasks\\]\\] tables"),
        (('protocol = "magnitude_estimation"', "modulus = 3"), "expected one of"),
        (('"magnitude_estimation"', '"magnitude_estimation"\nmodulus = 10'), "belong together"),
        (
            ('"magnitude_estimation"', f'"magnitude_estimation"{SHORT}'),
            "line 7, exploration_maximum_s of item 1 of tasks: expected no less than",
        ),
        (
            ('"magnitude_estimation"', f'"descending_difference"{SHORT}'),
            "line 7, exploration_maximum_s of item 1 of tasks: expected no less than",
        ),
        (
            (
                '"magnitude_estimation"',
                '"magnitude_estimation"\nmodulus = 10.0\nstandard_um_pp = 7.0',
            ),
            "7.0 is beyond",
        ),
        (('title = "Small"', 'title = "Small"\nseed = true'), "whole number"),
        (('title = "Small"', "title = "), "line 3 is not TOML"),
        (('title = "Small"', 'title = "Small"\ntexts.en.session.wellcome = "x"'), "wellcome"),
        (('title = "Small"', 'title = "Small"\ntexts.fr.session.rest = "{x}"'), "session.rest"),
        (
            ("[[tasks]]", '[[tasks]]\nprotocol = "magnitude_estimation"\n[[tasks]]'),
            "set another label",
        ),
        (("[[tasks]]", ASKED.format('"a", "a"') + "[[tasks]]"), "line 7, options of .*different"),
        (
            ("[[tasks]]", 2 * ASKED.format('"a", "b"') + "[[tasks]]"),
            "line 9, name of item 2 of about_you: there is already a 'sex'",
        ),
    ],
)
def test_each_fault_is_one_clear_sentence(change, complaint):
    with pytest.raises(UserError, match=complaint):
        parse_study(GOOD.replace(*change), "study.toml")


def test_a_study_that_windows_editors_marked_as_utf8_is_read(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(GOOD, encoding="utf-8-sig")
    assert read_study(str(path))[0].name == "small"


def test_a_negative_zero_is_zero():
    study = parse_study(GOOD.replace("[0, 1]", "[-0.0, 1]"), "study.toml")
    assert str(study.levels[0]) == "0.0"


def test_no_such_study_names_the_shipped_ones():
    with pytest.raises(UserError, match="biet2007"):
        read_study("no-such-file.toml")


@given(st.text())
def test_no_text_whatever_ends_in_a_traceback(text):
    with contextlib.suppress(UserError):
        assert isinstance(parse_study(text, "any.toml"), Study)


def test_a_study_in_another_quantity_must_state_the_plates_limit():
    """The default limit of 2.5 is in µm."""
    text = (
        'name = "volts"\ntitle = "Volts"\nvoltages_v_peak = [0.0, 40.0]\n'
        '[quantity]\nname = "voltage"\nunit = "V"\nconvention = "peak"\n'
        '[[tasks]]\nprotocol = "magnitude_estimation"\n'
    )
    with pytest.raises(UserError) as caught:
        parse_study(text, "volts.toml")
    assert str(caught.value) == (
        "volts.toml: plate.voltage_v_peak: is missing; expected a value in V peak, "
        "because the default is in µm"
    )
