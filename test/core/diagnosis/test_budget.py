"""What the CoP's gap is made of."""

from __future__ import annotations

import numpy as np
import pytest

from core.diagnosis.drawn import Urn, part
from shoecal_core.diagnosis.budget import budget

LABEL, SIZE = "floor_tilt", [0.03, 0.02]


def test_shares_are_those_of_what_was_drawn(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(1), {LABEL: SIZE})
    found = drawn.scorer.score([part(drawn, LABEL)])
    workspace = drawn.at(found)
    rest = workspace.explained(None)[0]
    told = budget(workspace, rest, found)
    assert sum(one.cop_share for one in told) == pytest.approx(1.0)
    assert (told[0].source, told[0].location) == ("floor_tilt", ())
    assert told[0].cop_share > 0.7
    low, high = told[0].ci95
    assert low < told[0].cop_share < high
    assert [one.source for one in told[-2:]] == ["other errors as built", "not explained"]


def test_without_a_cause_there_are_errors_as_built_and_what_nothing_explains(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(2))
    told = budget(drawn, drawn.explained(None)[0], None)
    assert sum(one.cop_share for one in told) == pytest.approx(1.0)
    assert told[-1].source == "not explained"
    nothing = np.zeros_like(drawn.signal_model.residuals)
    assert budget(drawn, nothing, None) == ()
