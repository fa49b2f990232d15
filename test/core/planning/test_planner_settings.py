from __future__ import annotations

import pytest

from core.planning.bodies import ROOT
from shoecal_core.parameter_file import load_settings
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.settings import SettingError, describe

FILE = ROOT / "config/nodes/planner.yaml"


def test_the_file_holds_every_setting_at_its_default() -> None:
    assert load_settings(PlannerSettings, FILE, "planner", "planning") == PlannerSettings()
    text = FILE.read_text()
    for entry in describe(PlannerSettings):
        line = next(line for line in text.splitlines() if line.startswith(f"      {entry.name}: "))
        assert entry.doc in line
        assert not entry.unit or f"[{entry.unit}]" in line


def test_a_horizon_of_one_state_is_none() -> None:
    with pytest.raises(SettingError, match="horizon: must be at least 2"):
        PlannerSettings(horizon=1)
    with pytest.raises(SettingError, match="solver: 'magic' is not one of: sqp, ipopt"):
        PlannerSettings(solver="magic")
