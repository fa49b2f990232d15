"""Which runs of a session are fitted, and which are kept for the test."""

from __future__ import annotations

from collections.abc import Sequence

from shoecal_core.errors import ShoecalError
from shoecal_core.recording.errors import SessionError
from shoecal_core.recording.session import Session


def split_runs(
    session: Session, train: Sequence[int], test: Sequence[int]
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Which runs to fit and which to keep for the test.

    Runs given count; else the session's own marks; else every run trains.

    Raises:
        ShoecalError: a run that is not there, or one in both sets.
    """
    entries = session.runs
    if not train and not test:
        train = [entry.run for entry in entries if entry.hint == "train"]
        test = [entry.run for entry in entries if entry.hint == "test"]
    known = [entry.run for entry in entries]
    if not train:
        train = [run for run in known if run not in test]
    for run in (*train, *test):
        if run not in known:
            listed = ", ".join(map(str, known)) or "none"
            raise SessionError(session.folder, f"has no run {run} (it has: {listed})")
    both = sorted(set(train) & set(test))
    if both:
        raise ShoecalError(
            f"run(s) {both} are in both --train and --test; a test run is not fitted"
        )
    return tuple(train), tuple(test)
