from __future__ import annotations

from dataclasses import replace

import numpy as np

from reliability.flood import Flood, flood

COPS = 0.8
"""Of those before: where other programs hold the calibrator up, 5 % of the frames go by unread."""


def test_one_job_an_answer_to_every_call_and_cop_goes_on() -> None:
    found = flood(2000)
    assert found.jobs == 1
    assert found.changes.sum() > 1, "calibrations are changed meanwhile"
    assert found.took.min() > 0.0, "every call is answered"
    assert found.cop_share > COPS, found.worst


def test_late_and_unanswered_calls_fail() -> None:
    took = np.full(2000, 0.01)
    took[7], took[500], took[900] = 0.2, 0.2, -1.0
    found = Flood(took, np.arange(2000) == 7, 1, 1.0)
    assert found.failed == 2, "7 is a change"
    for wrong in (
        replace(found, jobs=2),
        replace(found, cop_share=0.9),
        replace(found, changes=took > 1.0),
    ):
        assert wrong.failed == 2000
