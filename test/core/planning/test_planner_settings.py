from __future__ import annotations

from core.planning.bodies import ROOT
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.settings import describe, load_settings

FILE = ROOT / "config/nodes/planner.yaml"


def test_the_file_holds_every_setting_at_its_default() -> None:
    assert load_settings(PlannerSettings, FILE, "planner") == PlannerSettings()
    text = FILE.read_text()
    for entry in describe(PlannerSettings):
        line = next(line for line in text.splitlines() if line.startswith(f"    {entry.name}: "))
        assert entry.doc in line
        assert not entry.unit or f"[{entry.unit}]" in line
