"""Fuzz published tables, which must be read, with the sums that they imply, or rejected."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random

from slipscale.analysis.reconstruction.data_sets.constraints import targets
from slipscale.analysis.reconstruction.table.table_files import SHIPPED, read
from slipscale.faults import UserError
from tests.fuzzing.changes import changed_file
from tests.fuzzing.kind import Case, Kind

CSV = """label,n,mean,sd,scale_minimum,scale_maximum,maximum_deviation,rounding,median
0 um,12,12.75,12.75,0,100,27.25,,
1.2 um,12,46.2,20.1,0,100,,truncated,
"1,2",7,3.14,0.90,1,7,,,3
"""
# A table with most keys of the file format.
TOML = """
title = "Much that a table can print"
design = "paired"
[scale]
minimum = 0
maximum = 100
step = "1/2"
[[column]]
label = "mean and interval"
n = 12
mean = "12.75"
se = "3.68"
ci_low = "4.6"
ci_high = "20.9"
ci_percent = 95
observed_minimum = "0"
observed_maximum = "40"
median = "9.5"
[[column]]
label = "sum and SD"
n = 12
sum = "153"
sd = "12.75"
sd_convention = "population"
rounding = "truncated"
maximum_deviation = "27.25"
lower_quartile = "3"
upper_quartile = "20"
present = ["0", "40"]
absent = ["39.5"]
frequencies = { "0" = 3, "10" = 1 }
percentages = { "20" = "8.3" }
amplitude_um_pp = 1.2
[[test]]
kind = "paired_t"
statistic = "2.31"
columns = ["mean and interval", "sum and SD"]
"""

# A scale so fine that few data sets can be listed.
FINE = TOML.replace('step = "1/2"', 'step = "0.001"')


def _prepared(folder: Path) -> Callable[[Random], Case]:
    shipped = [path.read_text(encoding="utf-8") for path in sorted(SHIPPED.glob("*.toml"))]
    texts = [(text, "toml", "") for text in (*shipped, TOML, FINE)]
    texts += [(CSV, "csv", ","), (CSV.replace(",", ";"), "csv", ";")]

    def drawn(random: Random) -> Case:
        text, ending, cells = random.choice(texts)
        path = folder / f"table.{ending}"
        content = changed_file(random, text, cells)
        return Case(name=path.name, content=content, use=lambda: _use(path, content))

    return drawn


def _use(path: Path, content: bytes) -> bool:
    path.write_bytes(content)
    try:
        table = read(path)
    except UserError as error:
        if str(path) not in str(error):
            raise AssertionError(f"the error does not name the file: {error}") from error
        return False
    if not [targets(column) for column in table.columns]:
        raise AssertionError("a table without columns")
    return True


KIND = Kind(title="published tables", prepared=_prepared)
