"""Which runs of a session are fitted, and which are kept for the test."""

from __future__ import annotations

from collections.abc import Sequence

from shoecal_core.errors import ShoecalError
from shoecal_core.recording.errors import SessionError
from shoecal_core.recording.session import Session, missing_text


def split_runs(
    session: Session, train: Sequence[int], test: Sequence[int]
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Which runs to fit and which to keep for the test.

    Runs given count; else the session's own marks; else every run trains.

    Raises:
        ShoecalError: no run at all, a run that is not there, or one in both sets.
    """
    entries = session.runs
    if not entries:
        raise SessionError(session.folder, _without_runs(session))
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


def _without_runs(session: Session) -> str:
    """Why a session has none, and what to do."""
    if session.missing:
        return f"has no run: {missing_text(session.missing)}"
    if session.unfinished:
        return f"has no finished run: rescue it with `shoecal recover {session.unfinished[0]}`"
    return "has no run yet: record some"
