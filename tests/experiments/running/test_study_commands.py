"""What ``slipscale study`` says of orders and their balance."""

import re
import sys

import numpy as np
import pytest

from slipscale.commands import main
from slipscale.experiments.lab.console.page_texts import Words
from slipscale.experiments.protocols.magnitude_estimation import MagnitudeEstimation
from slipscale.experiments.running.balance import order_balance, task_balance
from slipscale.experiments.running.pilot import pilot_plans
from slipscale.experiments.running.study_commands import orders_of_all, show, validate
from slipscale.experiments.study.file import read_study, study_text
from slipscale.faults import UserError

STUDY = """
name = "five"
title = "Five surfaces"
participants = {participants}
amplitudes_um_pp = [0.0, 0.5, 1.0, 1.5, 2.0]
{keys}
[[tasks]]
protocol = "magnitude_estimation"
randomisation = "{rule}"
[[tasks]]
protocol = "descending_difference"
"""


@pytest.fixture
def study(tmp_path):
    def write(participants=12, rule="williams", keys=""):
        path = tmp_path / "five.toml"
        path.write_text(STUDY.format(participants=participants, rule=rule, keys=keys))
        return str(path)

    return write


@pytest.mark.parametrize("say", [validate, lambda name: show(name, "01")])
def test_rows_that_participants_do_not_fill_are_told(study, say):
    said = say(study())
    assert "12 blocks in 12 runs do not fill complete squares of 10 rows" in said
    assert "10 participants, or a multiple of 10, would be balanced" in said


def test_filled_rows_are_told(study):
    said = validate(study(participants=20))
    assert "20 blocks in 20 runs are balanced with squares of 10 rows" in said
    assert "each surface follows every other surface 4 times" in said  # 80 pairs, 20 transitions


def test_unequal_transitions_are_named():
    options = MagnitudeEstimation(protocol="magnitude_estimation", randomisation="williams")
    said = order_balance(options, "abc", [["abc"], ["abc"], ["bca"]])
    assert said == (
        "williams: 3 blocks in 3 runs do not fill complete squares of 6 rows; within blocks "
        "c then a comes 1 time; a then b comes 2 times; b then c comes 3 times; "
        "the other 3 transitions 0 times; 6 participants, or a multiple of 6, would be balanced"
    )


def test_the_balance_is_told_in_the_readers_language():
    options = MagnitudeEstimation(protocol="magnitude_estimation", randomisation="williams")
    balance = order_balance(options, "abc", [["abc"], ["abc"], ["bca"]])
    assert Words("fr").say(balance).replace("\N{NO-BREAK SPACE}", " ") == (
        "williams : 3 blocs en 3 passages ne remplissent pas de carrés complets de 6 lignes ; "
        "dans les blocs, c puis a vient 1 fois ; a puis b vient 2 fois ; b puis c vient 3 fois ; "
        "les autres (3 transitions) 0 fois ; 6 participants, "
        "ou un multiple de 6, seraient équilibrés"
    )
    tasks = Words("fr").say(task_balance("aba")).replace("\N{NO-BREAK SPACE}", " ")
    assert tasks == (
        "ordre des tâches : a en premier dans 2 passages, b en premier dans 1 passage ; un nombre "
        "pair de passages serait équilibré"
    )


def test_catch_trials_on_a_line_do_not_count_for_the_balance_of_its_order(tmp_path):
    path = tmp_path / "line.toml"
    line = STUDY.format(participants=20, rule="williams", keys="").replace(
        'protocol = "magnitude_estimation"', 'protocol = "visual_analogue_scale"\ncatch_trials = 3'
    )
    path.write_text(line)
    said = validate(str(path))
    assert "visualanalogue, williams: 20 blocks in 20 runs are balanced" in said
    assert "each surface follows every other surface 4 times" in said


def test_rules_that_draw_each_order_by_itself_are_balanced_on_average(study):
    assert "blocked: orders are drawn independently and are balanced on average" in validate(
        study(rule="blocked")
    )


def test_transitions_across_blocks_count_where_orders_are_drawn_by_themselves():
    options = MagnitudeEstimation(protocol="magnitude_estimation", randomisation="blocked")
    said = order_balance(options, "ab", [["ab", "ab"], ["ab", "ab"]])
    assert said.endswith("each surface follows every other surface 2 to 4 times")


def test_one_surface_has_no_order_to_balance():
    options = MagnitudeEstimation(protocol="magnitude_estimation")
    assert "no order" in order_balance(options, "a", [["a"]])


@pytest.mark.parametrize(
    "first, said",
    [
        ("ab", "task order: a first in 1 run, b first in 1 run"),
        (
            "aba",
            (
                "task order: a first in 2 runs, b first in 1 run; "
                "an even number of runs would be balanced"
            ),
        ),
    ],
)
def test_the_balance_of_task_orders_is_told(first, said):
    assert task_balance(first) == said


def test_show_tells_the_orders_of_a_session_and_run(study, capsys):
    name = study(keys='sessions = ["pre", "post"]\ntask_order = "counterbalanced"')
    drawn = []
    for session in ("pre", "post"):
        assert main(["study", "show", name, "--participant", "P03", "--session", session]) == 0
        drawn.append(capsys.readouterr().out)
    assert "session pre, run 01: position 3 in the counterbalancing, visit 1\n" in drawn[0]
    assert "session post, run 01: position 3 in the counterbalancing, visit 2\n" in drawn[1]
    assert drawn[0].splitlines()[-1] != drawn[1].splitlines()[-1]
    assert main(["study", "show", name, "--participant", "P03"]) == 0
    assert capsys.readouterr().out == drawn[0]


