"""The same work for many inputs: over this machine's cores, or over a Dask cluster."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, as_completed
from typing import TypeVar

from shoecal_core.errors import ShoecalError

Job = TypeVar("Job")
Result = TypeVar("Result")
CONNECT_S = 10.0
"""How long a scheduler may take to answer."""
NO_DASK = (
    f"--scheduler needs Dask, which is not installed: {sys.executable} -m pip install "
    "distributed, and the same on the workers"
)


def over_cores(
    work: Callable[[Job], Result], jobs: Sequence[Job], cores: int | None = None
) -> Iterator[tuple[int, Result]]:
    """Results as they come, each with the number of its job.

    Args:
        work: a function of a module: each process imports it again.
        jobs: can be pickled.
        cores: processes at a time; by default as many as this machine has.
    """
    count = min(len(jobs), cores or os.cpu_count() or 1)
    # Threads of solvers do not survive a fork.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(count, mp_context=context) as pool:
        waiting: dict[Future[Result], int] = {
            pool.submit(work, job): number for number, job in enumerate(jobs)
        }
        for future in as_completed(waiting):
            try:
                result = future.result()
            except BrokenExecutor as error:
                raise ShoecalError(
                    "a process ended before its work: out of memory? Allow fewer at a time (--jobs)"
                ) from error
            yield waiting[future], result


def over_cluster(
    work: Callable[[Job], Result], jobs: Sequence[Job], scheduler: str
) -> Iterator[tuple[int, Result]]:
    """The same over the workers of a Dask scheduler, which see the same files.

    Args:
        scheduler: address, for example tcp://10.0.0.5:8786.

    Raises:
        ShoecalError: without Dask, or when no scheduler answers there.
    """
    try:
        distributed = importlib.import_module("distributed")
    except ImportError as error:
        raise ShoecalError(NO_DASK) from error
    try:
        client = distributed.Client(scheduler, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ShoecalError(
            f"no Dask scheduler answers at '{scheduler}': start one with `dask scheduler`, and "
            "workers with `dask worker`, or name another address"
        ) from error
    with client, client.as_current():
        waiting = {client.submit(work, job, pure=False): number for number, job in enumerate(jobs)}
        for future in distributed.as_completed(waiting):
            yield waiting[future], future.result()
