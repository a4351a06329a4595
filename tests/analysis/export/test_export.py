"""One export of both tasks, with a zero, repetitions and a formula, looked at in parts."""

import csv
import re
import shutil
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

from slipscale import commands
from slipscale.analysis.export.files import FORMS, check_installed, write_export
from slipscale.analysis.export.word import write_word
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reporting import methods_text
from slipscale.analysis.tasks.table import STATISTICS
from slipscale.analysis.writing.references import REFERENCES
from slipscale.faults import UserError


def pdf_is_there():
    try:
        check_installed(["pdf"])
    except UserError:
        return False
    return True


@pytest.fixture(scope="module")
def analysis(dataset_of_module):
    dataset = dataset_of_module
    row = dataset.difference_row
    rng = np.random.default_rng(3)
    rows = {}
    for n in range(1, 8):
        own = [
            each | {"estimate": round(each["estimate"] * np.exp(rng.normal(0, 0.3)), 1)}
            for each in dataset.default_estimates(n, repetitions=3)
        ]
        # Each in an order of their own, so that effects of order can be told.
        order = [(5 * i + n) % len(own) for i in range(len(own))]
        rows[f"{n:02d}"] = [own[i] | {"trial": place + 1} for place, i in enumerate(order)]
    rows["02"][0] |= {"estimate": 0}
    steps = ((2.3, 1.2), (1.2, 0.5), (0.5, 0.0), (1.2, 1.2))
    differences = {
        f"{n:02d}": [
            row(
                2 * place + again + 1,
                before,
                after,
                "yes" if (before > after) != ((n + 3 * place + again) % 7 == 0) else "no",
                series=again + 1,
                verbal_report="=less" if before == 2.3 else "n/a",
            )
            for place, (before, after) in enumerate(steps)
            for again in range(2)
        ]
        for n in range(1, 8)
    }
    return analyse(dataset(participants=7, rows=rows, differences=differences))


@pytest.fixture(scope="module")
def exported(analysis, tmp_path_factory):
    out = tmp_path_factory.mktemp("export")
    write_export(analysis, out, [form for form in FORMS if form != "pdf" or pdf_is_there()])
    return out


def everything_recomputed(folder, but=0):
    count = len(pd.read_csv(folder / "numbers.csv"))
    return f"{count - but} of {count} numbers recomputed, 0 differ"


def differing(said):
    return "\n".join(line for line in said.splitlines() if "DIFFERS" in line or "not " in line)


def with_a_wrong_number(exported, folder):
    """Copy what the script reads, with two kinds of numbers; Friedman's χ² is too large."""
    for path in [*exported.glob("*.csv"), exported / "recompute.R"]:
        shutil.copy(path, folder)
    numbers = pd.read_csv(folder / "numbers.csv")
    # The script computes no growth function and no reliability that is not listed.
    numbers = numbers[numbers["name"].str.match(r"friedman\.|mixed_model\.")]
    wrong = numbers["name"] == "friedman.chi2"
    assert wrong.sum() == 1
    numbers["value"] = numbers["value"].where(~wrong, 1.001 * numbers["value"])
    numbers.to_csv(folder / "numbers.csv", index=False)


def test_the_list_of_numbers_holds_every_part_of_the_report(exported):
    parts = {name.split(".")[0] for name in pd.read_csv(exported / "numbers.csv")["name"]}
    assert parts >= {"table3", "rm_anova", "pairwise", "growth", "order", "reliability"}
    assert parts >= {"mixed_model", "friedman", "power_law", "robustness", "difference"}


