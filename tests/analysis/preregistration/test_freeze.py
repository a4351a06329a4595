"""A plan: all that it holds, the same bytes for the same study, and what cannot be frozen."""

import json
import zipfile
from dataclasses import replace
from datetime import UTC, datetime
from hashlib import sha256

import pytest

from slipscale import commands
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.preregistration.bundle import read_bundle, write_bundle
from slipscale.analysis.preregistration.freeze import Wanted, freeze
from slipscale.analysis.preregistration.manifest import MANIFEST
from slipscale.analysis.preregistration.plan_in_words import plan_blocks
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.study.analysis_choices import AnalysisChoices, Thresholds

NOON = datetime(2026, 11, 22, 12, tzinfo=UTC)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Work in a folder that holds what is no power result, and a file."""
    (tmp_path / "odd").mkdir()
    (tmp_path / "odd" / "power.json").write_text("[]")
    (tmp_path / "file.txt").write_text("")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def wanted(root, **more):
    return Wanted(study_name=str(root / "small.toml"), population=Population(), **more)


def test_every_file_has_its_sha_256_and_the_digest_stands_for_all(frozen):
    told = json.loads((frozen / "plan" / MANIFEST).read_text())
    for file in told["files"]:
        content = (frozen / "plan" / file["path"]).read_bytes()
        assert file["sha256"] == sha256(content).hexdigest()
    there = {p.relative_to(frozen / "plan").as_posix() for p in (frozen / "plan").rglob("*.*")}
    assert there == {file["path"] for file in told["files"]} | {MANIFEST}
    digest = told.pop("digest")
    assert digest == sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


def test_the_file_that_the_study_names_is_in_it(frozen):
    (named,) = [file for file in read_bundle(frozen / "plan").manifest.files if file.named_by]
    assert (named.path, named.named_by) == ("study/files/words.toml", "analysis.codebook")
    assert (frozen / "plan" / named.path).read_bytes() == (frozen / "words.toml").read_bytes()


def test_the_same_plan_has_the_same_bytes_but_for_the_date(frozen, tmp_path):
    one, two = freeze(wanted(frozen), NOON)[1], freeze(wanted(frozen), NOON)[1]
    assert one == two
    other = freeze(wanted(frozen), NOON.replace(hour=13))[1]
    assert {name for name in one if one[name] != other[name]} == {MANIFEST, "plan.html"}
    for name in ("a.zip", "b.zip"):
        write_bundle(tmp_path / name, one)
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()


def test_folder_and_zip_hold_the_same(frozen):
    with zipfile.ZipFile(frozen / "plan.zip") as archive:
        names = set(archive.namelist())
    assert names == {
        p.relative_to(frozen / "plan").as_posix() for p in (frozen / "plan").rglob("*.*")
    }
    one, other = read_bundle(frozen / "plan"), read_bundle(frozen / "plan.zip")
    assert one.study_text == other.study_text == (frozen / "small.toml").read_text()


def test_the_page_says_tests_corrections_choices_and_versions(frozen):
    page = (frozen / "plan" / "plan.html").read_text()
    for words in (
        "The primary analysis consists of the tests on ranks",
        "Holm, within the family",
        "scale_top: each estimate divided by the declared top of its participant&#39;s scale",
        "Data are collected from 4 participants, whatever the results",
        "No rule excludes participants",
        "study/files/words.toml",
    ):
        assert words in page
    assert "page_trend" not in page  # not chosen by the study


def test_exclusions_are_said_with_their_limits(frozen):
    analysis = analyse(frozen / "data")
    choices = AnalysisChoices(
        exclusions=("fast", "zeros"), thresholds=Thresholds(fast_share=0.125, zero_share=0.375)
    )
    data = replace(analysis.dataset, choices=choices)
    text = str(plan_blocks(replace(analysis, dataset=data), {}))
    assert "many estimates of zero (zero_share = 0.375)" in text
    assert "answers too fast to be deliberate (fast_share = 0.125, fast_s = 0.2)" in text


def test_notes_and_a_stopping_rule_are_taken_in(frozen, tmp_path):
    (tmp_path / "notes.md").write_text("H1: a <b>rise</b>.\n\nH2: none.\n")
    plan, files = freeze(
        wanted(frozen, notes=tmp_path / "notes.md", stopping_rule="After Christmas."), NOON
    )
    page = files["plan.html"].decode()
    assert "H1: a &lt;b&gt;rise&lt;/b&gt;." in page
    assert plan.stopping_rule == "After Christmas."
    assert "After Christmas." in page
    assert "whatever the results" not in page


def test_the_page_answers_what_registries_ask(frozen):
    page = freeze(wanted(frozen, existing_data="None.", sample_size="As in 2007."), NOON)[1][
        "plan.html"
    ].decode()
    for words in (
        "Existing data",
        "None.",
        "Vibration amplitude of the plate: 0, 1.2, 2.3 µm peak to peak.",
        "(task magnitudeestimation, column estimate)",
        "As in 2007.",
        "Rule for zeros: exclude",
        "Friedman",
    ):
        assert words in page, words
    unstated = (frozen / "plan" / "plan.html").read_text()
    assert "Not stated; use slipscale study freeze --existing-data TEXT to state it." in unstated


def test_a_power_below_the_target_gets_a_remark(frozen, tmp_path):
    power = {"study": "small", "target": 0.8, "conditions": [{"participants": 4, "weakest": 0.0}]}
    (tmp_path / "power.json").write_text(json.dumps(power))
    page = freeze(wanted(frozen, power=tmp_path), NOON)[1]["plan.html"].decode()
    assert "every planned comparison is significant in 0% of simulated studies" in page
    power["conditions"][0]["weakest"] = 0.8
    (tmp_path / "power.json").write_text(json.dumps(power))
    page = freeze(wanted(frozen, power=tmp_path), NOON)[1]["plan.html"].decode()
    assert "every planned comparison is significant" not in page


def test_the_power_is_computed_or_taken_in(frozen, tmp_path, capsys):
    study = str(frozen / "small.toml")
    out, again = tmp_path / "plan", tmp_path / "again"
    words = ["study", "freeze", study, "--out", str(out), "--compute-power", "20"]
    assert commands.main(words) == 0
    told = json.loads((out / "power" / "power.json").read_text())
    assert [each["participants"] for each in told["conditions"]] == [3, 4, 5]
    assert 'src="power/power.svg"' in (out / "plan.html").read_text()
    words = ["study", "freeze", study, "--out", str(again), "--power", str(out / "power")]
    assert commands.main(words) == 0
    assert (again / "power" / "power.csv").read_bytes() == (
        out / "power" / "power.csv"
    ).read_bytes()
    capsys.readouterr()
    words = ["study", "freeze", "biet2007", "--out", str(tmp_path / "b"), "--power", words[-1]]
    assert commands.main(words) == 2
    assert "belongs to study 'small'; expected 'biet2007'" in capsys.readouterr().err


@pytest.mark.parametrize(
    "options, sentence",
    [
        (["--out", "."], "already exists; a plan is frozen only once"),
        (["--out", "new", "--notes", "none.md"], "--notes none.md: No such file"),
        (["--out", "new", "--power", "none"], "expected the folder that slipscale power --out"),
        (["--out", "new", "--power", "odd"], "power.json is not a result of slipscale power"),
        (["--out", "new", "--power", "odd", "--compute-power", "9"], "expected only one of them"),
        (["--out", "file.txt/new"], "file.txt is a file; name a folder"),
    ],
)
def test_what_cannot_be_frozen_is_told_in_a_sentence(frozen, here, capsys, options, sentence):
    assert commands.main(["study", "freeze", str(frozen / "small.toml"), *options]) == 2
    told = capsys.readouterr().err
    assert sentence in told
    assert told.count("\n") == 1
    assert sorted(path.name for path in here.iterdir()) == ["file.txt", "odd"]
