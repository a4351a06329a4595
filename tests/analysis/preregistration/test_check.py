"""Data and analysis beside a frozen plan: none or every deviation, and bundles that are none."""

import json
import re
import shutil
import zipfile
from dataclasses import replace

import pytest

from slipscale import commands
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.preregistration import check
from slipscale.analysis.preregistration.bundle import read_bundle
from slipscale.analysis.reporting.files import software
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.outside.short_form import OwnResult, own_analysis
from slipscale.experiments.dataset.hand_exclusions import decide
from slipscale.experiments.languages.texts import to_translate
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.bare_dataset import write_simulated
from slipscale.experiments.running.pilot import pilot_plans

pytestmark = pytest.mark.usefixtures("without_models")


def analysed(root, *options, plan="plan"):
    """Analyse a copy's data against a plan; return the exit status and the deviations by kind."""
    data = root / "data"
    status = commands.main(["analyse", str(data), "--plan", str(root / plan), *options])
    folder = data / "derivatives" / "slipscale"
    if "--in-session" in options:
        folder /= "ses-01"
    if "--task" in options:
        folder /= "task-magnitudeestimation"
    told = json.loads((folder / "results.json").read_text())["plan"]
    return status, without_journals([(one["kind"], one["what"]) for one in told["deviations"]])


def deviations(root):
    """Return the deviations by kind, without tables, figures and report."""
    found = check.check_plan(read_bundle(root / "plan"), analyse(root / "data"))
    return without_journals([(each.kind, each.what) for each in found.deviations])


def without_journals(found):
    """Return deviations except that the copy has no journals."""
    return [(kind, what) for kind, what in found if "contain no journals" not in what]


