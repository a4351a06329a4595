"""Tables of simulated studies, and the forms that data take: sessions, missing cells, ties, ..."""

import csv
import shutil
from dataclasses import dataclass

from benchmarks.truths import LEVELS, study_text
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.bare_dataset import write_simulated
from slipscale.experiments.running.pilot import pilot_plans

PEOPLE = 4
PEOPLE_LIKE = Population(
    name="plain",
    levels=LEVELS,
    mean_sensation=(20.0, 35.0, 55.0, 75.0),
    sd_sensation=(8.0, 8.0, 10.0, 8.0),
    shared=0.5,
    noise=12.0,
)


@dataclass
class Table:
    """A table of a run, by the labels of its file name."""

    who: str
    task: str
    rows: list[dict[str, str]]
    session: str = ""
    run: str = "01"


def tables_of(folder):
    for path in sorted(folder.glob("sub-*/beh/*_beh.tsv")):
        labels = dict(part.split("-") for part in path.stem.split("_")[:-1])
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
        yield Table(who=f"sub-{labels['sub']}", task=labels["task"], rows=rows)


def write(folder, source, tables, groups, factor):
    """Write a data set with other tables; return its folder."""
    shutil.copytree(source, folder)
    sidecars = {path.parent.parent.name: path for path in folder.glob("sub-*/beh/*_beh.json")}
    texts = {who: path.read_bytes() for who, path in sidecars.items()}
    for path in folder.glob("sub-*/beh/*"):
        path.unlink()
    for table in tables:
        session = [f"ses-{table.session}"] if table.session else []
        place = folder.joinpath(table.who, *session, "beh")
        place.mkdir(parents=True, exist_ok=True)
        name = "_".join([table.who, *session, f"task-{table.task}", f"run-{table.run}", "beh"])
        lines = ["\t".join(table.rows[0]), *("\t".join(row.values()) for row in table.rows)]
        (place / f"{name}.tsv").write_text("\n".join(lines) + "\n", encoding="utf-8")
        (place / f"{name}.json").write_bytes(texts[table.who])
    whose = sorted({table.who for table in tables})
    lines = ["participant_id\tgroup" if groups else "participant_id"]
    lines += [f"{who}\t{'ab'[n % 2]}" if groups else who for n, who in enumerate(whose)]
    (folder / "participants.tsv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    if factor:
        study = folder / "code" / "study.toml"
        text = study.read_text(encoding="utf-8")
        more = '\n[[factors]]\nname = "hand"\nlevels = ["left", "right"]\n'
        study.write_text(text + more, encoding="utf-8")
    return folder


def answered(rows, answer):
    return [
        row
        for row in rows
        if row["phase"] == "main" and row.get("catch", "false") != "true" and row[answer] != "n/a"
    ]


def plain(tables, kind):
    return tables


def one_participant(tables, kind):
    return [table for table in tables if table.who == "sub-02"]


def sessions(tables, kind):
    """Every second trial belongs to a second session."""
    return halves(tables, lambda table, n, rows: Table(table.who, table.task, rows, f"{n + 1}"))


def runs(tables, kind):
    return halves(
        tables, lambda table, n, rows: Table(table.who, table.task, rows, "", f"0{n + 1}")
    )


def several_tasks(tables, kind):
    """A second task of the same kind has the trials of all but one participant."""
    more = [Table(table.who, f"{table.task}B", table.rows) for table in tables[1:]]
    return [*tables, *more]


def factor(tables, kind):
    """All trials are done with the left hand, and then again with the right hand."""
    for table in tables:
        left = [row | {"hand": "left"} for row in table.rows]
        later = len(left)
        right = [
            row | {"hand": "right", "trial": str(int(row["trial"]) + later)} for row in table.rows
        ]
        table.rows = left + right
    return tables


def halves(tables, make):
    made = [
        make(table, n, [row for p, row in enumerate(table.rows) if unit(table.rows, p) % 2 == n])
        for table in tables
        for n in (0, 1)
    ]
    return [table for table in made if table.rows]


def unit(rows, place):
    """Return the series of a row, which must stay whole, or its own number."""
    return int(rows[place]["series"]) if "series" in rows[place] else place // 2


def missing_cell(tables, kind):
    """One participant has no answer at one level."""
    rows = tables[1].rows
    first = next(row[kind.cell] for row in answered(rows, kind.answer))
    tables[1].rows[:] = [row for row in rows if row[kind.cell] != first]
    return tables


def ties(tables, kind):
    """Everybody gives the same answer at one level."""
    first = next(row[kind.cell] for row in answered(tables[0].rows, kind.answer))
    same = next(row[kind.answer] for row in answered(tables[0].rows, kind.answer))
    for table in tables:
        for row in table.rows:
            if row[kind.cell] == first and row[kind.answer] != "n/a":
                row[kind.answer] = same
    return tables


def zeros(tables, kind):
    """One participant gives the lowest possible answer in their first trial."""
    if kind.zero is not None:
        answered(tables[0].rows, kind.answer)[0][kind.answer] = kind.zero
    return tables


VARIATIONS = (
    plain,
    factor,
    sessions,
    runs,
    missing_cell,
    one_participant,
    ties,
    zeros,
    several_tasks,
)


def simulate(protocol, folder):
    """Simulate a small study of a protocol; return the folder of its data."""
    (folder / "study.toml").write_text(study_text(protocol), encoding="utf-8")
    plans = pilot_plans(
        str(folder / "study.toml"),
        participants=PEOPLE,
        seed=5,
        language=None,
        population=PEOPLE_LIKE,
    )
    write_simulated(folder / "data", plans, PEOPLE_LIKE, sessions=False)
    return folder / "data"
