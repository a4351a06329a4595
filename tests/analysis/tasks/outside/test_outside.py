"""Outside analyses: in every place where ours are, and their faults told in one sentence each."""

import json
import pickle
import re
from types import SimpleNamespace

import pandas as pd
import pytest

from slipscale import commands
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.published.biet2007 import ALLOWED_DATASET
from slipscale.analysis.reading.labelled_tasks import TaskTrials, read_main_trials
from slipscale.analysis.reporting.files import write_analysis
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Family, Statistic
from slipscale.analysis.tasks.kind import TaskAnalysis
from slipscale.analysis.tasks.outside import guard
from slipscale.analysis.tasks.outside.short_form import OwnResult, own_analysis
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_models")


class Point:
    """An entry point of a package that is called ourlab."""

    module = __name__
    dist = SimpleNamespace(name="ourlab", version="2.1")

    def __init__(self, name, declared):
        self.name, self.declared = name, declared

    def load(self):
        if isinstance(self.declared, Exception):
            raise self.declared
        return self.declared


@pytest.fixture(scope="module")
def data():
    return load(ALLOWED_DATASET)


def drawn():
    from matplotlib.figure import Figure

    figure = Figure()
    figure.subplots().plot([0, 1], [0, 1])
    return figure


def spread(own):
    """Return how far apart a data set's estimates are."""
    rows = own.dataset.estimates
    own.dataset.estimates["estimate"] = 0.0  # a copy: nobody else sees it
    return OwnResult(
        sentences=(f"There are {len(rows)} estimates of <b>slip</b>.",),
        numbers={"trials": len(rows), "span": (0.0, float("nan")), "study": own.study is None},
        table=pd.DataFrame({"who": ["a", None], "value": [0.25, float("nan")]}),
        table_caption="Two rows.",
        figure=drawn(),
        figure_caption="A line.",
        figure_alt="A line that rises",
    )


def broken(_own):
    raise LookupError("no such column")


@pytest.fixture
def installed(monkeypatch):
    """Return a function that has analyses installed, by name."""

    def install(**declared):
        points = {name: Point(name, each) for name, each in declared.items()}
        monkeypatch.setattr(guard, "installed", lambda _: points)

    return install


def test_a_result_is_in_the_report_and_in_every_file(installed, only_own, tmp_path, capsys):
    installed(spread=own_analysis("spread", title="Spread of estimates", run=spread))
    assert commands.main(["analyse", str(only_own), "--out", str(tmp_path)]) == 0
    assert "Spread of estimates: There are 0 estimates" in capsys.readouterr().out
    expected = {
        "sentences": ["There are 0 estimates of <b>slip</b>."],
        "numbers": {"trials": 0, "span": [0.0, None], "study": True},
    }
    written = json.loads((tmp_path / "inference.json").read_text())
    results = json.loads((tmp_path / "results.json").read_text())
    assert written["own_spread"] == results["inference"]["own_spread"] == expected
    assert results["software"]["ourlab"] == "2.1"
    assert (tmp_path / "own_spread.csv").read_text() == "who,value\na,0.25\n,\n"
    assert (tmp_path / "own_spread.svg").exists()
    page = (tmp_path / "report.html").read_text()
    assert 'id="spread-of-estimates"' in page
    assert "There are 0 estimates of &lt;b&gt;slip&lt;/b&gt;." in page
    assert "by the analysis &#39;spread&#39; in the package ourlab 2.1," in page
    assert 'aria-label="A line that rises"' in page


def test_a_kind_is_pickled_as_the_name_of_its_entry_point(installed, only_own):
    installed(spread=own_analysis("spread", title="Spread", run=lambda own, make=spread: make(own)))
    copy = pickle.loads(pickle.dumps(analyse(only_own)))  # noqa: S301 - written here
    kind = copy.kinds[-1]
    assert (kind.name, kind.package, kind.version) == ("spread", "ourlab", "2.1")
    assert kind.answers(copy) == ["Spread: There are 0 estimates of <b>slip</b>."]
    statistic = copy.inference.declared[-1]
    assert copy.inference[statistic] is copy.inference.own_spread


def test_without_outside_analyses_only_our_keys_are_written(installed):
    installed()
    analysis = analyse(ALLOWED_DATASET)
    assert [key for key in analysis.inference.results if key.startswith("own_")] == []
    assert {kind.package for kind in analysis.kinds} == {""}


