"""Control of the stroke: windows, what the participant is told, rejection and repetition."""

import json
from types import SimpleNamespace

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.running.pilot import run_pilot, run_simulated
from slipscale.experiments.running.rehearsal import dry_run
from slipscale.experiments.session.progress import Progress
from slipscale.experiments.session.stroke_control import StrokeControl
from slipscale.experiments.steps.screens.scene import Disc
from slipscale.experiments.steps.steps import Explore, Guide
from slipscale.experiments.steps.trial import Trial
from slipscale.experiments.study.file import parse_study
from slipscale.experiments.study.stroke import Stroke, Stroked
from slipscale.faults import UserError
from slipscale.hardware.contact.measures import movement
from slipscale.hardware.contact.source import Sample

STUDY = """
name = "stroke"
title = "A stroke that is controlled"
seed = 3
participants = 1
amplitudes_um_pp = [0.0, 1.2, 2.3]
[plate]
position = "lasers:/dev/nowhere"
force = "load_cells:/dev/nowhere"
[stroke]
speed_mm_s = 80.0
speed_share = 0.06
repeat = 1
[[tasks]]
protocol = "magnitude_estimation"
repetitions = 2
practice = 0
"""


@pytest.mark.parametrize(
    "found, outside",
    [
        (Stroked(speed_mm_s=100.0, normal_n=0.5, forward_share=1.0), ()),
        (Stroked(speed_mm_s=69.9), ("too_slow",)),
        (Stroked(speed_mm_s=130.1, normal_n=0.29), ("too_fast", "too_light")),
        (Stroked(normal_n=0.71, forward_share=0.7), ("too_hard", "other_direction")),
        (Stroked(), ()),
    ],
)
def test_an_exploration_is_compared_with_what_was_measured(found, outside):
    stroke = Stroke(speed_mm_s=100.0, normal_force_n=0.5, direction="forward")
    assert stroke.outside(stroke.guide({}), found) == outside


@pytest.mark.parametrize(
    "speed_mm_s, feedback_s, text", [(80.0, 2.0, None), (30.0, 2.0, "slow"), (30.0, 0.0, None)]
)
def test_only_an_outside_stroke_is_followed_by_feedback_if_the_study_wants_it(
    speed_mm_s, feedback_s, text
):
    stroke = Stroke(speed_mm_s=80.0, feedback_s=feedback_s)
    control = StrokeControl(
        stroke, SimpleNamespace(append=lambda *_, **__: None), {"session.stroke_too_slow": "slow"}
    )
    times_s = [0.01 * each for each in range(100)]
    samples = [Sample(time_s=at_s, values=(speed_mm_s * at_s, 0.0)) for at_s in times_s]
    step = Explore(text="", trial=Trial(task="a", number=1, total=1), guide=stroke.guide({}))
    told = control.judged(step, {"position": samples})
    assert (told and told.text) == text


def test_a_factor_replaces_the_speed_in_its_conditions():
    guide = Stroke(speed_mm_s=80.0).guide({"finger_speed_mm_s": 50.0, "force": "firm"})
    assert (guide.speed_mm_s, guide.normal_force_n) == (50.0, None)


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("speed_share = 0.06", "pacer = false", r"stroke\.speed_mm_s: expected position"),
        ("speed_share = 0.06", 'direction = "forward"', r"stroke\.direction: expected position"),
        ("speed_share = 0.06", "normal_force_n = 0.5", r"stroke\.normal_force_n: expected force"),
    ],
)
def test_a_window_that_nothing_measures_is_rejected(old, new, message):
    text = STUDY.replace("position =", "# ").replace("force =", "# ").replace(old, new)
    with pytest.raises(UserError, match=message):
        parse_study(text, "stroke.toml")


def test_the_direction_is_the_share_of_the_path():
    ends = (0.0, 30.0, 20.0)
    places = [Sample(n / 10, (x, 0.0)) for n, x in enumerate(ends)]
    assert movement(places).forward_share == 0.75


@pytest.mark.parametrize(
    "direction, places",
    [
        ("any", [0.0, 0.5, 1.0, 0.5]),
        ("forward", [0.0, 0.5, 0.0, 0.5]),
        ("backward", [1.0, 0.5, 1.0, 0.5]),
    ],
)
def test_the_mark_moves_at_the_speed_and_turns_at_the_ends(direction, places):
    guide = Guide(
        speed_mm_s=80.0, normal_force_n=None, direction=direction, stroke_mm=40.0, pacer=True
    )
    assert [guide.place_share(n / 4) for n in range(4)] == places
    screen = screen_for(Explore(text="Stroke.", guide=guide), load_texts("en"))
    (mark,) = (item for item in screen.scene(0.25) if isinstance(item, Disc))
    assert mark.x == pytest.approx(0.8 * (places[1] - 0.5))


