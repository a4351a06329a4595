"""The page for a laboratory's own table: upload, preview, choices with consequences, report."""

import base64
import io
import json
import re
import stat
from pathlib import Path

import openpyxl
import pytest

from slipscale.commands import main
from slipscale.experiments.lab.console import own_tables
from slipscale.experiments.lab.console.own_tables import description_of, table_in, tables
from slipscale.experiments.lab.console.security import Access
from slipscale.experiments.lab.console.state import RESULTS
from slipscale.faults.message import AS_DATA

ROWS = [(who, level, "hit" if level > 1 else "miss") for who in "abc" for level in (1, 2, 4) * 2]
CSV = "who,size,outcome\n" + "".join(f"{','.join(map(str, row))}\n" for row in ROWS)
ROLES = {"who": "participant", "size": "stimulus", "outcome": "answer"}
FOLDER = Path("tables", "001")


def sent(text, *names):
    """Return an upload of files with the same content, which is text or bytes."""
    content = base64.b64encode(text if isinstance(text, bytes) else text.encode()).decode()
    return {"tables": [{"name": name, "content": content} for name in names or ["my data.csv"]]}


def described(*options, folder=FOLDER):
    """Write the description, as the started command does."""
    words = ["analyse", str(table_in(folder)), "--describe", "--out", str(folder / RESULTS)]
    return main([*words, *options])


def started(visitor):
    """Return the options of the command that was started last, without table and folder."""
    return list(visitor.jobs.started[-1][5:])


@pytest.fixture(autouse=True)
def as_data(monkeypatch):
    """Messages are written as data, as by the commands that the console starts."""
    monkeypatch.setenv(AS_DATA, "1")


@pytest.fixture
def uploaded(visitor):
    assert visitor.ask("upload", **sent(CSV)) == (200, "reading the table")
    return visitor


def test_an_uploaded_table_is_kept_for_its_owner_alone_and_described(uploaded):
    table = FOLDER / "table" / "my_data.csv"
    assert table.read_text() == CSV
    assert stat.S_IMODE(table.stat().st_mode) == 0o600
    assert {stat.S_IMODE(each.stat().st_mode) for each in (FOLDER, FOLDER.parent)} == {0o700}
    out = str(FOLDER / RESULTS)
    words = ("analyse", str(table), "--out", out, "--describe")
    assert uploaded.jobs.started == [("describe", *words)]


def test_the_page_shows_rows_proposed_uses_and_what_the_table_does_not_reveal(uploaded, words_of):
    assert described() == 0
    page = uploaded.see("/table")
    assert "my_data.csv: first of 18 rows" in words_of(page)
    assert re.findall(r"<tr><td>(.*?)</td><td>(.*?)</td>", page)[:2] == [("a", "1"), ("a", "2")]
    chosen = re.findall(r'<option value="(\w+)" selected>', page)
    assert chosen == ["participant", "stimulus", "answer"]
    assert "State what each code means" in words_of(page)
    assert "Make the report" not in page


def test_choices_become_options_and_the_page_shows_their_consequence(uploaded, words_of):
    described()
    codes = {"hit": "yes", "miss": "no"}
    uploaded.ask("describe", number="001", roles=ROLES, codes=codes, unit="mm", alternatives="2")
    options = started(uploaded)
    assert options == [
        "--describe",
        "--participant=who",
        "--stimulus=size:mm",
        "--answer=outcome",
        "--alternatives=2",
        *("--yes", "hit", "--no", "miss"),
    ]
    assert described(*options) == 0
    page = uploaded.see("/table")
    assert "18 answers of 3 people at 3 levels" in words_of(page)
    assert 'value="mm"' in page
    assert "18 réponses de 3 personnes à 3 niveaux" in words_of(uploaded.see("/table?lang=fr"))


