"""Fuzz data sets, which must be analysed and verified, or rejected with an error message.

A data set of one short run is written once per protocol. Each input replaces one of its files,
which is restored afterwards. Journals are read only once, because they are not changed here (they
are fuzzed separately). Errors in two files at a time are not tested.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random
from unittest import mock

from slipscale.analysis.load import load
from slipscale.experiments.dataset import verification
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.journals import Problem, Run, read_runs
from slipscale.faults import UserError
from tests.fuzzing.changes import changed_file
from tests.fuzzing.kind import Case, Kind
from tests.fuzzing.recorded import record

JOURNALS = "sourcedata"


def _prepared(folder: Path) -> Callable[[Random], Case]:
    datasets = [folder / protocol for protocol in record(folder)]
    files = []
    for dataset in datasets:
        if problems := build_dataset(dataset):
            raise RuntimeError(f"{dataset.name}: {problems}")
        (dataset / "code").mkdir(exist_ok=True)
        study = dataset / "code" / "study.toml"
        study.write_bytes((folder / f"{dataset.name}.toml").read_bytes())
        found = sorted(path for path in dataset.rglob("*") if path.is_file())
        files.append([(path, path.read_bytes()) for path in found if JOURNALS not in path.parts])

    def drawn(random: Random) -> Case:
        place = random.randrange(len(datasets))
        path, whole = random.choice(files[place])
        content = changed_file(random, whole.decode(), "\t" if path.suffix == ".tsv" else "")
        name = path.relative_to(folder).as_posix()
        use = lambda: _use(datasets[place], path, content, whole)  # noqa: E731 - as in all kinds
        return Case(name=name, content=content, use=use)

    return drawn


@cache
def _read_once(dataset: Path) -> tuple[list[Run], list[Problem]]:
    return read_runs(dataset)


def _runs(dataset: Path) -> tuple[list[Run], list[Problem]]:
    runs, problems = _read_once(dataset)
    return list(runs), list(problems)


def _use(dataset: Path, path: Path, content: bytes, whole: bytes) -> bool:
    path.write_bytes(content)
    try:
        with mock.patch.object(verification, "read_runs", _runs):
            return _taken(dataset)
    finally:
        path.write_bytes(whole)


def _taken(dataset: Path) -> bool:
    try:
        data = load(dataset)  # also verifies
    except UserError as error:
        if not str(error):
            raise
        if not all(str(problem) for problem in verification.verify(dataset)):
            raise AssertionError("a difference without words") from error
        return False
    if data.counts["analysed"] != len(data.estimates):
        raise AssertionError(f"{data.counts}, {len(data.estimates)} estimates")
    return True


KIND = Kind(title="data set files", prepared=_prepared)