def test_every_exploration_states_the_stroke_and_a_study_without_one_is_as_before(plan):
    steps = [each for each in dry_run(plan(STUDY)) if isinstance(each, Explore)]
    assert {each.guide.speed_mm_s for each in steps} == {80.0}
    free = STUDY[: STUDY.index("[stroke]")] + STUDY[STUDY.index("[[tasks]]") :]
    assert all(each.guide is None for each in dry_run(plan(free)) if isinstance(each, Explore))


def rows(folder):
    (table,) = folder.glob("sub-01/beh/*_beh.tsv")
    header, *lines = table.read_text("utf-8").splitlines()
    return [dict(zip(header.split("\t"), line.split("\t"), strict=True)) for line in lines]


@pytest.fixture(scope="module")
def made_plan(request):
    return request.getfixturevalue("plan")(STUDY, seed=3, study_name="stroke")


@pytest.fixture(scope="module")
def whole(tmp_path_factory, made_plan):
    folder = tmp_path_factory.mktemp("whole")
    run_pilot(folder, [made_plan], tell=lambda _: None)
    return folder


def test_trials_outside_are_rejected_and_repeated_once_and_the_data_state_why(whole):
    found = rows(whole)
    outside = [row for row in found if row["stroke"] != "within"]
    assert outside
    for row in outside:
        speed = float(row["exploration_speed_mm_s"])
        assert row["stroke"] == ("too_slow" if speed < 80 else "too_fast")
        assert abs(speed - 80) > 4.8
        assert "voided" in row["flag"]
    first = [row["trial"] for row in outside if row["repeats"] == "n/a"]
    repeated = [row["repeats"] for row in found if row["repeats"] != "n/a"]
    assert sorted(repeated) == sorted(first)  # a repetition is not repeated again
    assert len(found) == 6 + len(first)
    (sidecar,) = whole.glob("sub-01/beh/*_beh.json")
    reasons = json.loads(sidecar.read_text())["Slipscale"]["voided"]
    assert {each["reason"] for each in reasons} <= {"stroke: too_slow", "stroke: too_fast"}


def test_a_session_killed_around_a_rejection_goes_on_to_the_same_data(whole, made_plan, tmp_path):
    lines = made_plan.journal_path(whole).read_bytes().splitlines(keepends=True)
    kinds = [json.loads(line)["kind"] for line in lines]
    outside = next(
        n for n, line in enumerate(lines) if kinds[n] == "stroke" and json.loads(line)["outside"]
    )
    dropped = next(n for n, line in enumerate(lines) if b'"repeated":false' in line)
    for cut in (outside + 1, kinds.index("void") + 1, dropped + 1):
        folder = tmp_path / str(cut)
        path = made_plan.journal_path(folder)
        path.parent.mkdir(parents=True)
        path.write_bytes(b"".join(lines[:cut]))
        run_simulated(folder, made_plan, "mock")
        build_dataset(folder)
        told = [
            {name: row[name] for name in ("trial", "stroke", "repeats", "flag", "estimate")}
            for row in rows(folder)
        ]
        assert told == [{name: row[name] for name in told[0]} for row in rows(whole)]


def test_a_resumed_session_expects_only_trials_that_are_repeated(
    whole, made_plan, tmp_path, monkeypatch
):
    lines = made_plan.journal_path(whole).read_bytes().splitlines(keepends=True)
    dropped = next(n for n, line in enumerate(lines) if b'"repeated":false' in line)
    path = made_plan.journal_path(tmp_path)
    path.parent.mkdir(parents=True)
    path.write_bytes(b"".join(lines[: dropped + 1]))
    voids = [line for line in lines[: dropped + 1] if json.loads(line)["kind"] == "void"]
    expected = []

    class Told(Progress):
        def __init__(self, *args, **settings):
            expected.append(settings["status"].voided)
            super().__init__(*args, **settings)

    monkeypatch.setattr("slipscale.experiments.session.session.Progress", Told)
    run_simulated(tmp_path, made_plan, "mock")
    assert expected == [len(voids) - 1]


def test_without_rejection_the_column_states_the_outcome(plan, tmp_path):
    text = STUDY.replace("repeat = 1", "reject = false")
    run_pilot(tmp_path, [plan(text, seed=3)], tell=lambda _: None)
    found = rows(tmp_path)
    assert len(found) == 6
    assert {row["flag"] for row in found} == {"n/a"}
    assert any(row["stroke"] != "within" for row in found)