@pytest.mark.parametrize(
    "declared, said",
    [
        (
            own_analysis("wrong", title="T", run=broken),
            r" raised LookupError: no such column \(module",
        ),
        (
            own_analysis("wrong", title="T", run=lambda _: {"p": 1}),
            ": returned dict, expected an OwnResult",
        ),
        (
            own_analysis("other", title="T", run=broken),
            ": its name must be the name of the entry point, but is 'other'",
        ),
        (broken, ": its entry point must be a TaskAnalysis, but is"),
        (ModuleNotFoundError("No module named 'extra'"), " raised ModuleNotFoundError: No module"),
        (
            own_analysis("wrong", title="T", run=lambda _: OwnResult(sentences="one", numbers={})),
            ": sentences: expected a tuple",
        ),
        (
            own_analysis(
                "wrong", title="T", run=lambda _: OwnResult(sentences=("a",), numbers={"x": {1}})
            ),
            ": numbers: expected a mapping",
        ),
    ],
)
def test_one_that_fails_is_a_sentence_and_the_next_goes_on(installed, only_own, declared, said):
    installed(wrong=declared, spread=own_analysis("spread", title="Spread", run=spread))
    analysis = analyse(only_own)
    (problem,) = [each for each in analysis.problems if "ourlab" in each]
    assert re.match(f"analysis 'wrong' of the package ourlab{said}", problem)
    assert analysis.inference.own_spread.numbers["trials"] == 0


def test_one_that_changes_its_tables_changes_those_of_nobody_else(installed, data):
    installed(spread=own_analysis("spread", title="Spread", run=spread))
    analysis = analyse(data)
    assert analysis.inference.own_spread.numbers["trials"] == 48
    assert (analysis.dataset.estimates["estimate"] > 0).any()
    assert analysis.inference.friedman.chi2 > 0


def test_a_title_that_is_no_text_is_refused_when_it_is_declared():
    with pytest.raises(UserError, match="the title must contain text, but is ''"):
        own_analysis("wrong", title="", run=broken)


def fails(*_):
    raise LookupError("no such column")


def declared(base, **parts):
    """Return the instance of a class that consists of functions and of values."""
    methods = {key: staticmethod(each) if callable(each) else each for key, each in parts.items()}
    return type("Declared", (base,), methods)()


def wrong(**parts):
    return declared(TaskAnalysis, **{"name": "wrong", **parts})


def statistic(key, compute, **others):
    return declared(Statistic, key=key, meaning="m", compute=compute, **others)


@pytest.mark.parametrize("part", [*guard.PARTS, "sections"])
def test_every_part_that_fails_is_one_sentence_and_the_report_is_written(
    installed, only_own, tmp_path, part
):
    installed(
        wrong=wrong(**{part: fails}),
        spread=own_analysis("spread", title="Spread", run=spread),
    )
    report = write_analysis(analyse(only_own), tmp_path).read_text(encoding="utf-8")
    said = f"analysis &#39;wrong&#39; of the package ourlab: its {part} raised LookupError: no such"
    assert report.count(said) == 1
    assert "There are 0 estimates" in report


@pytest.mark.parametrize(
    "parts, said",
    [
        ({"answers": lambda _: "one"}, "its answers: returned str, expected a list of strings"),
        ({"doubts": lambda _: [1]}, "its doubts: returned int, expected a list of strings"),
        (
            {"sentences": lambda _: {"H": "a"}},
            "its sentences: returned str, expected lists of strings by",
        ),
        (
            {"figures": lambda _: {"own_wrong": 1}},
            "its figures: returned int, expected matplotlib figures by",
        ),
        ({"tables": lambda _: {"own_wrong": []}}, "its tables: returned list, expected DataFrames"),
        (
            {"tables": lambda _: {"table3": pd.DataFrame()}},
            "its tables: a file name must be own_wrong or begin with own_wrong_, but is 'table3'",
        ),
    ],
)
def test_a_part_of_another_type_or_name_is_left_out_and_told(installed, only_own, parts, said):
    installed(wrong=wrong(**parts))
    problems = analyse(only_own).problems
    assert f"analysis 'wrong' of the package ourlab: {said}" in " ".join(problems)


def of_key(key, **others):
    return wrong(statistics=(statistic(key, lambda _: {"p": 0.5}, **others),))


def test_a_key_that_could_hide_one_of_ours_is_refused(installed):
    installed(wrong=of_key("friedman"))
    faults = []
    assert guard.installed_kinds(faults) == ()
    assert "its key must be own_wrong or begin with own_wrong_, but is 'friedman'" in faults[0]


def test_a_family_of_tests_that_cannot_be_read_takes_its_result_with_it(installed, only_own):
    installed(wrong=of_key("own_wrong", families=(Family(name="f", read=fails),)))
    analysis = analyse(only_own)
    assert "ourlab raised LookupError" in analysis.inference.own_wrong.reason


def test_measures_of_sessions_that_fail_are_none(installed):
    faults = []
    installed(wrong=wrong(session_tables=fails))
    (kind,) = guard.installed_kinds(faults)
    assert kind.session_tables(None, None) == []
    assert "its session_tables raised LookupError" in faults[0]


