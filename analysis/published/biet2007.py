"""Provide the printed results of Biet, Giraud and Lemaire-Semail (2007).

Biet, Giraud, Lemaire-Semail, "Squeeze film effect for the design of an ultrasonic tactile plate",
IEEE Transactions on Ultrasonics, Ferroelectrics, and Frequency Control 54(12), 2007, pp. 2678-2688.
Numbers are stored as strings, so that the printed decimals are kept.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from slipscale.analysis.published.printed_numbers import Printed
from slipscale.stimuli.quantity import Quantity

#: Name of the shipped study that replicates the paper.
STUDY = "biet2007"

#: Participants in Section IV-B of the paper: nine men, three women, aged between 18 and 25.
PARTICIPANTS = 12

#: File with Table III as printed.
TABLE3_FILE = Path(__file__).with_name("biet2007_table3.toml")

#: A data set that is consistent with Table III: twelve integer ratings per column, found by a
#: search. The authors never published their raw data, and other data sets give the same table.
ALLOWED_DATASET = Path(__file__).with_name("biet2007_table3_dataset.csv")

NOT_RAW_DATA = (
    "computed from a data set that is consistent with Table III and was found by a search; the "
    "authors never published their raw data"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class TableRow:
    """A column of Table III (normalised estimates, 0-100), as printed strings.

    ``amplitude_um_pp`` is peak to peak, as stated in Section IV-B.
    """

    amplitude_um_pp: str
    mean: str
    maximum_deviation: str
    standard_deviation: str


def _table3() -> tuple[TableRow, ...]:
    columns = tomllib.loads(TABLE3_FILE.read_text(encoding="utf-8"))["column"]
    return tuple(
        TableRow(
            amplitude_um_pp=str(column["amplitude_um_pp"]),
            mean=column["mean"],
            maximum_deviation=column["maximum_deviation"],
            standard_deviation=column["sd"],
        )
        for column in columns
    )


#: Columns of Table III, from the plate at rest to the largest amplitude.
TABLE3: tuple[TableRow, ...] = _table3()

#: Estimates were "multiplied in order to bring them to 100" (Section IV-B).
TOP = 100.0

STATISTICS: tuple[str, ...] = ("mean", "maximum_deviation", "standard_deviation")


#: The same columns, keyed by amplitude in µm peak to peak.
BY_AMPLITUDE: dict[float, TableRow] = {float(row.amplitude_um_pp): row for row in TABLE3}


def covers(amplitudes_um_pp: Iterable[object], quantity: Quantity) -> bool:
    """Return whether the levels are plate amplitudes that Table III contains."""
    return quantity.of_plate and set(amplitudes_um_pp) <= set(BY_AMPLITUDE)


def agrees(published: str, ours: float) -> bool:
    """Return whether a computed value rounds to the published number.

    A value exactly half-way between two rounded numbers agrees with both.

    >>> agrees("19.58", 235 / 12), agrees("19.58", 19.574)
    (True, False)
    """
    allowed = Printed(published).values("nearest")
    # The tolerance allows for floating-point errors in a mean of twelve values.
    slack = Fraction(1, 10**12) * max(abs(allowed.high), Fraction(1))
    return allowed.low - slack <= Fraction(ours) <= allowed.high + slack