def test_a_fault_is_shown_beside_its_column_in_both_languages(uploaded, words_of):
    assert described("--participant", "who", "--stimulus", "outcome", "--response", "size") == 1
    page = uploaded.see("/table")
    [beside] = re.findall(
        r'aria-describedby="why-3".*?<span id="why-3"[^>]*>(.*?)</span>', page, re.DOTALL
    )
    assert beside.startswith("my_data.csv, line 2, column outcome: &#39;miss&#39; and 17 others")
    assert page.count('aria-invalid="true"') == 1
    assert "ne sont pas des nombres" in words_of(uploaded.see("/table?lang=fr"))


def test_a_fault_of_no_column_is_shown_above_the_columns(uploaded, words_of):
    described("--participant", "who", "--answer", "outcome")
    page = uploaded.see("/table")
    assert "aria-invalid" not in page
    assert re.search(r'<p class="bad" role="alert">[^<]*--stimulus', page)


def test_two_columns_with_the_same_use_are_rejected(uploaded):
    roles = {"who": "participant", "size": "stimulus", "outcome": "stimulus"}
    assert uploaded.ask("describe", number="001", roles=roles) == (
        409,
        "columns size and outcome have the same use; choose it for only one of them",
    )


def test_a_code_that_looks_like_an_option_is_rejected(uploaded):
    asked = {"number": "001", "roles": ROLES, "codes": {"--html": "yes"}}
    status, said = uploaded.ask("describe", **asked)
    assert (status, "would be read as an option" in said) == (409, True)


def test_the_report_is_made_with_the_choices_and_saves_them(uploaded, words_of):
    codes = {"hit": "yes", "miss": "no"}
    described()
    uploaded.ask("report", number="001", roles=ROLES, codes=codes)
    kind, *words = uploaded.jobs.started[-1]
    assert (kind, words[-1]) == ("report", "--map")
    assert "--steps" in words
    assert main(words) == 0
    assert (FOLDER / "table" / "analysis.toml").is_file()
    assert table_in(FOLDER).name == "my_data.csv"
    assert "/table/001/report" in uploaded.see("/table")
    assert 'src="/table/001/report.html"' in uploaded.see("/table/001/report")
    assert "<h1" in uploaded.see("/table/001/report.html")
    # Other choices replace the saved ones.
    uploaded.ask("report", number="001", roles=ROLES, codes=codes, unit="mm")
    assert not (FOLDER / "table" / "analysis.toml").exists()


def test_a_recognised_arrangement_is_kept_unless_it_is_deselected(visitor):
    wide = "who,p10,p20,p40\n" + "".join(f"{who},1,2,4\n" for who in "abc")
    visitor.ask("upload", **sent(wide))
    described()
    assert description_of(FOLDER).layout == {"levels": ("p10", "p20", "p40")}
    asked = {"number": "001", "roles": {"who": "participant"}, "unit": "Pa"}
    visitor.ask("describe", **asked, layout=True)
    assert started(visitor)[1:] == [
        *("--participant=who", "--stimulus=:Pa", "--levels", "p10", "p20", "p40")
    ]
    assert described(*started(visitor)) == 0
    assert description_of(FOLDER).amounts.model_dump() == {"answers": 9, "people": 3, "levels": 3}
    visitor.ask("describe", **asked)
    assert "--levels" not in started(visitor)


def test_a_table_with_slipscale_s_own_columns_needs_no_choice(visitor, words_of):
    rows = [f"{who},{level},{level * 3}" for who in "abc" for level in (0.5, 1, 2) * 2]
    visitor.ask("upload", **sent("participant_id,amplitude_um_pp,estimate\n" + "\n".join(rows)))
    assert described() == 0
    page = words_of(visitor.see("/table"))
    assert "No choice is needed" in page
    assert "18 answers of 3 people at 3 levels" in page


@pytest.mark.parametrize(
    "text, said",
    [
        ("", "the file is empty; choose the file with the table"),
        (
            "x" * 1001,
            "the file is larger than 0.001 MB; analyse it with slipscale analyse in a terminal",
        ),
    ],
)
def test_an_empty_or_large_file_is_rejected(visitor, monkeypatch, text, said):
    monkeypatch.setattr(own_tables, "LARGEST_MB", 0.001)
    assert visitor.ask("upload", **sent(text)) == (409, said)
    assert tables() == []


