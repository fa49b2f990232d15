from __future__ import annotations

from reliability.flood import flood


def test_one_job_and_an_answer_to_every_call() -> None:
    found = flood(2000)
    assert found.jobs == 1
    assert found.unanswered == 0
