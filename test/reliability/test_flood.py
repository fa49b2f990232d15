from __future__ import annotations

import numpy as np

from reliability.flood import flood

NEARLY_ALL = 0.99
AS_LONG = 20.0
"""So many times as long as a service that does nothing an answer may take; it takes 3 to 6 times
as long, also where eight other programs share two cores."""
GIVEN = 0.8
"""Of the frames that get their CoP: where those eight hold the calibrator up, 5 % go by unread."""


def test_one_job_an_answer_to_every_call_and_cop_goes_on() -> None:
    found = flood(2000)
    assert found.jobs == 1
    assert found.changes.sum() > 1, "calibrations are changed meanwhile"
    assert found.unanswered == 0
    took = np.quantile(found.took[~found.changes], NEARLY_ALL)
    nothing = np.quantile(found.bare[found.bare > 0.0], NEARLY_ALL)
    assert took < AS_LONG * nothing, found.told
    # Not as many a second as before: a busy machine lets the robot tell fewer, too.
    assert found.given > GIVEN, found.told
