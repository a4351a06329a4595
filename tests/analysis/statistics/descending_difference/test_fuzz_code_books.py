"""Code books as people write them, by the thousand: used, or refused in a sentence.

A campaign of all such tests: ``make fuzz TEXTS=100000``.
"""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.statistics.descending_difference.verbal_coding import OTHER, SHIPPED, load_codebook
from faults import UserError
from tools.fuzzing import bounded, campaign, changed_file

TEXT = SHIPPED.read_text(encoding="utf-8")
REPORTS = st.one_of(
    st.sampled_from(["", "moins glissant, plus rugueux", "less slippery", "x" * 5000]), st.text()
)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz") / "codebook.toml"


@campaign(quick=200)
@given(changed_file(TEXT), REPORTS)
def test_a_code_book_codes_any_report_or_is_refused_in_a_sentence(path, content, report):
    path.write_bytes(content)
    with bounded():
        try:
            book = load_codebook(path)
        except UserError as error:
            assert str(path) in str(error)  # noqa: PT017 - wherever the fault is
            return
        found = book.code(report)
        assert found
        for category in found:
            if category != OTHER:
                assert book.direction(report, category) in ("less", "more", "bare")