def test_the_rest_of_the_analysis_goes_on_and_the_failure_is_among_its_notes(installed):
    installed(wrong=own_analysis("wrong", title="T", run=broken))
    analysis = analyse(ALLOWED_DATASET)
    (problem,) = [each for each in analysis.problems if "ourlab" in each]
    assert problem.startswith("analysis 'wrong' of the package ourlab raised LookupError")
    assert analysis.inference.friedman.chi2 > 0


def test_one_that_has_nothing_to_say_is_no_problem_and_says_why(installed, only_own, tmp_path):
    installed(
        none=own_analysis("none", title="None", run=lambda _: NotComputed("no trials of weight"))
    )
    analysis = analyse(only_own)
    assert not any("weight" in each for each in analysis.problems)
    write_analysis(analysis, tmp_path)
    assert "Not computed: no trials of weight." in (tmp_path / "report.html").read_text()
    written = json.loads((tmp_path / "inference.json").read_text())
    assert written["own_none"] == {"reason": "no trials of weight"}


@pytest.mark.parametrize(
    "changes, said",
    [
        ({"table": [1, 2]}, "table: expected a DataFrame"),
        ({"table": pd.DataFrame({"a": [[1]]})}, "table: expected a DataFrame"),
        ({"figure": drawn()}, "a figure_caption and a figure_alt"),
        ({"sentences": ()}, "one or more strings"),
    ],
)
def test_a_result_of_another_kind_is_refused_when_it_is_made(changes, said):
    with pytest.raises(UserError, match=said):
        OwnResult(**{"sentences": ("a",), "numbers": {}, **changes})


def test_a_figure_that_cannot_be_drawn_is_told_and_not_written(installed, only_own):
    figure = drawn()
    figure.axes[0].set_title("$\\frac{$")

    def found(_own):
        return OwnResult(
            sentences=("a",), numbers={}, figure=figure, figure_caption="b", figure_alt="c"
        )

    installed(torn=own_analysis("torn", title="Torn", run=found))
    assert "ourlab: its figures raised" in " ".join(analyse(only_own).problems)


@pytest.fixture
def only_own(tmp_path):
    """A data set with the table of one task, which Slipscale does not read."""
    folder = tmp_path / "data" / "sub-01" / "beh"
    folder.mkdir(parents=True)
    (folder / "sub-01_task-grip_run-01_beh.tsv").write_text(
        "trial\tphase\tgrip\tword\tflag\n1\tpractice\t1\ta\tn/a\n2\tmain\t2.5\tb\tn/a\n"
        "3\tmain\tn/a\tc\tvoided\n4\tmain\tn/a\td\tn/a\n"
    )
    return tmp_path / "data"


def test_the_tables_of_a_laboratorys_own_task_are_handed_over(installed, only_own, tmp_path):
    def mean(own):
        rows = own.dataset.others["grip"]
        return OwnResult(sentences=("ok",), numbers={"mean": rows["grip"].mean(), "n": len(rows)})

    installed(grip=own_analysis("grip", title="Grip", run=mean))
    analysis = analyse(only_own)
    assert analysis.inference.own_grip.numbers == {"mean": 2.5, "n": 2}
    rows = load(only_own).others["grip"]
    assert list(rows["participant_id"]) == ["sub-01", "sub-01"]
    assert list(rows["word"]) == ["b", "d"]
    write_analysis(analysis, tmp_path / "out")
    assert "ok" in (tmp_path / "out" / "report.html").read_text()


def test_tables_that_nobody_reads_are_told_with_what_would_read_them(installed, only_own):
    installed()
    with pytest.raises(UserError, match=r"only trials of grip.*slipscale\.analyses"):
        analyse(only_own)


def grips(read):
    """Return a kind that reads the tables of grip with its own reader."""
    trials = TaskTrials(
        name="own_grip",
        counted="grip",
        title="grip",
        belongs=lambda header: "grip" in header,
        read=read,
        empty=pd.DataFrame,
    )
    count = statistic("own_grip", lambda inputs: {"n": len(inputs.data.of(trials))})
    return wrong(name="grip", trials=trials, statistics=(count,))


def read_grips(entries, folder, problems, counts):
    return read_main_trials(
        entries,
        folder,
        kind="grip",
        required=("grip",),
        columns=("grip",),
        problems=problems,
        counts=counts,
    )


def test_trials_of_an_outside_kind_are_read_as_ours_are(installed, only_own):
    installed(grip=grips(read_grips))
    analysis = analyse(only_own)
    assert analysis.dataset.others == {}
    assert analysis.dataset.trials["own_grip"]["grip"].tolist()[0] == 2.5
    assert analysis.inference.own_grip == {"n": 2}


def test_trials_that_cannot_be_read_are_told(installed, only_own):
    installed(grip=grips(fails))
    data = load(only_own)
    assert "analysis 'grip' of the package ourlab: its read raised LookupError" in " ".join(
        data.problems
    )
    assert not len(data.trials["own_grip"])
