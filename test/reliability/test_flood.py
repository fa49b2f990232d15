from __future__ import annotations

from dataclasses import replace

import numpy as np

from reliability.flood import Flood, flood

NEARLY_ALL = 0.99
AS_LONG = 20.0
"""So many times as long as a service that does nothing an answer may take; it takes 3 to 6 times
as long, also where eight other programs share two cores."""
COPS = 0.8
"""Of those before: where those eight hold the calibrator up, 5 % of the frames go by unread."""


def test_one_job_an_answer_to_every_call_and_cop_goes_on() -> None:
    found = flood(2000)
    assert found.jobs == 1
    assert found.changes.sum() > 1, "calibrations are changed meanwhile"
    assert found.took.min() > 0.0, "every call is answered"
    took = np.quantile(found.took[~found.changes], NEARLY_ALL)
    nothing = np.quantile(found.bare[found.bare > 0.0], NEARLY_ALL)
    assert took < AS_LONG * nothing, found.worst
    assert found.cop_share > COPS, found.worst


def test_late_calls_fail_unless_the_machine_is_busy() -> None:
    took, bare = np.full(2000, 0.01), np.full(2000, -1.0)
    changes = np.arange(2000) == 7
    good = Flood(took, bare, changes, 1, 1.0)
    assert good.failed == 0
    took[[7, 500, 1500]] = 0.2  # 7 is a change
    took[900] = -1.0
    bare[1400] = 0.06
    assert good.failed == 2
    for wrong in (replace(good, jobs=2), replace(good, cop_share=0.9)):
        assert wrong.failed == 2000
    assert replace(good, changes=changes & False).failed == 2000
