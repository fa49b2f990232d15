from __future__ import annotations

from reliability.peers import NAMES, WITHIN_S, Try, judged, tried


def test_who_does_not_fit_is_named() -> None:
    found = tried(0, len(NAMES), 0, lambda _: None)
    assert [one.what for one in found] == list(NAMES)


def test_one_that_is_told_late_has_failed() -> None:
    found = judged([Try("in time", WITHIN_S), Try("late", WITHIN_S + 0.1), Try("soon", 0.2)])
    assert (found.tried, found.failed, found.worst) == (3, 1, "5.1 s until told (late)")
