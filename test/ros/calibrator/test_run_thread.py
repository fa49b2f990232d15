from __future__ import annotations

import pytest

from shoecal_core.errors import ShoecalError
from shoecal_core.recording.writer import RunWriter
from shoecal_ros.calibrator.run_thread import RunThread


@pytest.mark.parametrize(
    ("error", "reported"),
    [
        (MemoryError(), "MemoryError"),
        (ZeroDivisionError("odd"), "ZeroDivisionError: odd"),
        (ShoecalError("no room; make some"), "no room; make some"),
    ],
)
def test_a_run_that_cannot_be_made_is_never_taken_for_a_whole_one(
    error: Exception, reported: str
) -> None:
    def make() -> RunWriter:
        raise error

    run = RunThread(make)
    run.end(whole=True)
    run.wait()
    assert run.problem == reported
