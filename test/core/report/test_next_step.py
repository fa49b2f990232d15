"""What to do with a result."""

from __future__ import annotations

import pytest

from shoecal_core.report.next_step import (
    after_calibration,
    after_cells,
    after_check,
    after_history,
)


@pytest.mark.parametrize("by_robot", [True, False])
def test_a_calibration_comes_into_force_by_what_its_verdict_allows(by_robot: bool) -> None:
    passed, warned = (after_calibration(one, "c.yaml", by_robot=by_robot)
                      for one in ("PASS", "WARN"))  # fmt: skip
    assert "/shoe/set_calibration with c.yaml." in passed
    assert "/shoe/set_calibration with c.yaml and force." in warned
    assert ("/shoe/apply" in warned) is by_robot
    assert "/shoe/apply" not in passed


def test_nothing_follows_what_must_not_be_used() -> None:
    assert not after_calibration("FAIL")
    assert not after_cells("FAIL")
    assert not after_check("FAIL", "session")


def test_commands_name_their_files() -> None:
    assert "calibrate out/session " in after_check("PASS", "out/session")
    assert "--cells cells.yaml" in after_cells("WARN", "cells.yaml")
    assert after_history(True) != after_history(False)
