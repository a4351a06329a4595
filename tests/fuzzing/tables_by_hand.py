"""Fuzz tables from spreadsheets, which must be read or rejected with an error message.

The tables have any separator, with or without decimal commas, thousands separators and quotation
marks, in UTF-8, CP1252 or UTF-16.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random

from slipscale.analysis.load import load
from slipscale.analysis.reading.meaning.mapping import TableMapping, parse_mapping
from slipscale.faults import UserError
from tests.fuzzing.kind import Case, Kind

NAMES = ("participant_id", "amplitude_um_pp", "estimate")
OTHER_NAMES = (
    *("trial", "block", "session", "phase", "flag", "texture", "response_time", "scale_top"),
)
ODD = (
    *("", " ", "n/a", "NA", "?", "-", ".", ",", "#DIV/0!", "TRUE", "yes", "=A1", "1e999", "-3"),
    *("1,000", "1.000", "12e", "٣", "½", "\ufeff1", "\x1f", "9" * 5000, "1" + "0" * 400),
    *('"', '"a', 'a"b', '""', "a\nb", "é", "µ", "\u2028"),
)
PEOPLE = ("a", "b", "Élodie", "01", "NA", '"NA"', "null", " a ")
SEPARATORS = (";", "\t", ",")
LINE_ENDS = ("\n", "\r\n", "\r")
ENCODINGS = ("utf-8", "utf-8-sig", "cp1252", "utf-16", "utf-16-le")
COMMAS = str.maketrans(",.", ".,")
MOST_ROWS = 8


def _prepared(folder: Path) -> Callable[[Random], Case]:
    path = folder / "ratings.csv"
    mapping = parse_mapping(
        {"columns": {"participant": NAMES[0], "stimulus": NAMES[1], "answer": NAMES[2]}}, "here"
    )

    def drawn(random: Random) -> Case:
        content = _table(random)
        meant = random.choice((None, mapping))
        return Case(name=path.name, content=content, use=lambda: _use(path, content, meant))

    return drawn


def _table(random: Random) -> bytes:
    separator = random.choice(SEPARATORS)
    commas = random.randrange(2)
    names = [*NAMES, *random.sample(OTHER_NAMES, random.randint(0, 3))]
    if random.randrange(10) == 0:
        place = random.randrange(len(names))
        names[place] = random.choice((f'"{names[place]}', "", names[0], "x" * 300))
    rows = [separator.join(names)]
    for _ in range(random.randint(0, MOST_ROWS)):
        cells = [random.choice(ODD if random.randrange(6) == 0 else PEOPLE)]
        for _ in names[1:]:
            cell = _number(random) if random.randrange(6) else random.choice(ODD)
            cell = cell.translate(COMMAS) if commas else cell
            quoted = separator in cell and random.randrange(8)
            cells.append(f'"{cell}"' if quoted else cell)
        if random.randrange(12) == 0:
            cells = cells[: random.randint(0, len(cells))]
        rows.append(separator.join(cells))
    content = random.choice(LINE_ENDS).join(rows).encode(random.choice(ENCODINGS), "replace")
    return content[: random.randint(0, len(content))] if random.randrange(10) == 0 else content


def _number(random: Random) -> str:
    whole = random.randint(0, 10 ** random.randint(1, 6))
    decimal = random.uniform(0, 10 ** random.randint(0, 5))
    return random.choice(
        (
            f"{decimal:.3g}",
            f"{whole:,}",
            f"{whole:,}".replace(",", " "),
            f"{whole:,}".replace(",", "\u202f"),
            f"{decimal:,.2f}",
        )
    )


def _use(path: Path, content: bytes, mapping: TableMapping | None) -> bool:
    path.write_bytes(content)
    try:
        data = load(path, mapping)
    except UserError as error:
        if path.name not in str(error):
            raise AssertionError(f"the error does not name the file: {error}") from error
        return False
    if not data.counts["analysed"] == len(data.estimates) <= data.counts["estimation_rows"]:
        raise AssertionError(f"{data.counts}, {len(data.estimates)} estimates")
    return True


KIND = Kind(title="hand-made tables", prepared=_prepared)
