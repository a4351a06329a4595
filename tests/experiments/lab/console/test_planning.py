"""The page of planning: conditions of a computed grid, minutes and cost, and the frozen plan."""

import json
import re
import zipfile

from slipscale.commands import main
from slipscale.experiments.lab.console.actions.folder import GRID, power_folder
from slipscale.experiments.lab.console.actions.forms import unused
from slipscale.experiments.lab.console.state import PLANNING, frozen_plans
from slipscale.experiments.study.file import study_text


def computed(text, weakest, equal=()):
    """Write what slipscale power writes for the text: the weakest power of each condition."""
    conditions = [
        {
            "participants": people,
            "repetitions": repetitions,
            "effect": 1.0,
            "weakest": value,
            "power": {"friedman": {"value": value, "low": 0.0, "high": 1.0}},
            "false_alarms": {"friedman": {"value": 0.05}},
        }
        for (people, repetitions), value in weakest.items()
    ]
    folder = power_folder(text)
    folder.mkdir(parents=True, exist_ok=True)
    written = {"target": 0.8, "conditions": conditions, "equal_effects": list(equal)}
    (folder / "power.json").write_text(json.dumps(written))


def test_power_is_computed_for_the_study_by_a_process(visitor):
    assert visitor.ask("power") == (200, "computing")
    out = str(power_folder(study_text("biet2007")))
    words = ("power", "biet2007", *GRID, "--steps", "--json", "--out", out)
    assert visitor.jobs.started == [("power", *words)]


def test_the_sliders_choose_a_condition_of_the_grid(visitor, words_of):
    assert "has not been computed yet" in words_of(visitor.see("/planning"))
    computed(study_text("biet2007"), {(12, 1): 0.6, (20, 1): 0.85, (12, 2): 0.7, (20, 2): 0.9})
    page = words_of(visitor.see("/planning"))
    assert "60 % of simulated studies" in page  # the study's own number of participants
    assert "At least 20 participants are needed to reach the target" in page
    page = visitor.see("/planning?participants=1&repetitions=1")
    assert "90 % of simulated studies" in words_of(page)
    assert re.findall(r"<output>(.*?)</output>", page) == ["20", "2", "1"]
    each, hours = (float(v) for v in re.findall(r"<dd>([\d.]+)</dd>", page)[:2])
    assert abs(hours - each * 20 / 60) <= 0.05 + 20 / 60 * 0.05
    assert "the study file has no [cost] table" in words_of(page)


def test_a_number_of_participants_that_was_not_simulated_opens_the_nearest(visitor, lab, words_of):
    text = study_text("biet2007").replace("participants = 12", "participants = 10")
    (lab / "mine.toml").write_text(text)
    (lab / "slipscale.toml").write_text('study = "mine.toml"\nplate = "serial:COM9"\n')
    visitor.console.state.now(fresh=True)
    computed(text, {(6, 1): 0.0, (8, 1): 0.95, (40, 1): 1.0})
    words = words_of(visitor.see("/planning"))
    assert "95 % of simulated studies" in words
    assert "With fewer than 8 participants, no rank test of a pair can be significant" in words
    assert visitor.ask("power")[0] == 200
    assert visitor.jobs.started[0][3:6] == ("--participants", "10", "6")


def test_equal_effects_in_everyone_are_a_warning(visitor, words_of):
    computed(study_text("biet2007"), {(12, 1): 0.6}, equal=("speed",))
    page = words_of(visitor.see("/planning"))
    assert "All simulated people have the same effect of speed. Power is lower" in page
    computed(study_text("biet2007"), {(12, 1): 0.6})
    assert "same effect" not in words_of(visitor.see("/planning"))


def test_another_text_of_the_study_has_no_power_yet(visitor, lab, words_of):
    (lab / "mine.toml").write_text(study_text("biet2007").replace("2007", "2008"))
    computed(study_text("biet2007"), {(12, 1): 0.6})
    (lab / "slipscale.toml").write_text('study = "mine.toml"\n')
    visitor.console.state.now(fresh=True)
    assert "has not been computed yet" in words_of(visitor.see("/planning"))


def test_a_plan_is_frozen_with_the_power_and_what_a_registry_asks(visitor, lab):
    computed(study_text("biet2007"), {(12, 1): 0.6})
    asked = {"sample_size": "- a reason", "existing_data": "none", "stopping": "after 12"}
    for empty in asked:
        assert "answer all three questions" in visitor.ask("freeze", **asked | {empty: " "})[1]
    assert visitor.ask("freeze", **asked)[0] == 200
    [(_, *words)] = visitor.jobs.started
    power = str(power_folder(study_text("biet2007")))
    stated = ["--sample-size=- a reason", "--existing-data=none", "--stopping=after 12"]
    options = [*stated, "--power", power]
    assert words == ["study", "freeze", "biet2007", "--out", "planning/plan-001.zip", *options]
    (lab / "planning/plan-001.zip").write_bytes(b"PK")
    assert visitor.client.get("/planning/plan-001.zip").content == b"PK"
    assert visitor.client.get("/planning/plan-002.zip").status_code == 404
    visitor.ask("freeze", **asked)
    with zipfile.ZipFile(lab / "planning/plan-001.zip", "w") as bundle:
        bundle.writestr("manifest.json", json.dumps({"digest": "ab" * 32}))
    assert "ab" * 32 in visitor.see("/planning")
    assert "planning/plan-002.zip" in visitor.jobs.started[-1]


def test_power_tells_a_program_how_far_it_is(capsys):
    words = ["--participants", "6", "--studies", "5", "--steps", "--json"]
    main(["power", "biet2007", *words])
    steps = re.findall(r"step: (\d+)/(\d+)", capsys.readouterr().err)
    assert steps[-1][0] == steps[-1][1]


def test_a_new_plan_takes_no_name_that_another_has(tmp_path, monkeypatch):
    """Of plans 1 and 2, the first was deleted."""
    monkeypatch.chdir(tmp_path)
    PLANNING.mkdir()
    (PLANNING / "plan-002.zip").touch()
    name = f"{PLANNING}/plan-{{:03d}}.zip"
    assert unused(name, len(frozen_plans()) + 1) == PLANNING / "plan-003.zip"
