"""Tries of a fault, one after another, each drawn from (seed, number) alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from reliability.row import Progress, Result

Attempt = Callable[[int, np.random.Generator], float | None]
"""Does the try of a number. Returns its figure if it has one, larger is worse; any exception is a
failure."""


class BrokenError(Exception):
    """What must hold does not."""


def run_tries(
    attempt: Attempt, first: int, count: int, seed: int, progress: Progress, worst: str = ""
) -> Result:
    """Do the tries `first` to `first + count - 1`.

    Args:
        attempt: one of them.
        first: number of the first one.
        count: how many.
        seed: of all draws.
        progress: is told after each try how many are done.
        worst: the largest figure in words, for example "{:.2f} s until back"; the first failure
            takes its place.
    """
    figure, failures = 0.0, []
    for number in range(first, first + count):
        try:
            figure = max(figure, attempt(number, np.random.default_rng([seed, number])) or 0.0)
        except BrokenError as error:
            failures.append(f"try {number}: {error}")
        except Exception as error:  # noqa: BLE001 - whatever is raised is a failure of the try
            failures.append(f"try {number}: {error!r}")
        progress(number - first + 1)
    return Result(count, len(failures), failures[0] if failures else worst.format(figure), figure)
