"""The page on all data sets behind a table: what it draws is exact, and it needs no network."""

from __future__ import annotations

import base64
import csv
import re

import numpy as np
import pytest

from slipscale import commands
from slipscale.analysis.published.biet2007 import TABLE3_FILE
from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.table.table_files import read
from slipscale.analysis.reconstruction_page import distributions
from slipscale.analysis.reconstruction_page.distributions import cumulative, histogram
from slipscale.analysis.reconstruction_page.page import _axis_ends

MIXED = """label,n,mean,sd,scale_minimum,scale_maximum
good,5,2.40,1.14,1,7
bad,20,3.20,9.00,1,7
large,300,50.00,10.00,0,100
"""


@pytest.fixture(scope="module")
def column():
    return Solutions(read(TABLE3_FILE).columns[1])


@pytest.fixture(scope="module")
def listed(column):
    return Sampler(column).listed


def test_the_cumulative_bands_are_those_of_all_data_sets(column, listed):
    found = cumulative(column, listed[:5], "multisets")
    assert found.exact
    values = found.edges[:-1]
    shares = (listed[:, :, None] <= values).mean(axis=1)
    assert found.mean == pytest.approx(shares.mean(axis=0))
    assert found.least == pytest.approx(shares.min(axis=0))
    assert found.most == pytest.approx(shares.max(axis=0))
    band = np.quantile(shares, (0.025, 0.975), axis=0, method="inverted_cdf")
    assert found.low == pytest.approx(band[0])
    assert found.high == pytest.approx(band[1])


def test_without_exact_marginals_the_bands_are_those_of_the_samples(column, listed, monkeypatch):
    exact = cumulative(column, listed, "multisets")
    monkeypatch.setattr(distributions, "worth_marginals", lambda _: False)
    drawn = cumulative(column, listed, "multisets")
    assert not drawn.exact
    for name in ("edges", "mean", "low", "high", "least", "most"):
        assert getattr(drawn, name) == pytest.approx(getattr(exact, name))


def test_every_rating_is_in_one_bar(column, listed):
    found = histogram(column, listed)
    assert found.mean.sum() == pytest.approx(12)
    assert len(found.mean) <= distributions.BARS
    at_30 = (listed == 30).sum(axis=1)
    assert (found.least[-1], found.most[-1]) == (at_30.min(), at_30.max())


def test_the_page_answers_every_column_and_needs_no_network(tmp_path, capsys):
    (tmp_path / "t.csv").write_text(MIXED)
    words = ["reconstruct", str(tmp_path / "t.csv"), "--html", str(tmp_path / "page.html")]
    assert commands.main(words) == 1
    assert "good" in capsys.readouterr().out
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert page.count("<figure>") == 2
    assert "sd 9.00 is impossible on a scale from 1 to 7" in page
    assert "saddle-point estimate" in page
    addresses = re.findall(r"""(?:src|href)=["']([^"'#][^"']*)""", page)
    assert [address.partition(",")[0] for address in addresses] == ["data:text/csv;base64"]
    rows = list(csv.DictReader(base64.b64decode(addresses[0].partition(",")[2]).decode().split()))
    assert len(rows) == 100 * 5
    assert {row["column"] for row in rows} == {"good"}
    assert sum(int(row["rating"]) for row in rows[:5]) == 12


def test_the_page_is_the_same_on_every_run_and_tells_what_depends(tmp_path, capsys):
    (tmp_path / "t.csv").write_text(
        "label,n,mean,sd,scale_maximum\na<b,5,2.40,1.14,9\nc,5,6.40,1.52,9\n"
    )
    words = ["reconstruct", str(tmp_path / "t.csv"), "--conclusions", "--design", "paired"]
    for name in ("one", "two"):
        assert commands.main([*words, "--html", str(tmp_path / name)]) == 0
    capsys.readouterr()
    page = (tmp_path / "one").read_text(encoding="utf-8")
    assert page == (tmp_path / "two").read_text(encoding="utf-8")
    assert "a&lt;b" in page
    assert "a<b" not in re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL)
    assert "Tables that attain the bounds" in page
    assert "paired t(4) of c minus a&lt;b" in page


def test_samples_and_a_page_are_not_asked_for_together(tmp_path, capsys):
    words = ["reconstruct", "biet2007_table3", "--sample", "1", "--html", str(tmp_path / "p")]
    assert commands.main(words) == 2
    assert "--html writes a page" in capsys.readouterr().err


def test_the_page_opens_with_a_verdict_and_what_to_ask(tmp_path, capsys):
    (tmp_path / "t.csv").write_text(
        "label,n,mean,sd,scale_maximum\ngood,5,2.40,1.14,9\nbad,5,2.45,1.14,9\n"
    )
    assert (
        commands.main(["reconstruct", str(tmp_path / "t.csv"), "--html", str(tmp_path / "p")]) == 1
    )
    assert "Verdict: No ratings give the published column 'bad'." in capsys.readouterr().out
    page = (tmp_path / "p").read_text(encoding="utf-8")
    first = page[: page.index("<h2>good</h2>")]
    assert "No ratings give the published column &#39;bad&#39;." in first
    assert "ratings change in steps of 1 (no step is stated)" in first
    assert "Questions for the authors" in first
    assert "GRIM" in first


def test_a_consistent_table_has_nothing_to_ask(tmp_path, capsys):
    (tmp_path / "t.csv").write_text("label,n,mean,sd,scale_maximum\ngood,5,2.40,1.14,9\n")
    assert (
        commands.main(["reconstruct", str(tmp_path / "t.csv"), "--html", str(tmp_path / "p")]) == 0
    )
    assert "Verdict: Every published column is possible." in capsys.readouterr().out
    assert "Questions for" not in (tmp_path / "p").read_text(encoding="utf-8")


def test_no_axis_goes_beyond_the_scale(column, listed):
    # Ratings from 10 to 30 in bars of one; the scale ends at 0 and 100.
    assert _axis_ends(column, listed) == (-0.5, 100.5)
    open_ = Solutions(column.column.model_copy(update={"assumed": ("maximum",)}))
    assert _axis_ends(open_, listed) == (-0.5, 30.5)