@pytest.mark.parametrize("name", ["../../x.csv", "/etc/passwd", "analysis.toml", ".hidden", "é"])
def test_no_name_leaves_the_table_s_folder(visitor, name):
    assert visitor.ask("upload", **sent(CSV, name)) == (200, "reading the table")
    assert table_in(FOLDER).parent == FOLDER / "table"
    assert [path.name for path in Path().glob("*") if path.suffix == ".csv"] == []


def test_an_upload_may_be_longer_than_other_requests(visitor, asking):
    sizes = [("upload", 1_400_000, 200), ("describe", 1_400_000, 403), ("upload", 15_100_000, 403)]
    for action, length, status in sizes:
        body = json.dumps(sent("x,y\n" * 4)) + " " * length
        answer = visitor.client.post(f"/do/{action}", content=body, headers=asking)
        assert answer.status_code == status


def test_a_removed_table_is_gone_with_its_report(uploaded):
    assert uploaded.ask("remove", number="001") == (200, "removed: table 001")
    assert tables() == []
    assert uploaded.ask("describe", number="001") == (
        409,
        "table 001 no longer exists; reload the page",
    )


def test_a_read_only_console_shows_no_table(uploaded, make_visitor, words_of):
    described()
    (FOLDER / RESULTS / "report.html").write_text("<h1>secret</h1>")
    reader = make_visitor(Access(port=8470, read_only=True))
    page = words_of(reader.see("/table"))
    assert "outcome" not in page
    assert "only on the laboratory's computer" in page.replace("&#39;", "'")
    assert reader.client.get("/table/001/report.html").status_code == 404


def test_several_files_are_one_table(visitor, words_of):
    text = "size,outcome\n1,miss\n2,hit\n4,hit\n"
    assert visitor.ask("upload", **sent(text, "s1.csv", "s2.csv")) == (200, "reading the table")
    assert table_in(FOLDER) == FOLDER / "table"
    assert described() == 0
    page = words_of(visitor.see("/table"))
    assert "s1.csv: first of 3 rows · first of 2 files" in page
    assert "--participant-from-name" in page
    asked = {"number": "001", "roles": {"size": "stimulus", "outcome": "answer"}, "layout": True}
    visitor.ask("report", **asked, codes={"hit": "yes", "miss": "no"})
    assert main(visitor.jobs.started[-1][1:]) == 0
    assert (FOLDER / "table" / "analysis.toml").is_file()
    assert table_in(FOLDER) == FOLDER / "table"
    described("--participant-from-name", "--stimulus=size", "--answer=outcome", "--yes=hit")
    assert "6 answers of 2 people at 3 levels" in words_of(visitor.see("/table"))


def test_files_with_the_same_name_are_rejected(visitor):
    said = "two files have the same name; rename one of them"
    assert visitor.ask("upload", **sent(CSV, "a b.csv", "a_b.csv")) == (409, said)


def test_a_sheet_of_a_workbook_is_chosen(visitor, words_of):
    book, stored = openpyxl.Workbook(), io.BytesIO()
    book.active.title = "notes"
    for row in (("day", "room"), ("Monday", 1), ("Friday", 2)):
        book.active.append(row)
    data = book.create_sheet("data")
    for line in CSV.splitlines():
        data.append(line.split(","))
    book.save(stored)
    visitor.ask("upload", **sent(stored.getvalue(), "book.xlsx"))
    assert described() == 0
    page = visitor.see("/table")
    assert "Choose the sheet that contains the data" in words_of(page)
    assert "<option selected>notes</option><option>data</option>" in page
    visitor.ask("describe", number="001", sheet="data")
    assert started(visitor) == ["--describe", "--sheet=data"]
    assert described("--sheet=data") == 0
    page = visitor.see("/table")
    assert "Choose the sheet" not in words_of(page)
    assert '<input type="hidden" name="sheet" value="data">' in page
    visitor.ask(
        "describe", number="001", sheet="data", roles=ROLES, codes={"hit": "yes", "miss": "no"}
    )
    assert described(*started(visitor)[1:]) == 0
    assert "18 answers of 3 people at 3 levels" in words_of(visitor.see("/table"))
