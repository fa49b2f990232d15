from __future__ import annotations

from reliability.flood import flood


def test_one_job_an_answer_to_every_call_and_cop_goes_on() -> None:
    found = flood(2000)
    assert found.jobs == 1
    assert found.changes.sum() > 1, "calibrations are changed meanwhile"
    assert found.unanswered == 0
    assert found.cop_share > 0.5, "starved by the calls, not only slowed by a busy machine"
