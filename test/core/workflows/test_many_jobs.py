"""The same work for many inputs: a process or a worker that ends costs its own job only."""

from __future__ import annotations

import pytest

from core.workflows.killed import DEADLY, nothing, square
from shoecal_core.errors import ShoecalError
from shoecal_core.workflows.many_jobs import over_cluster, over_cores


@pytest.mark.parametrize("cores", [1, 2, 9])
def test_a_process_that_is_killed_costs_its_job(cores: int) -> None:
    found = dict(over_cores(square, [0, 1, DEADLY, 3, 4], cores, lost=nothing))
    assert found == {0: 0, 1: 1, 2: -DEADLY, 3: 9, 4: 16}


def test_it_is_an_error_where_nothing_stands_for_the_job() -> None:
    with pytest.raises(ShoecalError, match="a process ended before its work"):
        dict(over_cores(square, [DEADLY]))


def test_no_jobs_at_all() -> None:
    assert list(over_cores(square, [])) == []


def test_a_worker_that_is_killed_costs_its_job() -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=None
    ) as cluster:
        found = dict(over_cluster(square, [1, DEADLY, 3], cluster.scheduler_address, lost=nothing))
    assert found == {0: 1, 1: -DEADLY, 2: 9}
