"""Outside analyses: in every place where ours are, and their faults told in one sentence each."""

import json
import re
from types import SimpleNamespace

import pandas as pd
import pytest

from slipscale import commands
from slipscale.analysis.load import load
from slipscale.analysis.own import run
from slipscale.analysis.own.declaration import OwnAnalysis, OwnResult
from slipscale.analysis.own.run import own_analyses
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.published.biet2007 import ALLOWED_DATASET
from slipscale.analysis.reporting.files import inference, write_analysis
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.run import conclude
from slipscale.faults import UserError


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
    from matplotlib.figure import Figure  # noqa: PLC0415 - as a plug-in does

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
        monkeypatch.setattr(run, "installed", lambda _: points)

    return install


def test_a_result_is_in_the_report_and_in_every_file(installed, only_own, tmp_path, capsys):
    installed(spread=OwnAnalysis(title="Spread of estimates", run=spread))
    assert commands.main(["analyse", str(only_own), "--out", str(tmp_path)]) == 0
    assert "Spread of estimates: There are 0 estimates" in capsys.readouterr().out
    expected = {
        "title": "Spread of estimates",
        "package": "ourlab",
        "version": "2.1",
        "sentences": ["There are 0 estimates of <b>slip</b>."],
        "numbers": {"trials": 0, "span": [0.0, None], "study": True},
    }
    written = json.loads((tmp_path / "inference.json").read_text())
    results = json.loads((tmp_path / "results.json").read_text())
    assert written["own_analyses"] == results["inference"]["own_analyses"] == {"spread": expected}
    assert (tmp_path / "own_spread.csv").read_text() == "who,value\na,0.25\n,\n"
    assert (tmp_path / "own_spread.svg").exists()
    page = (tmp_path / "report.html").read_text()
    assert 'id="spread-of-estimates"' in page
    assert "There are 0 estimates of &lt;b&gt;slip&lt;/b&gt;." in page
    assert "the analysis &#39;spread&#39; of the package ourlab 2.1" in page
    assert 'aria-label="A line that rises"' in page


def test_without_outside_analyses_no_file_names_them(installed, data):
    installed()
    assert own_analyses(data) == ()
    ours = SimpleNamespace(inference=conclude(data, None, None), own=())
    assert "own_analyses" not in inference(ours)


@pytest.mark.parametrize(
    "declared, said",
    [
        (OwnAnalysis(title="T", run=broken), r"raised LookupError: no such column \(module"),
        (OwnAnalysis(title="T", run=lambda _: {"p": 1}), "returned dict, expected an OwnResult"),
        (OwnAnalysis(title="", run=broken), "its title is '', expected a text"),
        (broken, "expected an OwnAnalysis"),
        (ModuleNotFoundError("No module named 'extra'"), "raised ModuleNotFoundError: No module"),
        (
            OwnAnalysis(title="T", run=lambda _: OwnResult(sentences="one", numbers={})),
            "sentences: expected a tuple",
        ),
        (
            OwnAnalysis(title="T", run=lambda _: OwnResult(sentences=("a",), numbers={"x": {1}})),
            "numbers: expected a mapping",
        ),
    ],
)
def test_one_that_fails_is_a_sentence_and_the_next_goes_on(installed, data, declared, said):
    installed(wrong=declared, spread=OwnAnalysis(title="Spread", run=spread))
    wrong, good = own_analyses(data)
    assert wrong.failed
    assert re.match(f"analysis 'wrong' of the package ourlab.*{said}", wrong.found.reason)
    assert not good.failed
    assert good.found.numbers["trials"] == 48
    assert (data.estimates["estimate"] > 0).any()


def test_the_rest_of_the_analysis_goes_on_and_the_failure_is_among_its_notes(installed):
    installed(wrong=OwnAnalysis(title="T", run=broken))
    analysis = analyse(ALLOWED_DATASET)
    (problem,) = [each for each in analysis.problems if "ourlab" in each]
    assert problem.startswith("analysis 'wrong' of the package ourlab raised LookupError")
    assert analysis.inference.friedman.chi2 > 0


def test_one_that_has_nothing_to_say_is_no_problem_and_says_why(installed, only_own, tmp_path):
    installed(none=OwnAnalysis(title="None", run=lambda _: NotComputed("no trials of weight")))
    analysis = analyse(only_own)
    assert not any("weight" in each for each in analysis.problems)
    write_analysis(analysis, tmp_path)
    assert "Not computed: no trials of weight." in (tmp_path / "report.html").read_text()
    own = json.loads((tmp_path / "inference.json").read_text())["own_analyses"]
    assert own["none"]["reason"] == "no trials of weight"


def test_a_name_that_is_no_files_name_is_refused(installed, data):
    installed(**{"../up": OwnAnalysis(title="Up", run=spread)})
    (own,) = own_analyses(data)
    assert "expected a name of small letters" in own.found.reason


@pytest.mark.parametrize(
    "changes, said",
    [
        ({"table": [1, 2]}, "table: expected a DataFrame"),
        ({"table": pd.DataFrame({"a": [[1]]})}, "table: expected a DataFrame"),
        ({"figure": "a.png"}, "figure: expected a Figure of matplotlib"),
        ({"figure": drawn()}, "a figure_caption and a figure_alt"),
        ({"sentences": ()}, "one or more texts"),
    ],
)
def test_a_result_of_another_kind_is_refused_when_it_is_made(changes, said):
    with pytest.raises(UserError, match=said):
        OwnResult(**{"sentences": ("a",), "numbers": {}, **changes})


def test_a_figure_that_cannot_be_drawn_is_told_and_not_written(installed, data):
    figure = drawn()
    figure.axes[0].set_title("$\\frac{$")

    def found(_own):
        return OwnResult(
            sentences=("a",), numbers={}, figure=figure, figure_caption="b", figure_alt="c"
        )

    installed(torn=OwnAnalysis(title="Torn", run=found))
    (own,) = own_analyses(data)
    assert "its figure raised" in own.found.reason


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

    installed(grip=OwnAnalysis(title="Grip", run=mean))
    analysis = analyse(only_own)
    (own,) = analysis.own
    assert own.found.numbers == {"mean": 2.5, "n": 2}
    rows = load(only_own).others["grip"]
    assert list(rows["participant_id"]) == ["sub-01", "sub-01"]
    assert list(rows["word"]) == ["b", "d"]
    write_analysis(analysis, tmp_path / "out")
    assert "ok" in (tmp_path / "out" / "report.html").read_text()


def test_tables_that_nobody_reads_are_told_with_what_would_read_them(installed, only_own):
    installed()
    with pytest.raises(UserError, match=r"trials of grip alone.*slipscale\.analyses"):
        analyse(only_own)
