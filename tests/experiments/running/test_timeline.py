"""The timeline is what full sessions take, and its plate-on time what the plate did."""

import itertools
import json

import pytest

from slipscale import commands
from slipscale.experiments.journal.plan_and_progress import elapsed_s, read_plan
from slipscale.experiments.participants.simulated_people.bare_run import BareStep
from slipscale.experiments.running.pilot import pilot_plans, run_simulated
from slipscale.experiments.running.timeline import _Visit, timeline
from slipscale.experiments.running.timeline_figure import timeline_figure
from slipscale.experiments.steps.steps import Explore, Present, Silence
from slipscale.experiments.steps.trial import Trial
from slipscale.experiments.study.file import study_text
from slipscale.stimuli.surface import VirtualSurface

COST = "\n[cost]\nper_person = 12.0\nper_rig_hour = 40.0\nsetup_minutes = 15.0\n"


def test_minutes_are_those_of_full_sessions_of_the_same_people(tmp_path):
    found = timeline("biet2007", people=5)
    minutes = []
    for plan in pilot_plans("biet2007", participants=5, seed=None, language=None):
        run_simulated(tmp_path, plan, "mock")
        minutes.append(elapsed_s(read_plan(plan.journal_path(tmp_path))[1]) / 60)
    # The last screen is read after the last step has begun.
    assert found.total_min.p50 == pytest.approx(sorted(minutes)[2], abs=0.15)
    parts = [part for part, _ in found.parts]
    assert parts == [
        "welcome, consent and questions",
        "Descending difference",
        "Magnitude estimation of slipperiness, practice",
        "Magnitude estimation of slipperiness",
    ]


def visited(*steps):
    visit = _Visit()
    for step, duration_s in steps:
        visit.take("", BareStep(step, None, duration_s))
    visit.end()
    return visit


def present(level):
    return Present(surface=VirtualSurface(level=level))


def test_the_plate_is_on_from_a_vibrating_surface_to_the_silence():
    explore = Explore(text="", trial=Trial(task="t", number=1, total=1))
    visit = visited(
        (present(2.3), 0.0), (explore, 10.0), (present(1.2), 0.0), (explore, 5.0), (Silence(), 0.0),
        (explore, 100.0),
        (present(0.0), 0.0), (explore, 7.0), (Silence(), 0.0),
        (present(1.2), 0.0), (explore, 20.0),
    )  # fmt: skip
    assert visit.exposures == 3
    assert visit.on_s == pytest.approx(35, abs=0.3)
    assert visit.longest_on_s == pytest.approx(20, abs=0.1)
    assert visit.duty(1000.0) == pytest.approx(0.035, abs=0.001)
    assert visit.duty(20.0) == pytest.approx(1.0, abs=0.01)


def test_the_cost_is_that_of_person_and_rig(tmp_path):
    file = tmp_path / "paid.toml"
    file.write_text(study_text("biet2007") + COST, encoding="utf-8")
    found = timeline(str(file), people=20)
    hours = (found.total_min.p50 + 15) / 60
    assert found.cost_each.p50 == pytest.approx(12 + 40 * hours, rel=1e-6)
    assert found.cost_total.p50 == pytest.approx(12 * found.cost_each.p50, rel=0.02)
    assert timeline("biet2007", people=3).cost_each is None


def test_the_command_prints_the_table_and_draws_it(capsys, tmp_path):
    figure = tmp_path / "time.svg"
    words = ["study", "show", "--timeline", "--people", "5", "--figure", str(figure)]
    assert commands.main(words) == 0
    lines = capsys.readouterr().out.splitlines()
    heads = ["Timeline for a participant", "minutes", "welcome"]
    assert all(line.startswith(head) for line, head in itertools.zip_longest(lines[:3], heads))
    assert any("the study file has no [cost] table" in line for line in lines)
    assert "plate vibrating" in figure.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "words", [["--people", "0"], ["--figure", "time.doc"], ["--figure", "/no/such/folder/t.svg"]]
)
def test_nonsense_is_refused_in_a_sentence(capsys, words):
    assert commands.main(["study", "show", "--timeline", "--people", "1", *words]) == 2
    assert words[0] in capsys.readouterr().err


def test_matching_has_a_timeline_too(capsys):
    assert commands.main(["study", "show", "matching", "--timeline", "--people", "1"]) == 0
    assert "Matching by adjustment" in capsys.readouterr().out


def test_the_timeline_is_told_as_json_for_other_people_too(capsys):
    words = ["study", "show", "biet2007", "--timeline", "--people", "12", "--json"]
    assert commands.main(words) == 0
    plain = json.loads(capsys.readouterr().out)
    assert plain["parts"][-1]["part"] == "Magnitude estimation of slipperiness"
    assert plain["parts"][-1]["p5"] <= plain["parts"][-1]["p95"]
    assert plain["total_min"]["p50"] == timeline("biet2007", people=12).total_min.p50
    assert plain["cost_each"] is None
    assert commands.main([*words, "--population", "realistic"]) == 0
    realistic = json.loads(capsys.readouterr().out)
    # Who gives up goes through less; nobody goes through more.
    assert realistic["total_min"]["p5"] <= plain["total_min"]["p5"]
    assert realistic != plain


@pytest.mark.parametrize(
    "words, expected",
    [
        (["--json"], "--json requires --timeline"),
        (["--population", "realistic"], "--population requires --timeline"),
        (["--timeline", "--population", "nobody"], "'nobody'"),
    ],
)
def test_options_of_the_timeline_are_refused_in_a_sentence(capsys, words, expected):
    assert commands.main(["study", "show", "biet2007", *words]) == 2
    said = capsys.readouterr().err
    assert expected in said
    assert said.count("\n") == 1


def test_the_figure_has_minutes_limits_and_where_it_is_known_the_cost(tmp_path):
    found = timeline("biet2007", people=6)
    assert len(timeline_figure(found).axes) == 2
    file = tmp_path / "study.toml"
    file.write_text(study_text("biet2007") + COST)
    priced = timeline_figure(timeline(str(file), people=6))
    assert len(priced.axes) == 3
    line = priced.axes[2].get_lines()[0]
    each = timeline(str(file), people=6).cost_total.p50 / 12
    assert line.get_ydata()[5] == pytest.approx(5 * each)