def test_a_session_that_is_not_planned_has_no_orders_to_show(study):
    with pytest.raises(UserError, match="--session 'mid'"):
        show(study(keys='sessions = ["pre", "post"]'), "01", "mid")


def test_a_study_whose_orders_cannot_be_drawn_is_not_valid(tmp_path):
    path = tmp_path / "one.toml"
    path.write_text(
        'name = "one"\ntitle = "One"\namplitudes_um_pp = [1.0]\n'
        '[[tasks]]\nprotocol = "magnitude_estimation"\nrepetitions = 2\n'
    )
    with pytest.raises(UserError, match="a single surface"):
        validate(str(path))


def test_a_pilot_has_every_planned_session_and_run(study):
    plans = pilot_plans(
        study(participants=2, keys='sessions = ["pre", "post"]\nruns = 2'),
        participants=None,
        seed=None,
        language=None,
    )
    assert [(p.participant, p.session, p.run) for p in plans[:5]] == [
        ("01", "pre", "01"),
        ("01", "pre", "02"),
        ("01", "post", "01"),
        ("01", "post", "02"),
        ("02", "pre", "01"),
    ]


LARGE = """name = "large"
title = "Large"
amplitudes_um_pp = [0.0, 1.2]
participants = 1000
runs = 1000
[[tasks]]
protocol = "magnitude_estimation"
repetitions = {repetitions}
"""


def test_validate_reports_how_much_of_each_texture_plate_and_friction_follow():
    said = validate("textures_demo").splitlines()
    # 50 mm/s over 2.5 mm are 20 Hz, over 10 mm 5 Hz; the film's lag is 27 Hz.
    assert "texture fine: 20 Hz at 50 mm/s" in said[1]
    assert said[1].endswith(
        "reproduces 100% of a sinusoidal depth, friction from the film model 80%"
    )
    assert "texture coarse: 5 Hz" in said[2]
    assert said[2].endswith("friction from the film model 98%")


def test_the_balance_of_a_huge_study_is_told_of_its_first_runs(tmp_path):
    path = tmp_path / "large.toml"
    path.write_text(LARGE.format(repetitions=100))
    said = validate(str(path)).splitlines()
    assert said[1] == "the first 99 of 1000000 runs:"
    assert "here each surface follows every other surface 9850 to 9851 times" in said[2]


def test_a_run_that_nobody_can_finish_is_refused(tmp_path):
    path = tmp_path / "large.toml"
    amplitudes = ", ".join(f"{each / 50}" for each in range(50))
    path.write_text(LARGE.format(repetitions=1000).replace("0.0, 1.2", amplitudes))
    for command in (validate, lambda name: show(name, "01")):
        with pytest.raises(UserError, match="a run has 50,050 trials; expected at most 10,000"):
            command(str(path))


@pytest.mark.parametrize(
    "line, told",
    [
        ("catch_steps = 100000000000000000000000000", "catch_steps of .*: expected 1000 or less"),
        ("spatial_period_mm = 1e308", "spatial_period_mm of .*: expected 1000 or less"),
    ],
)
def test_numbers_beyond_reason_are_named(tmp_path, line, told):
    path = tmp_path / "beyond.toml"
    text = study_text("textures_demo") if "mm" in line else study_text("biet2007")
    key = line.partition(" ")[0]
    path.write_text(re.sub(rf"(?m)^{key} = .*$", line, text, count=1))
    assert line in path.read_text()
    with pytest.raises(UserError, match=told):
        validate(str(path))


def test_the_orders_of_all_participants_are_a_field_of_colours(study, tmp_path):
    figure = orders_of_all(study(participants=3))
    field = np.asarray(figure.axes[0].get_images()[0].get_array())
    # Five for practice and five main ones; then the descent with its catch step.
    assert field.shape == (3, 15)
    assert (np.sort(field[:, 5:10], axis=1) == [0.0, 0.5, 1.0, 1.5, 2.0]).all()
    told = show(study(participants=3), "02").splitlines()
    (line,) = (line for line in told if "magnitudeestimation " in line and "(" in line)
    amplitudes = [float(each.strip("()")) for each in line.split()[1:]]
    assert field[1, :10].tolist() == amplitudes
    assert main(["study", "show", study(), "--figure", str(tmp_path / "orders.png")]) == 0
    assert (tmp_path / "orders.png").stat().st_size > 1000
    assert main(["study", "show", study(), "--figure", str(tmp_path / "orders.doc")]) == 2


def test_a_new_study_asks_for_title_authors_and_licence(tmp_path, monkeypatch, capsys):
    replies = iter(["Ours", "Ada, Bo", "CC0-1.0"])
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True)
    monkeypatch.setattr("builtins.input", lambda _question: next(replies))
    monkeypatch.chdir(tmp_path)
    assert main(["study", "new", "ours.toml"]) == 0
    assert "edit it, then" in capsys.readouterr().out
    study = read_study("ours.toml")[0]
    assert (study.title, study.authors, study.license) == ("Ours", ("Ada", "Bo"), "CC0-1.0")
    monkeypatch.setattr(sys.stdin, "isatty", lambda: False)
    assert main(["study", "new", "bare.toml"]) == 0
    assert "enter its authors and license and edit it" in capsys.readouterr().out
    assert read_study("bare.toml")[0].license == "not decided"
