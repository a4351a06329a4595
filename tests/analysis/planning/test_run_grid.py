"""A grid's shards: the same digits however they were computed, and none believed that is wrong."""

import errno
import json
import os
import signal
from pathlib import Path

import pytest
from scipy.special import ndtri

from slipscale import commands
from slipscale.analysis.planning.power.design import design_of
from slipscale.analysis.planning.power.grid import Condition
from slipscale.analysis.planning.power.run_grid import Part, estimated_s, missing, run_grid, shards
from slipscale.analysis.planning.power.sequential import levels, look_sizes
from slipscale.analysis.planning.power.shard import STUDIES_A_SHARD, Shard
from slipscale.analysis.planning.power.shard_cache import MARK, ShardCache
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.study.file import read_study
from slipscale.faults import UserError

STUDY, TEXT = read_study("biet2007")
DESIGN = design_of(STUDY, TEXT, Population(), 0.05)
WANTED = [Condition(participants=6, effect=effect) for effect in (0.3, 1.0)]


def grid(studies=STUDIES_A_SHARD + 60, seed=1):
    return shards(DESIGN, WANTED, studies=studies, seed=seed)


@pytest.fixture(scope="module")
def alone():
    return run_grid(grid())


def test_every_study_that_was_asked_for_is_simulated_once(alone):
    assert [outcome.studies for outcome in alone.values()] == [STUDIES_A_SHARD + 60] * 2
    assert len({shard.digest for shard in grid()}) == 4


def test_two_processes_find_the_same_digits(alone, tmp_path):
    assert run_grid(grid(), jobs=2, cache=ShardCache(tmp_path)) == alone
    assert missing(grid(), ShardCache(tmp_path)) == []


def test_an_array_job_finds_the_same_digits_and_the_last_part_has_them_all(alone, tmp_path):
    first = run_grid(grid(), cache=ShardCache(tmp_path), part=Part(number=1, of=2))
    assert first != alone
    assert len(missing(grid(), ShardCache(tmp_path))) == 2
    assert run_grid(grid(), cache=ShardCache(tmp_path), part=Part(number=2, of=2)) == alone


def test_what_is_there_is_not_computed_again(alone, tmp_path, monkeypatch):
    run_grid(grid(), cache=ShardCache(tmp_path))

    def compute(_shard):
        raise AssertionError

    monkeypatch.setattr(Shard, "compute", compute)
    assert run_grid(grid(), cache=ShardCache(tmp_path)) == alone


def damage_cut(path, _other):
    path.write_text(path.read_text()[:-20])


def damage_empty(path, _other):
    path.write_text("")


def damage_number(path, _other):
    path.write_text(path.read_text().replace('"friedman": ', '"friedman": 1', 1))


def damage_foreign(path, other):
    path.write_text(other.read_text())


def damage_not_text(path, _other):
    path.write_bytes(b"\xff\xfe")


@pytest.mark.parametrize(
    "damage", [damage_cut, damage_empty, damage_number, damage_foreign, damage_not_text]
)
def test_a_shard_that_is_not_whole_or_not_its_own_is_computed_again(alone, tmp_path, damage):
    cache = ShardCache(tmp_path)
    run_grid(grid(), cache=cache)
    one, other = (cache.path(shard) for shard in grid()[:2])
    whole = one.read_text()
    damage(one, other)
    assert [shard.digest for shard in missing(grid(), cache)] == [grid()[0].digest]
    assert run_grid(grid(), cache=cache) == alone
    assert one.read_text() == whole


def test_a_run_that_is_interrupted_loses_the_shard_in_hand_alone(alone, tmp_path, monkeypatch):
    compute, left = Shard.compute, iter(range(2))

    def limited(shard):
        if next(left, None) is None:
            raise KeyboardInterrupt
        return compute(shard)

    monkeypatch.setattr(Shard, "compute", limited)
    with pytest.raises(KeyboardInterrupt):
        run_grid(grid(), cache=ShardCache(tmp_path))
    monkeypatch.setattr(Shard, "compute", compute)
    assert len(missing(grid(), ShardCache(tmp_path))) == 2
    assert run_grid(grid(), cache=ShardCache(tmp_path)) == alone


