"""Fuzz ``analysis.toml``: the table that it describes must be read or rejected with a message."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random

from slipscale.analysis.load import load
from slipscale.analysis.reading.meaning.mapping import NAME
from slipscale.faults import UserError
from tests.fuzzing.changes import changed_file
from tests.fuzzing.kind import Case, Kind

LONG = """person,level,rating,felt,run,sex
a,0,12.5,yes,1,f
a,1.2,40,no,1,f
b,0,20,no,2,m
b,1.2,"45,5",yes,2,
"""
WIDE = """person,quiet,loud,sex
a,12.5,40,f
b,20,45.5,m
"""
ANALYSIS = """
[analysis]
normalisation = "none"
confidence = 0.95
"""
RATED = """[columns]
participant = "person"
stimulus = "level"
response = "rating"
group = "sex"
run = "run"
[stimulus]
name = "amplitude"
unit = "µm"
in_unit = "nm"
[table]
decimal = ","
only = { sex = "f" }
"""
ANSWERED = """[columns]
participant = "person"
stimulus = "level"
answer = "felt"
reference = "rating"
session = "run"
"""
IN_COLUMNS = """[columns]
participant = "person"
group = "sex"
[levels]
quiet = 1.0
loud = 2.5
[stimulus]
unit = "dB"
judged = "loudness"
"""
# A table and the meaning of its columns.
PAIRS = ((LONG, RATED), (LONG, ANSWERED), (WIDE, IN_COLUMNS))


def _prepared(folder: Path) -> Callable[[Random], Case]:
    places = []
    for number, (table, text) in enumerate(PAIRS):
        place = folder / str(number)
        place.mkdir()
        (place / "ratings.csv").write_text(table, encoding="utf-8")
        places.append((place, text + ANALYSIS))

    def drawn(random: Random) -> Case:
        place, text = random.choice(places)
        content = changed_file(random, text)
        return Case(name=NAME, content=content, use=lambda: _use(place, content))

    return drawn


def _use(place: Path, content: bytes) -> bool:
    (place / NAME).write_bytes(content)
    try:
        data = load(place / "ratings.csv")
    except UserError as error:
        if str(place) not in str(error):
            raise AssertionError(f"no file is named: {error}") from error
        return False
    if data.counts["analysed"] != len(data.estimates):
        raise AssertionError(f"{data.counts}, {len(data.estimates)} estimates")
    return True


KIND = Kind(title="column meanings (analysis.toml)", prepared=_prepared)
