"""The worst of a constraint is found whatever is beside it: zeros, and what is no number."""

from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.planning.checking.findings import Report, at_least, at_most, worst

TIME = np.arange(3.0)
NAMES = ("knee", "finger")


def test_a_joint_without_a_limit_hides_no_other() -> None:
    """0 / 0 is no number, and larger than nothing."""
    speed = np.array([[1.0, 0.0], [30.0, 0.0], [1.0, 0.0]])
    finding = at_most("joint speed", "rad/s", speed, np.array([1.0, 0.0]), TIME, NAMES)
    assert (finding.where, finding.value, finding.time) == ("knee", 30.0, 1.0)
    assert not finding.kept
    kept = at_most("joint speed", "rad/s", 0.01 * speed, np.array([1.0, 0.0]), TIME, NAMES)
    assert kept.kept


def test_a_joint_without_a_limit_must_not_move() -> None:
    speed = np.array([[0.5, 0.0], [0.5, 0.1], [0.5, 0.0]])
    finding = at_most("joint speed", "rad/s", speed, np.array([1.0, 0.0]), TIME, NAMES)
    assert (finding.where, finding.kept) == ("finger", False)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_what_is_no_number_fails(wrong: float) -> None:
    values = np.array([[0.5], [wrong], [0.5]])
    high = at_most("speed", "m/s", values, 1.0, TIME)
    low = at_least("gap", "m", values if np.isnan(wrong) else -values, 0.1, TIME)
    assert not high.kept
    assert not low.kept
    fine = at_most("speed", "m/s", np.full((3, 1), 0.5), 1.0, TIME)
    for findings in ((fine, high), (high, fine)):
        assert not Report(worst(findings)).kept
