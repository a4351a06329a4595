"""Published experiments as studies: each runs with every kind of answer, and states its source."""

import re
import tomllib
from importlib.resources import files
from pathlib import Path

import pytest

from slipscale.experiments.participants.simulated_people.growth import D_AT_75_PERCENT, people_for
from slipscale.experiments.participants.simulated_people.population import curves
from slipscale.experiments.running.rehearsal import dry_run
from slipscale.experiments.study.file import parse_study, shipped_studies, study_text
from slipscale.faults import UserError

TABLE = Path(__file__).parents[3] / "docs" / "tutorials" / "published-studies.toml"
PUBLISHED = tomllib.loads(TABLE.read_text("utf-8"))


def test_every_study_named_after_a_year_has_a_row_and_every_row_a_study():
    named = {name for name in shipped_studies() if re.search(r"\d{4}", name)} - {"biet2007"}
    assert set(PUBLISHED) == named
    folder = files("slipscale.experiments").joinpath("studies", "published")
    assert {entry.name for entry in folder.iterdir()} == {f"{name}.toml" for name in named}
    columns = {"task", "published", "simulated", "recovered"}
    assert all(set(row) == columns for row in PUBLISHED.values())


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_published_study_states_its_source_and_what_is_assumed_and_has_trials(name, plan):
    text = study_text(name)
    source = text.split("name =")[0]
    author, year = re.match(r"(\D+)(\d{4})", name).groups()
    assert author in source.lower().replace("ş", "s")
    assert year in source
    assert re.search("abstract|reference|not available", source)
    assert "published-studies.md" in source
    people = people_for(parse_study(text, name)).model_dump_json()
    made = plan(text, study_name=name, population=people)
    trials = {step.trial.number for step in dry_run(made) if step.trial}
    assert 14 <= len(trials) <= 250


def test_a_stated_weber_fraction_is_that_of_simulated_people():
    study = parse_study(study_text("samur2009"), "samur2009")
    people = people_for(study)
    curve = curves(people)
    step = curve.mean(1.2 * 1.18) - curve.mean(1.2)
    assert step / people.noise == pytest.approx(D_AT_75_PERCENT, rel=0.02)
    other = study_text("samur2009").replace("weber = 0.18", "weber = 1.8")
    with pytest.raises(UserError, match=r"simulated\.weber: expected a number below 1"):
        parse_study(other, "samur2009")
