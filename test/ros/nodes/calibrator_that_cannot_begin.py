"""The calibrator node, whose first job fails as it begins, in a way nobody foresaw."""

from __future__ import annotations

from typing import Any

from shoecal_ros.calibrator.job import Job
from shoecal_ros.nodes.calibrator import main


def fail_once(begin: Any) -> Any:
    """Instead of `begin`, that fails at its first call."""

    async def fail(self: Job) -> None:
        Job.begin = begin  # type: ignore[method-assign]
        raise ZeroDivisionError("made up,\nof two lines")

    return fail


if __name__ == "__main__":
    Job.begin = fail_once(Job.begin)  # type: ignore[method-assign]
    main()
