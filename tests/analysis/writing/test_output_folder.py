"""The folder of results is as private as its data set."""

import sys

import pytest

from slipscale.analysis.writing.output_folder import make_folder


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX permissions")
@pytest.mark.parametrize("data, results", [(0o600, 0o700), (0o644, 0o755)])
def test_results_of_a_private_data_set_are_private(tmp_path, data, results):
    (tmp_path / "participants.tsv").touch()
    (tmp_path / "participants.tsv").chmod(data)
    out = tmp_path / "derivatives/slipscale"
    out.mkdir(mode=0o755, parents=True)  # made by an earlier analysis
    make_folder(out)
    assert out.stat().st_mode & 0o777 == results
