"""Tests run in as many processes as processors and memory allow."""

import pytest

from tests.support.workers import memory_bytes, workers


@pytest.mark.parametrize(
    "processors, gigabytes, expected",
    [(2, 2, 1), (2, 24, 2), (16, 8, 4), (1, 64, 1), (4, 0.5, 1), (4, float("inf"), 4)],
)
def test_each_worker_has_a_processor_and_its_memory(processors, gigabytes, expected):
    assert workers(processors, gigabytes * 1e9) == expected


@pytest.mark.parametrize(
    "group, file",
    [
        ("0::/own\n", "own/memory.max"),
        ("9:cpu:/own\n4:memory:/own\n", "memory/own/memory.limit_in_bytes"),
    ],
    ids=["version 2", "version 1"],
)
def test_the_limit_of_a_control_group_is_the_memory(tmp_path, group, file):
    (tmp_path / "proc/self").mkdir(parents=True)
    (tmp_path / "proc/self/cgroup").write_text(group)
    limit = tmp_path / "sys/fs/cgroup" / file
    limit.parent.mkdir(parents=True)
    limit.write_text("2000000\n")
    assert memory_bytes(tmp_path) == 2_000_000
    limit.write_text("max\n")
    assert memory_bytes(tmp_path) > 2_000_000
