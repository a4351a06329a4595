"""Generate the example report on all possible data sets of Table III (Biet et al., 2007)."""

from __future__ import annotations

from slipscale.analysis.published.biet2007 import TABLE3_FILE
from slipscale.analysis.reconstruction.answers import Across, column_answer
from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.inference.distributions import SAMPLES, distributions
from slipscale.analysis.reconstruction.table.table_files import read
from slipscale.analysis.reconstruction_page.page import Source, render
from slipscale.analysis.reproduction.attained_bounds import known

SEED = 1
PAGE = "reconstruct-table3.html"


def pages() -> dict[str, str]:
    """Return the page that `slipscale reconstruct biet2007_table3 --conclusions --html` writes.

    It uses recorded bounds computed from its tables, because searching for them takes a minute.
    """
    table = read(TABLE3_FILE)
    columns = [Solutions(column) for column in table.columns]
    source = Source(
        title=table.title,
        columns=tuple((one, column_answer(one, "multisets")) for one in columns),
        tests=(),
        across=Across(
            bounds=known("sample"),
            not_listed=(),
            distributions=tuple(distributions([Sampler(one) for one in columns], SEED, SAMPLES)),
        ),
        measure="multisets",
        seed=SEED,
    )
    return {PAGE: render(source)}