@pytest.mark.skipif(not shutil.which("Rscript"), reason="no R here: recompute.R was not run")
def test_the_r_script_recomputes_every_number_and_sees_a_wrong_one(exported, tmp_path):
    done = subprocess.run(
        ["Rscript", exported / "recompute.R"], capture_output=True, text=True, check=False
    )
    # Without lme4 the mixed model is nlme's, which may give up.
    mixed = sum(line.startswith("not recomputed: mixed_model") for line in done.stdout.splitlines())
    assert everything_recomputed(exported, mixed) in done.stdout, differing(done.stdout)
    assert done.returncode == 0, done.stderr
    with_a_wrong_number(exported, tmp_path)
    (tmp_path / "answers.csv").unlink()
    script = tmp_path / "recompute.R"
    script.write_text(script.read_text("utf-8").replace("lme4", "not.installed"), "utf-8")
    done = subprocess.run(["Rscript", script], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert " 1 differ" in done.stdout


def test_word_has_the_report_s_headings_tables_and_figures(exported, tmp_path):
    from docx import Document

    report = (exported / "report.html").read_text(encoding="utf-8")
    document = Document(exported / "report.docx")
    headings = [p.text for p in document.paragraphs if p.style.name == "Heading 1"]
    assert headings == re.findall(r"<h2[^>]*>(.*?)</h2>", report)
    assert len(document.tables) == report.count("<table")
    assert len(document.inline_shapes) == report.count("<figure>")
    captions = [p.text for p in document.paragraphs if p.style.name == "Caption"]
    assert sum(text.startswith("Table ") for text in captions) == report.count("<table")
    # The geometric means come first, then Table III.
    first = [cell.text for cell in document.tables[1].rows[2].cells]
    mean = pd.read_csv(exported / "table3.csv")["mean"][0]
    assert first[:3] == ["0", "7", f"{mean:.2f}"]
    again = tmp_path / "again"
    again.mkdir()
    for path in [exported / "report.html", *exported.glob("*.png")]:
        shutil.copy(path, again)
    write_word(again / "report.html", again / "report.docx")
    assert (again / "report.docx").read_bytes() == (exported / "report.docx").read_bytes()


def test_a_pdf_is_written_where_pango_is(exported):
    if not pdf_is_there():
        pytest.skip("no Pango: WeasyPrint cannot lay out text here")
    assert (exported / "report.pdf").read_bytes().startswith(b"%PDF-")


def test_french_excel_reads_numbers_as_numbers_and_text_as_text(exported):
    raw = (exported / "excel-fr" / "answers.csv").read_bytes()
    assert raw.startswith(b"\xef\xbb\xbf")
    rows = list(csv.DictReader(raw.decode("utf-8-sig").splitlines(), delimiter=";"))
    assert {row["amplitude_before_um_pp"] for row in rows} == {"2,3", "1,2", "0,5"}
    assert {row["catch"] for row in rows} == {"VRAI", "FAUX"}
    assert {row["verbal_report"] for row in rows} == {"'=less", ""}
    assert {row["participant_id"] for row in rows} == {f"sub-{n:02d}" for n in range(1, 8)}


def test_the_methods_section_cites_what_it_lists(exported):
    text = (exported / "methods.md").read_text(encoding="utf-8")
    body, _, listed = text.partition("# References")
    bibliography = (exported / "references.bib").read_text(encoding="utf-8")
    for key, paper in REFERENCES.items():
        cited = f"({paper.cited})" in body
        assert cited is (paper.listed in listed) is (f"{{{key}," in bibliography), key
    assert "Friedman's test (Friedman, 1937)" in body
    assert "[[" not in text


def test_every_citation_has_its_reference():
    texts = [*methods_text.PRIMARY.values(), *(each.methods for each in STATISTICS)]
    texts += methods_text.CITED.values()
    assert set(methods_text.references(texts)) <= set(REFERENCES)
    assert all("[[" not in methods_text.cited(text) for text in texts)


@pytest.mark.parametrize("form, module", [("word", "docx"), ("pdf", "weasyprint")])
def test_a_missing_extra_is_one_sentence_and_nothing_is_written(
    form, module, table_by_hand, monkeypatch, capsys
):
    monkeypatch.setitem(sys.modules, module, None)
    path = table_by_hand("participant_id,amplitude_um_pp,estimate\na,0,1\na,1,2\nb,0,1\nb,1,3\n")
    out = path.with_name("out")
    assert commands.main(["export", str(path), "--out", str(out), "--forms", form]) == 2
    error = capsys.readouterr().err
    assert "pip install 'slipscale[export]'" in error
    assert error.count("\n") == 1
    assert not out.exists()
