"""Compute the shards of a grid on this computer, on a cluster, or in parts as an array job.

The results are identical, because each shard has its own seed and shards are always summed in the
same order.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from slipscale.analysis.planning.power.design import Design
from slipscale.analysis.planning.power.grid import Condition
from slipscale.analysis.planning.power.outcome import Outcome, total
from slipscale.analysis.planning.power.shard import STUDIES_A_SHARD, Looks, Shard
from slipscale.analysis.planning.power.shard_cache import ShardCache
from slipscale.faults import UserError

HOUR_S = 3600.0
#: Sizes of two small simulations, in studies, that are timed to estimate the run time.
TRIED = (5, 45)


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """Selection of the shards to compute; by default, all shards.

    The shards are divided into ``of`` parts. Part ``number``, counted from 1, is selected.
    """

    number: int = 1
    of: int = 1

    def takes(self, place: int) -> bool:
        """Return whether the shard with the given index belongs to this part of the grid."""
        return place % self.of == self.number - 1


def shards(
    design: Design,
    wanted: Sequence[Condition],
    *,
    studies: int,
    seed: int,
    looks: Looks | None = None,
) -> list[Shard]:
    """Split each condition's studies into shards, in the order of `wanted`."""
    sizes = [STUDIES_A_SHARD] * (studies // STUDIES_A_SHARD)
    if rest := studies % STUDIES_A_SHARD:
        sizes.append(rest)
    return [
        Shard(
            design=design,
            condition=condition,
            number=number,
            studies=size,
            seed=seed,
            looks=looks or Looks(),
        )
        for condition in wanted
        for number, size in enumerate(sizes)
    ]


def missing(wanted: Sequence[Shard], cache: ShardCache | None) -> list[Shard]:
    """Return the shards that are not in the cache."""
    return [shard for shard in wanted if cache is None or cache.get(shard) is None]


def estimated_s(wanted: Sequence[Shard], jobs: int) -> float:
    """Estimate the run time from a few studies of the shard with the most ratings."""
    if not wanted:
        return 0.0
    largest = max(wanted, key=_ratings)
    few, many = (min(number, largest.studies) for number in TRIED)
    _timed(largest, few)  # Exclude the time for imports and tables.
    small_s, large_s = _timed(largest, few), _timed(largest, many)
    study_s = max(large_s - small_s, 0.0) / max(many - few, 1)
    shard_s = max(small_s - few * study_s, 0.0)
    of_largest = study_s / _ratings(largest) * largest.studies
    return (len(wanted) * shard_s + of_largest * sum(map(_ratings, wanted))) / jobs


def _timed(shard: Shard, studies: int) -> float:
    """Return the time in seconds that a shard takes to simulate a number of studies."""
    began = time.perf_counter()
    replace(shard, studies=studies, number=-1).compute()
    return time.perf_counter() - began


def _ratings(shard: Shard) -> int:
    condition = shard.condition
    return shard.studies * condition.participants * condition.repetitions


def run_grid(
    wanted: Sequence[Shard],
    *,
    jobs: int = 1,
    cache: ShardCache | None = None,
    part: Part | None = None,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[Condition, Outcome]:
    """Simulate shards (batches of studies), and add up the results of each condition.

    Parameters
    ----------
    wanted : sequence of Shard
        Shards of one design.
    jobs : int
        Number of processes.
    cache : ShardCache, optional
        Cache from which finished shards are read. New shards are stored as soon as they are
        finished.
    part : Part, optional
        Selects which of the missing shards to compute in this run.
    scheduler : str, optional
        Address of a Dask scheduler to use instead of local processes.
    progress : callable, optional
        Function that is called with the number of finished shards and the total.

    Returns
    -------
    dict
        Outcome of each condition for which all shards are available.
    """
    here = part or Part()
    found: dict[Shard, Outcome] = {}
    left: list[Shard] = []
    for place, shard in enumerate(wanted):
        known = cache.get(shard) if cache else None
        if known is not None:
            found[shard] = known
        elif here.takes(place):
            left.append(shard)
    tell = progress or (lambda _done, _of: None)
    all_shards = len(found) + len(left)
    tell(len(found), all_shards)
    for shard, outcome in _computed(left, jobs, scheduler, cache):
        found[shard] = outcome
        tell(len(found), all_shards)
    return _sums(wanted, found)


def _sums(wanted: Iterable[Shard], found: Mapping[Shard, Outcome]) -> dict[Condition, Outcome]:
    """Return the outcome of each condition for which all shards are available."""
    of: dict[Condition, list[Shard]] = {}
    for shard in wanted:
        of.setdefault(shard.condition, []).append(shard)
    return {
        condition: total(found[shard] for shard in own)
        for condition, own in of.items()
        if all(shard in found for shard in own)
    }


def _computed(
    left: Sequence[Shard], jobs: int, scheduler: str | None, cache: ShardCache | None
) -> Iterator[tuple[Shard, Outcome]]:
    """Yield each shard with its outcome, in order of completion."""
    if scheduler is not None:
        for shard, outcome in _on_cluster(left, scheduler):
            if cache:  # Workers may not have access to this disk.
                cache.put(shard, outcome)
            yield shard, outcome
    elif jobs == 1 or len(left) < 2:  # noqa: PLR2004
        for shard in left:
            yield _kept(shard, cache)
    else:
        from joblib import Parallel, delayed

        work = Parallel(n_jobs=jobs, return_as="generator_unordered")
        yield from work(delayed(_kept)(shard, cache) for shard in left)


def _kept(shard: Shard, cache: ShardCache | None = None) -> tuple[Shard, Outcome]:
    """Compute a shard and store it immediately, so that a killed process loses only one shard."""
    outcome = shard.compute()
    if cache:
        cache.put(shard, outcome)
    return shard, outcome


def _on_cluster(left: Sequence[Shard], scheduler: str) -> Iterator[tuple[Shard, Outcome]]:
    """Compute shards on a Dask cluster, which recomputes the shards of a lost worker."""
    try:
        from distributed import Client, as_completed
    except ModuleNotFoundError:
        raise UserError(
            "--scheduler {scheduler}: Dask is not installed; install the extra slipscale[cluster]",
            scheduler=scheduler,
        ) from None
    try:
        client = Client(scheduler, timeout=REACHED_S)  # type: ignore[no-untyped-call]
    except (OSError, ValueError, TypeError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise UserError(
            "--scheduler {scheduler}: the scheduler cannot be reached ({reason}); expected the "
            "address of a running Dask scheduler, such as tcp://HOST:8786",
            scheduler=scheduler,
            reason=reason,
        ) from None
    with client:
        futures = client.map(_kept, list(left), pure=False, retries=RETRIES)
        for future in as_completed(futures):  # type: ignore[no-untyped-call]
            yield future.result()


REACHED_S = 10
RETRIES = 5
