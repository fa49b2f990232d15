"""Work over several processes; none but this one for a single job at a time."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")


def over(work: Callable[[Job], Result], jobs: Sequence[Job], processes: int) -> Iterator[Result]:
    """Results in the jobs' order, as they come.

    Processes begin anew: those that are forked inherit threads' locks and cannot be trusted.
    """
    if processes == 1:
        yield from map(work, jobs)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        processes, mp_context=context, initializer=os.nice, initargs=(10,)
    ) as pool:
        yield from pool.map(work, jobs)
