"""Data sets with a file changed, by the thousand: read and verified, or refused in a sentence.

A campaign of all such tests: ``make fuzz TEXTS=100000``.
"""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.reading.load import load
from experiments.dataset.bids import build_dataset
from experiments.dataset.verification import verify
from faults import UserError
from tools.fuzzing import bounded, campaign, changed_file


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A pilot's data set, and the bytes of all its files."""
    from tools.torture.pilots import EVERY_OPTION, plans_of, run_simulated  # noqa: PLC0415

    folder = tmp_path_factory.mktemp("fuzz") / "data"
    for plan in plans_of("biet2007", 2) + plans_of(str(EVERY_OPTION), 1)[:1]:
        run_simulated(folder, plan, "mock")
    build_dataset(folder)
    files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return folder, {path: path.read_bytes() for path in files}


@campaign(quick=25)
@given(data=st.data())
def test_a_data_set_is_read_and_verified_or_refused_in_a_sentence(whole, data):
    folder, files = whole
    path = data.draw(st.sampled_from(sorted(files)))
    cells = "\t" if path.suffix == ".tsv" else ""
    path.write_bytes(data.draw(changed_file(files[path].decode(), cells)))
    try:
        with bounded():
            try:
                loaded = load(folder)
                assert loaded.counts["analysed"] == len(loaded.estimates)
            except UserError as error:
                assert str(error)  # noqa: PT017 - any sentence
            try:
                assert all(str(problem) for problem in verify(folder))
            except UserError as error:
                assert str(error)  # noqa: PT017 - any sentence
    finally:
        path.write_bytes(files[path])
