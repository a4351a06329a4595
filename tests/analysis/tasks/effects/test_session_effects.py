"""Sessions as a factor: against R, planted changes, and what is said where there are none."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from slipscale import commands
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.analysis.reporting.multiplicity import multiplicity
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.effects.sessions.declaration import sentences
from slipscale.analysis.tasks.effects.sessions.statistics import agreement
from slipscale.analysis.tasks.table import conclude
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.bare_dataset import why_sessions, write_simulated
from slipscale.experiments.running.pilot import pilot_plans
from slipscale.experiments.study.file import study_text

pytestmark = pytest.mark.usefixtures("without_models", "without_simulated_fits")

DATA = Path(__file__).parents[3] / "data" / "r_reference"
R = json.loads((DATA / "sessions.json").read_text())
#: Four repetitions, taken as four sessions.
COLUMNS = {"participant": "participant", "stimulus": "amp", "response": "est", "session": "rep"}


@pytest.fixture(scope="module")
def analysis():
    return analyse(
        load(DATA / "estimates.csv", parse_mapping({"columns": COLUMNS}, "")), normalise="none"
    )


@pytest.fixture(scope="module")
def found(analysis):
    return analysis.inference.sessions


@pytest.mark.parametrize("effect", ["session", "amplitude", "interaction"])
def test_the_analysis_of_variance_is_r_s(found, effect):
    ours = getattr(found.anova, "of_level" if effect == "amplitude" else effect)
    for name in ("F", "df1", "df2", "p"):
        assert getattr(ours, name) == pytest.approx(R[effect][name], rel=1e-8), name


@pytest.mark.parametrize("place, name", [(0, "level"), (1, "exponent")])
def test_means_changes_and_agreement_are_r_s(found, place, name):
    measure, expected = found.measures[place], R[name]
    assert name in measure.name
    assert measure.n == 12
    assert measure.means == pytest.approx(expected["means"], rel=1e-8)
    for ours, theirs in zip(measure.changes, expected["changes"], strict=True):
        for key in ("mean", "t", "p"):
            assert getattr(ours.change, key) == pytest.approx(theirs[key], rel=1e-7), key
        assert list(ours.change.interval) == pytest.approx([theirs["low"], theirs["high"]])
    icc, theirs = measure.agreement, expected["icc"]
    assert icc.value == pytest.approx(theirs["value"], rel=1e-8)
    assert list(icc.interval) == pytest.approx([theirs["low"], theirs["high"]], rel=1e-8)


def test_holm_s_correction_is_over_every_change_of_every_measure(analysis, found):
    ps = [each.change.p for measure in found.measures for each in measure.changes]
    least = min(ps)
    corrected = [each.p_holm for measure in found.measures for each in measure.changes]
    assert len(ps) == 6
    assert min(corrected) == pytest.approx(min(1.0, 6 * least))
    families = {
        each.name: each for each in multiplicity(analysis.inference, "ranks", 0.95).families
    }
    assert families["changes from the first session"].tests == 6
    assert families["sessions, analysis of variance"].tests == 2


def table(change=0.0, people=8, seed=1, keep=None):
    """Return magnitude estimates of two sessions; in the second the logarithm is larger."""
    rng = np.random.default_rng(seed)
    rows = ["participant_id,session,amplitude_um_pp,estimate"]
    for who in range(people):
        level = rng.normal(0, 0.3)
        for session in ("01", "02"):
            for amplitude in (0.5, 1.2, 2.3):
                log = 3 + level + np.log(amplitude) + rng.normal(0, 0.05)
                log += change * (session == "02")
                if keep is None or keep(who, session):
                    rows.append(f"p{who},{session},{amplitude},{np.exp(log):.6f}")
    return "\n".join(rows) + "\n"


def test_a_change_between_sessions_is_found_and_none_is_not(table_by_hand):
    for change, differs in ((0.4, True), (0.0, False)):
        analysed = analyse(table_by_hand(table(change)), normalise="none")
        sessions = analysed.inference.sessions
        assert (sessions.anova.session.p < 0.05) == differs
        assert sessions.anova.interaction.p > 0.05
        level = sessions.measures[0]
        assert level.changes[0].change.mean == pytest.approx(change, abs=0.05)
        told = " ".join(sentences(analysed))
        assert ("estimates differed between sessions" in told) == differs
        assert ("level (mean natural logarithm, n = 8) did not change reliably" in told) != differs


def test_people_come_back_as_themselves_or_as_others():
    rng = np.random.default_rng(3)
    own = rng.normal(0, 1, 40)
    same = np.column_stack([own, own + rng.normal(0, 0.05, 40)])
    assert agreement(same, 0.95).value > 0.98
    other = np.column_stack([own, rng.normal(0, 1, 40)])
    assert agreement(other, 0.95).interval.low < 0 < agreement(other, 0.95).interval.high
    # Absolute agreement: who all change by as much do not agree.
    assert agreement(same + np.array([0, 5]), 0.95).value < 0.2
    exact = agreement(np.column_stack([own, own]), 0.95)
    assert (exact.value, exact.interval) == (pytest.approx(1.0), None)
    assert isinstance(agreement(np.ones((5, 2)), 0.95), NotComputed)


def test_whoever_lacks_a_session_is_left_out_and_counted(table_by_hand):
    text = table(people=6, keep=lambda who, session: who > 1 or session == "01")
    found = analyse(table_by_hand(text), normalise="none").inference.sessions
    assert found.anova.n == 4
    assert [measure.n for measure in found.measures] == [4, 4]


def test_people_of_one_session_each_are_not_compared_within(table_by_hand):
    text = table(people=6, keep=lambda who, session: (who % 2 == 0) == (session == "01"))
    analysed = analyse(table_by_hand(text), normalise="none")
    found = analysed.inference.sessions
    assert "every amplitude in every session (0;" in found.anova.reason
    assert all(isinstance(measure.agreement, NotComputed) for measure in found.measures)
    assert "sessions were not compared" in " ".join(sentences(analysed))


@pytest.mark.parametrize(
    "study, measure",
    [
        ("matching", "matching, match minus reference"),
        ("constant_stimuli", "constantstimuli, threshold"),
        ("visual_analogue_scale", "visualanalogue, mean rating"),
        ("ratio_to_standard", "ratiotostandard, mean ratio"),
        ("magnitude_production", "magnitudeproduction, mean produced amplitude"),
        ("biet2007", "descending difference, “yes” on changes"),
    ],
)
def test_sessions_of_every_task_are_compared(sessions_of_pilot, study, measure):
    # Some people's most likely threshold lies beyond the levels: they have none.
    people, compared = (6, 3) if study == "constant_stimuli" else (3, 3)
    found = conclude(load(sessions_of_pilot(study, people)), None, None).sessions
    by_name = {each.name: each for each in found.measures}
    assert len(by_name[measure].means) == 2
    assert by_name[measure].n == compared
    assert found.anova == NotComputed("no magnitude estimates")


@pytest.fixture
def sessions_of_pilot(tmp_path):
    def piloted(study, people=3):
        path = tmp_path / f"{study}.toml"
        path.write_text(
            study_text(study).replace("participants =", 'sessions = ["01", "02"]\nparticipants =')
        )
        plans = pilot_plans(str(path), participants=people, seed=2, language="en")
        write_simulated(
            tmp_path / study, plans, Population(), sessions=bool(why_sessions(plans[0]))
        )
        return tmp_path / study

    return piloted


def test_one_session_or_none_is_no_factor(table_by_hand):
    one = table(keep=lambda _who, session: session == "01")
    for text in (one, one.replace("session,", "run,")):
        found = analyse(table_by_hand(text), normalise="none")
        assert found.inference.sessions == NotComputed("there is only one session")
        assert sentences(found) == []


def test_a_study_that_does_not_choose_it_is_told_so(analysis):
    data = replace(
        analysis.dataset, choices=analysis.dataset.choices.model_copy(update={"tests": ("order",)})
    )
    found = analyse(data, normalise="none")
    assert found.inference.sessions == NotComputed("not chosen in the study file")
    assert any("does not select the test “sessions”" in each for each in found.problems)


def test_zeros_that_are_refused_leave_the_other_tasks(analysis):
    prepared = replace(analysis.prepared, refused=True, zero_sentence="zeros")
    found = conclude(analysis.dataset, prepared, None).sessions
    assert found.anova == NotComputed("zeros")
    assert found.measures == ()


def test_the_report_and_the_results_say_it(table_by_hand, tmp_path):
    path = table_by_hand(table(0.4))
    out = tmp_path / "out"
    assert commands.main(["analyse", str(path), "--normalise", "none", "--out", str(out)]) == 0
    report = (out / "report.html").read_text()
    assert "<h2" in report
    for words in (
        "Sessions 01 and 02 were compared.",
        "session x amplitude",
        "Differences between sessions are reported under",
        "ICC(A,1)",
        "McGraw &amp; Wong, 1996",
    ):
        assert words in report
    told = json.loads((out / "inference.json").read_text())["sessions"]
    assert told["measures"][0]["changes"][0]["change"]["mean"] == pytest.approx(0.4, abs=0.05)
    assert len(told["measures"][0]["agreement"]["ci"]) == 2
    one = tmp_path / "one"
    given = ["analyse", str(path), "--normalise", "none", "--in-session", "02", "--out", str(one)]
    assert commands.main(given) == 0
    assert "reason" in json.loads((one / "inference.json").read_text())["sessions"]


def test_amplitudes_that_only_one_session_has_compare_nobody(table_by_hand):
    rows = table().splitlines()
    kept = [row for row in rows if not (",02," in row and ",2.3," in row)]
    found = analyse(table_by_hand("\n".join(kept) + "\n"), normalise="none").inference.sessions
    assert "every amplitude in every session (0;" in found.anova.reason
    assert isinstance(found.measures[0].agreement, NotComputed)
    assert found.measures[1].n == 8  # exponents of two amplitudes and of three
    assert pd.notna(found.measures[1].agreement.value)