def edited(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


@pytest.mark.parametrize("plan", ["plan", "plan.zip"])
def test_what_is_done_as_planned_has_no_deviation(frozen, capsys, plan):
    assert analysed(frozen, plan=plan) == (0, [])
    report = (frozen / "data" / "derivatives" / "slipscale" / "report.html").read_text()
    assert f"There are no deviations from the plan {plan}" in report
    assert "does not detect journals or plans whose hashes were recomputed" in report
    assert f"plan: There are no deviations from the plan {plan}" in capsys.readouterr().err


def test_without_a_plan_nothing_is_said_of_one(frozen):
    assert commands.main(["analyse", str(frozen / "data")]) == 0
    folder = frozen / "data" / "derivatives" / "slipscale"
    assert "plan" not in json.loads((folder / "results.json").read_text())
    assert "Deviations from the plan" not in (folder / "report.html").read_text()


def study(root):
    return root / "data" / "code" / "study.toml"


def without_a_participant(root):
    shutil.rmtree(root / "data" / "sub-04")
    path = root / "data" / "participants.tsv"
    kept = [line for line in path.read_text().splitlines() if not line.startswith("sub-04")]
    path.write_text("\n".join(kept) + "\n")


def with_another(root):
    shutil.copytree(root / "data" / "sub-04", root / "data" / "sub-05")
    for path in sorted((root / "data" / "sub-05").rglob("sub-04*")):
        path.rename(path.with_name(path.name.replace("sub-04", "sub-05")))


def of_people(began):
    """Return what makes a pilot's tables those of people who came at a time."""

    def change(root):
        for path in (root / "data").glob("sub-*/**/*_beh.json"):
            told = json.loads(path.read_text())
            told["Slipscale"] |= {"mode": "participant", "started_utc": began}
            path.write_text(json.dumps(told))

    return change


def in_another_session(root):
    for path in sorted((root / "data").rglob("*ses-01*"), reverse=True):
        path.rename(path.with_name(path.name.replace("ses-01", "ses-02")))


def with_seed(root):
    for path in (root / "data").glob("sub-01/**/*_beh.json"):
        edited(path, '"seed": 3', '"seed": 9')


CHANGES = {
    "study key": (
        lambda root: edited(study(root), "repetitions = 2", "repetitions = 3"),
        "study",
        "study.toml: tasks.1.repetitions is 3; planned: 2.",
    ),
    "study key added": (
        lambda root: edited(study(root), "seed = 3", "seed = 3\nruns = 2"),
        "study",
        "study.toml: runs is 2; planned: left out.",
    ),
    "study damaged": (
        lambda root: (root / "data" / "code" / "study_2.toml").write_text("a = ["),
        "study",
        "study_2.toml cannot be read",
    ),
    "study gone": (lambda root: study(root).unlink(), "study", "contain no study file"),
    "seed": (with_seed, "study", "Some runs have seed 9; planned: 3."),
    "fewer": (
        without_a_participant,
        "participants",
        "3 participants have data; planned: 4 (1 fewer).",
    ),
    "more": (with_another, "participants", "5 participants have data; planned: 4 (1 more)."),
    "session missing": (
        in_another_session,
        "participants",
        "There are no data for the planned session 01.",
    ),
    "session more": (in_another_session, "participants", "session 02, which was not planned"),
    "before": (
        of_people("2007-12-01T09:00:00+00:00"),
        "dates",
        "4 of 4 runs began before the plan was frozen",
    ),
    "no date": (of_people("n/a"), "dates", "4 runs have no start time."),
    "exclusions": (
        lambda root: edited(study(root), "[analysis]", '[analysis]\nexclusions = ["zeros"]'),
        "exclusions",
        'analysis.exclusions was ["zeros"]; planned: [].',
    ),
    "limits": (
        lambda root: edited(study(root), "[analysis]", "[analysis]\nthresholds.zero_share = 0.5"),
        "exclusions",
        "analysis.thresholds.zero_share was 0.5; planned: 0.25.",
    ),
    "test more": (
        lambda root: edited(study(root), '"friedman"', '"friedman", "page_trend"'),
        "tests",
        "page_trend was computed but not planned.",
    ),
    "test less": (
        lambda root: edited(study(root), ', "power_law"', ""),
        "tests",
        "power_law was planned but has no result: not chosen in the study file.",
    ),
    "primary": (
        lambda root: edited(study(root), "[analysis]", '[analysis]\nprimary = "logarithms"'),
        "tests",
        'analysis.primary was "logarithms"; planned: "ranks".',
    ),
    "rule": (
        lambda root: edited(study(root), '"scale_top"\ntests', '"grand_maximum"\ntests'),
        "normalisation",
        "normalised by grand_maximum; planned: scale_top.",
    ),
    "codebook": (
        lambda root: edited(root / "data" / "words.toml", '"slip"', '"slid"'),
        "options",
        "The codebook words.toml differs from the frozen codebook.",
    ),
    "page": (
        lambda root: edited(root / "plan" / "plan.html", "whatever the results", "or so"),
        "bundle",
        "plan.html has changed since it was frozen: its SHA-256 differs.",
    ),
    "file gone": (
        lambda root: (root / "plan" / "population.json").unlink(),
        "bundle",
        "population.json is missing from the bundle.",
    ),
    "file more": (
        lambda root: (root / "plan" / "more.txt").write_text("more"),
        "bundle",
        "more.txt was added to the bundle.",
    ),
}


@pytest.mark.parametrize("change, kind, sentence", CHANGES.values(), ids=CHANGES)
def test_a_deviation_is_found(copied, change, kind, sentence):
    change(copied)
    found = deviations(copied)
    assert any(one == kind and sentence in what for one, what in found), found


def table(root, who="01"):
    (path,) = (root / "data" / f"sub-{who}").rglob("*_beh.tsv")
    return path


def another_estimate(root):
    header, first, *rest = table(root).read_text().splitlines()
    cells, place = first.split("\t"), header.split("\t").index("estimate")
    cells[place] = "77"
    table(root).write_text("\n".join([header, "\t".join(cells), *rest]) + "\n")


def a_row_less(root):
    table(root).write_text("\n".join(table(root).read_text().splitlines()[:-1]) + "\n")


def tables_swapped(root):
    one, two = table(root), table(root, "02")
    first = one.read_text()
    one.write_text(two.read_text())
    two.write_text(first)


TAMPERED = {
    "a changed estimate": (another_estimate, "row 2: estimate is '77'; the journal has"),
    "a deleted row": (a_row_less, "row 10: is missing"),
    "swapped tables": (tables_swapped, "estimate is"),
    "a removed journal": (
        lambda root: next((root / "data" / "sourcedata").rglob("*sub-01*.jsonl")).unlink(),
        "is not in any journal",
    ),
    "removed journals": (
        lambda root: shutil.rmtree(root / "data" / "sourcedata"),
        "The data contain no journals (sourcedata/)",
    ),
}


@pytest.mark.parametrize("change, sentence", TAMPERED.values(), ids=TAMPERED)
def test_edited_data_are_a_deviation(whole, change, sentence):
    change(whole)
    found = check.check_plan(read_bundle(whole / "plan"), analyse(whole / "data"))
    told = [each.what for each in found.deviations if each.kind == "data"]
    assert any(sentence in what for what in told), told
    assert len(told) <= check.MOST_DIFFERENCES + 1


def test_what_a_file_manager_leaves_is_none(copied):
    (copied / "plan" / ".DS_Store").write_bytes(b"\0")
    assert deviations(copied) == []


def test_runs_after_the_date_are_none(copied):
    of_people("2107-12-01T09:00:00Z")(copied)
    assert deviations(copied) == []


def test_a_task_that_was_named_is_a_deviation(copied):
    status, found = analysed(copied, "--task", "magnitudeestimation")
    assert (status, found) == (1, [("options", "--task was used, but is not in the plan.")])


def test_options_of_the_command_are_deviations(copied, capsys):
    options = ["--normalise", "none", "--equivalence", "1.5", "--in-session", "01"]
    status, found = analysed(copied, *options)
    expected = [
        ("normalisation", "Estimates were normalised by none; planned: scale_top."),
        ("options", "analysis.equivalence_ratio was 1.5; planned: 1.25."),
        ("options", "--in-session was used, but is not in the plan."),
    ]
    assert (status, found) == (1, expected)
    told = capsys.readouterr().err
    for kind, what in expected:
        assert f"deviation ({kind}): {what}" in told


def test_other_versions_are_deviations(copied, monkeypatch):
    monkeypatch.setattr(check, "software", lambda own: {**software(own), "numpy": "9.9"})
    ((kind, what),) = deviations(copied)
    assert kind == "versions"
    assert re.fullmatch(r"numpy 9\.9; planned: .+\.", what)


def with_own(root, found):
    """Return the deviations of an analysis with one more of the package "lab"."""
    analysis = analyse(root / "data")
    kind = own_analysis("drift", title="Drift", run=lambda _: found)
    kind.package, kind.version = "lab", "2"
    own = replace(
        analysis,
        kinds=(*analysis.kinds, kind),
        inference=analysis.inference.with_result(kind.statistics[0], found),
    )
    plan = check.check_plan(read_bundle(root / "plan"), own)
    return [(each.kind, each.what) for each in plan.deviations]


def test_an_analysis_of_another_package_is_one_more_test(frozen):
    assert with_own(frozen, OwnResult(sentences=("It drifts.",), numbers={})) == [
        ("tests", "own_drift was computed but not planned."),
        ("versions", "lab 2; planned: none."),
    ]
    assert ("versions", "lab 2; planned: none.") in with_own(frozen, NotComputed("no data"))


def test_the_report_lists_the_deviations(copied):
    without_a_participant(copied)
    analysed(copied)
    report = (copied / "data" / "derivatives" / "slipscale" / "report.html").read_text()
    assert "There are 2 deviations from the plan" in report
    assert "3 participants have data; planned: 4 (1 fewer)." in report


def cut(root):
    path = root / "plan.zip"
    path.write_bytes(path.read_bytes()[:2000])


def damaged_inside(root):
    path = root / "plan.zip"
    content = bytearray(path.read_bytes())
    content[200] ^= 0xFF
    path.write_bytes(content)


def manifest(root):
    return root / "plan" / "manifest.json"


REFUSED = {
    "nothing": (lambda root: shutil.rmtree(root / "plan"), "plan", "no such file or folder"),
    "no manifest": (lambda root: manifest(root).unlink(), "plan", "manifest.json is missing"),
    "a text": (
        lambda root: (root / "plan.zip").write_text("my plan"),
        "plan.zip",
        "not a bundle, or truncated",
    ),
    "cut short": (cut, "plan.zip", "not a bundle, or truncated"),
    "damaged": (damaged_inside, "plan.zip", "not a bundle, or truncated or damaged"),
    "not JSON": (
        lambda root: manifest(root).write_text("{"),
        "plan",
        "damaged or edited (it is not JSON)",
    ),
    "edited": (
        lambda root: edited(manifest(root), '"participants": 4', '"participants": 3'),
        "plan",
        "edited after it was frozen",
    ),
    "wrong type": (
        lambda root: edited(manifest(root), '"participants": 4', '"participants": "four"'),
        "plan",
        "damaged or edited (participants:",
    ),
    "another format": (
        lambda root: edited(manifest(root), '"format": 1', '"format": 2'),
        "plan",
        "its format is 2, but this version of Slipscale reads format 1",
    ),
    "study edited": (
        lambda root: edited(root / "plan" / "study" / "study.toml", "seed = 3", "seed = 4"),
        "plan",
        "not the frozen file",
    ),
    "another study": (
        lambda root: [
            edited(path, '"study": "small"', '"study": "other"')
            for path in (root / "data").glob("sub-*/**/*_beh.json")
        ],
        "plan",
        "is for study 'small', but the data are from 'other'",
    ),
}


@pytest.mark.parametrize("change, plan, sentence", REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_checked_by_is_refused_in_a_sentence(copied, capsys, change, plan, sentence):
    change(copied)
    words = ["analyse", str(copied / "data"), "--plan", str(copied / plan)]
    assert commands.main(words) == 2
    told = capsys.readouterr().err
    assert sentence in told
    assert told.count("\n") == 1


def test_every_byte_of_a_zip_that_is_cut_off_is_noticed(copied, capsys):
    """A plan that was not copied to its end is never taken for a whole one."""
    whole = (copied / "plan.zip").read_bytes()
    for kept in range(0, len(whole), max(len(whole) // 40, 1)):
        (copied / "plan.zip").write_bytes(whole[:kept])
        words = ["analyse", str(copied / "data"), "--plan", str(copied / "plan.zip")]
        assert commands.main(words) == 2
    assert zipfile.is_zipfile(copied / "plan.zip") is False


def test_a_study_in_a_language_of_its_own_has_its_texts_frozen(frozen, tmp_path):
    (tmp_path / "texts.de.toml").write_text(
        'language = "de"\n'
        + "".join(f"{key} = {json.dumps(text)}\n" for key, text in to_translate({}).items()),
        encoding="utf-8",
    )
    path = tmp_path / "mine.toml"
    own = 'language = "de"\ntexts_files = ["texts.de.toml"]\n[[tasks]]'
    text = (frozen / "small.toml").read_text(encoding="utf-8")
    path.write_text(text.replace("[[tasks]]", own, 1).replace('codebook = "words.toml"', ""))
    assert commands.main(["study", "freeze", str(path), "--out", str(tmp_path / "plan")]) == 0
    copy = tmp_path / "plan" / "study" / "files" / "texts.de.toml"
    assert copy.read_bytes() == (tmp_path / "texts.de.toml").read_bytes()
    plans = pilot_plans(str(path), participants=None, seed=None, language=None)
    write_simulated(tmp_path / "data", plans, Population(), sessions=False)
    assert deviations(tmp_path) == []


def test_an_exclusion_by_hand_is_a_deviation(whole):
    decide(whole / "data", "02", excluded=True, reason="wore a glove", results_seen=True)
    reason = "by hand, after results were shown: wore a glove"
    said = f"sub-02 was excluded {reason}. A plan cannot name participants."
    assert ("exclusions", said) in deviations(whole)