def test_a_cache_of_another_version_is_refused_and_left_alone(tmp_path, capsys):
    (tmp_path / MARK).write_text(json.dumps({"version": 0}))
    words = ["power", "--participants", "6", "--studies", "5", "--cache", str(tmp_path)]
    assert commands.main(words) == 2
    assert "from another version of Slipscale" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == [MARK]


def test_a_full_disk_is_said_in_a_sentence_and_leaves_no_part(tmp_path, monkeypatch):
    cache = ShardCache(tmp_path)

    def full(path, text, **_):
        path.write_bytes(text.encode()[:10])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(UserError, match="free some space and run the same command again"):
        run_grid(grid(studies=10), cache=cache)
    assert [path.name for path in tmp_path.iterdir()] == [MARK]


def test_a_cache_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="--cache"):
        ShardCache(tmp_path / "file")


def test_another_seed_condition_or_number_has_other_digits():
    first = grid()[0].compute()
    assert first == grid()[0].compute()
    for other in (grid(seed=2)[0], grid()[1], grid()[2]):
        assert other.compute().widths != first.widths


def test_the_estimate_of_time_grows_with_the_grid(monkeypatch):
    timed = "slipscale.analysis.planning.power.run_grid._timed"
    monkeypatch.setattr(timed, lambda _shard, studies: studies / 1000)
    few, many = grid(studies=250), grid(studies=250_000)
    assert estimated_s([], 1) == 0
    assert estimated_s(many, 1) == pytest.approx(1000 * estimated_s(few, 1))
    assert estimated_s(many, 4) == pytest.approx(estimated_s(many, 1) / 4)


# A cluster of real worker processes -----------------------------------------------------------


@pytest.fixture
def cluster():
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        yield cluster


def test_a_part_of_a_grid_tells_its_own_total_and_reaches_it():
    told = []
    run_grid(grid(), part=Part(number=2, of=3), progress=lambda *counts: told.append(counts))
    totals = {of for _, of in told}
    assert len(totals) == 1  # it grew with every shard that was done
    assert told[-1] == (*totals, *totals)


# Dask's own sockets are closed by the system when a worker is killed.
@pytest.mark.filterwarnings("ignore")
def test_a_cluster_that_loses_a_worker_finds_the_same_digits(alone, cluster, tmp_path, monkeypatch):
    monkeypatch.setattr("slipscale.analysis.planning.power.run_grid.REACHED_S", 300)
    pids = [worker.pid for worker in cluster.workers.values()]
    killed = []

    def kill(done, of):
        if not killed and of > 0:
            os.kill(pids[0], signal.SIGKILL)
            killed.append(done)

    found = run_grid(
        grid(),
        scheduler=cluster.scheduler_address,
        cache=ShardCache(tmp_path),
        progress=kill,
    )
    assert killed
    assert found == alone
    assert missing(grid(), ShardCache(tmp_path)) == []


def test_a_scheduler_that_is_not_there_is_said_in_a_sentence(capsys, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("slipscale.analysis.planning.power.run_grid.REACHED_S", 0.3)
    words = ["power", "--participants", "6", "--studies", "5", "--scheduler", "tcp://127.0.0.1:9"]
    assert commands.main(words) == 2
    said = capsys.readouterr().err
    assert "--scheduler tcp://127.0.0.1:9: the scheduler cannot be reached" in said
    assert said.count("\n") == 1


# Looks before the end -------------------------------------------------------------------------


def test_the_looks_levels_are_the_published_ones():
    """Five looks, two-sided alpha 0.05: the boundaries of Reboussin et al. (2000), z."""
    sizes = (10, 20, 30, 40, 50)
    for spending, published in (
        ("obrien-fleming", (4.877, 3.357, 2.680, 2.290, 2.031)),
        ("pocock", (2.438, 2.427, 2.410, 2.397, 2.386)),
    ):
        z = [-ndtri(level / 2) for level in levels(sizes, 0.05, spending)]
        assert z == pytest.approx(published, abs=0.004)


def test_one_look_has_the_whole_level():
    assert levels((12,), 0.05, "pocock") == pytest.approx((0.05,))


def test_a_look_at_fewer_than_three_people_is_refused():
    with pytest.raises(
        UserError, match="the first interim analysis would take place after 2 of 8 participants"
    ):
        look_sizes(8, 4)
