"""Fuzz journals of every protocol, which must be read, built and resumed, or rejected.

In most inputs, checksums and hashes are recomputed, as if a program had written wrong content. With
the original checksums, changes would be detected as disk errors before the content is read.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Any

from slipscale.experiments.dataset.journals import read_runs
from slipscale.experiments.dataset.rendering import render
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.journal.record import Record, decode, sealed
from slipscale.experiments.running.pilot import run_simulated
from slipscale.faults import RigError, UserError
from tests.fuzzing.changes import changed_file, characters
from tests.fuzzing.kind import Case, Kind
from tests.fuzzing.recorded import record

if TYPE_CHECKING:
    from slipscale.experiments.study.run_plan import RunPlan

KINDS = (
    *("header", "begin", "done", "void", "end", "resume", "fault", "pause", "go_on", "stop"),
    *("standard_again", "take_up", "discarded", "retry", "given_up", "markers", "note", "nothing"),
)
CHANGES = ("set", "set", "set", "remove", "rename", "kind", "number", "time", "drop", "again")
DEEPEST = 3
# One in DAMAGED journals has changed bytes without recomputed checksums.
DAMAGED = 5
# One in GONE_ON_WITH journals is truncated, and its run is then resumed.
GONE_ON_WITH = 6


def _prepared(folder: Path) -> Callable[[Random], Case]:
    plans = record(folder)
    paths = {name: plan.journal_path(folder / name) for name, plan in plans.items()}
    lines = {name: path.read_bytes().splitlines(keepends=True) for name, path in paths.items()}
    records = {name: [decode(line)[0] for line in each] for name, each in lines.items()}

    def drawn(random: Random) -> Case:
        name = random.choice(list(paths))
        plan = plans[name] if random.randrange(GONE_ON_WITH) == 0 else None
        most = random.randrange(1, len(lines[name])) if plan else len(lines[name])
        if random.randrange(DAMAGED) == 0:
            content = changed_file(random, b"".join(lines[name][:most]).decode())
        else:
            content = _rewritten(lines[name][:most], records[name][:most], random)
        return Case(
            name=paths[name].relative_to(folder).as_posix(),
            content=content,
            use=lambda: _use(folder / name, paths[name], content, plan),
        )

    return drawn


def _rewritten(lines: Sequence[bytes], records: Sequence[Record], random: Random) -> bytes:
    """Return a journal with one or two records changed and all later hashes recomputed."""
    new = list(records)
    first = len(new)
    for _ in range(random.choice((1, 1, 2))):
        if not new:  # the only record was dropped
            break
        at = random.randrange(len(new))
        first = min(first, at)
        new[at : at + 1] = _changed(new[at], random)
    made = list(lines[:first])
    before = records[first - 1].hash if first else ""
    for each in new[first:]:
        whole, line = sealed(each, before)
        before = whole.hash
        made.append(line)
    return b"".join(made)


def _changed(record: Record, random: Random) -> list[Record]:
    how = random.choice(CHANGES)
    times_s = (-1.0, 0.0, 1e308, random.random() * 1e4)
    whole = {
        "drop": [],
        "again": [record, record],
        "kind": [replace(record, kind=random.choice(KINDS))],
        "number": [replace(record, number=random.randint(-1, 400))],
        "time": [replace(record, time_s=random.choice(times_s))],
    }
    entries = list(_entries(record.data))
    if how in whole or not entries:
        return whole.get(how, [record])
    return [replace(record, data=_set(record.data, random.choice(entries), how, random))]


def _entries(value: object, way: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    inner: Any = ()
    if isinstance(value, Mapping):
        inner = value.items()
    elif isinstance(value, list):
        inner = enumerate(value)
    for key, each in inner:
        yield (*way, key)
        yield from _entries(each, (*way, key))


def _set(data: dict[str, Any], way: tuple[Any, ...], how: str, random: Random) -> dict[str, Any]:
    new: dict[str, Any] = json.loads(json.dumps(data))
    *outer, last = way
    target: Any = new
    for key in outer:
        target = target[key]
    if how == "remove":
        del target[last]
    elif how == "rename" and isinstance(target, dict):
        target[f"x{last}"] = target.pop(last)
    elif isinstance(target[last], str) and random.randrange(2):
        # Texts, such as a study or a plate's description, are changed slightly.
        target[last] = changed_file(random, target[last]).decode(errors="replace")
    else:
        target[last] = _value(random)
    return new


def _value(random: Random, depth: int = 0) -> object:
    if depth < DEEPEST and random.randrange(4) == 0:
        inner = [_value(random, depth + 1) for _ in range(random.randint(0, 3))]
        return inner if random.randrange(2) else {characters(random, 4): each for each in inner}
    return random.choice(
        (
            random.choice((None, True, False, {}, [], "")),
            random.randint(-3, 300),
            random.choice((10**26, -(10**400), 2**63, 1e308, -1e-320, 0.0)),
            random.uniform(-5, 5),
            random.choice(("n/a", "../x", "\x1b[2J", "main", "practice", "nan", "1,5")),
            characters(random, 8),
        )
    )


def _use(dataset: Path, path: Path, content: bytes, plan: RunPlan | None) -> bool:
    path.write_bytes(content)
    runs, problems = read_runs(dataset)
    files, unfit = render(runs)
    told = [str(problem) for problem in (*problems, *unfit)]
    # An empty file is a run that has not begun.
    if (content and not (files or told)) or not all(told):
        raise AssertionError("neither tables nor a sentence")
    if plan:
        try:
            read_plan(path)
            run_simulated(dataset, plan, "mock")
        except (UserError, RigError) as error:
            if not str(error):
                raise
            return False
    return bool(files) and not told


KIND = Kind(title="journals", prepared=_prepared)
