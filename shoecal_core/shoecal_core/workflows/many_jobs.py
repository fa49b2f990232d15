"""The same work for many inputs: over this machine's cores, or over a Dask cluster."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import sys
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Future,
    ProcessPoolExecutor,
    wait,
)
from typing import TypeVar

from shoecal_core.errors import ShoecalError

Job = TypeVar("Job")
Result = TypeVar("Result")
CONNECT_S = 10.0
"""How long a scheduler may take to answer."""
ENDED = (
    "a process ended before its work: out of memory? Allow fewer at a time (--jobs, or a worker's "
    "threads)"
)
NO_DASK = (
    f"--scheduler needs Dask, which is not installed: {sys.executable} -m pip install "
    "distributed, and the same on the workers"
)


def over_cores(
    work: Callable[[Job], Result],
    jobs: Sequence[Job],
    cores: int | None = None,
    *,
    lost: Callable[[Job], Result] | None = None,
) -> Iterator[tuple[int, Result]]:
    """Results as they come, each with the number of its job.

    Args:
        work: a function of a module: each process imports it again.
        jobs: can be pickled.
        cores: processes at a time; by default as many as this machine has.
        lost: the result of a job whose process ended before it; None: that is an error.

    Raises:
        ShoecalError: when a process ended before its work, without `lost`.
    """
    waiting = deque(range(len(jobs)))
    running: dict[Future[Result], tuple[int, ProcessPoolExecutor]] = {}

    def start(pool: ProcessPoolExecutor) -> None:
        number = waiting.popleft()
        running[pool.submit(work, jobs[number])] = number, pool

    try:
        # A process that ends takes its whole pool with it, so each has a pool of its own.
        for _ in range(min(len(jobs), cores or os.cpu_count() or 1)):
            start(_process())
        while running:
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                number, pool = running.pop(future)
                try:
                    result = future.result()
                except BrokenExecutor as error:
                    if lost is None:
                        raise ShoecalError(ENDED) from error
                    result = lost(jobs[number])
                    pool.shutdown(wait=False)
                    pool = _process()
                if waiting:
                    start(pool)
                else:
                    pool.shutdown(wait=False)
                yield number, result
    finally:
        for _, pool in running.values():
            pool.shutdown(wait=False, cancel_futures=True)


def _process() -> ProcessPoolExecutor:
    # Threads of solvers do not survive a fork.
    return ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn"))


def over_cluster(
    work: Callable[[Job], Result],
    jobs: Sequence[Job],
    scheduler: str,
    *,
    lost: Callable[[Job], Result],
) -> Iterator[tuple[int, Result]]:
    """The same over the workers of a Dask scheduler, which see the same files.

    Args:
        work, jobs: as of `over_cores`; paths in them are absolute.
        scheduler: address, for example tcp://10.0.0.5:8786.
        lost: the result of a job whose workers ended before it.

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
            number = waiting[future]
            try:
                result = future.result()
            except (distributed.KilledWorker, CancelledError):
                result = lost(jobs[number])
            yield number, result
