from __future__ import annotations

from ros.bodies import ROOT
from shoecal_core.files import read_yaml
from shoecal_core.settings import describe
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.planner.settings import MovingSettings


def test_the_file_holds_every_parameter_of_the_node_at_its_default() -> None:
    path = ROOT / "config/nodes/planner.yaml"
    block = read_yaml(path).mapping("/**/planner").mapping("ros__parameters")
    entries = [*describe(RobotFiles), *describe(MovingSettings)]
    assert sorted(block.keys()) == sorted(["planning", *(entry.name for entry in entries)])
    lines = path.read_text().splitlines()
    for entry in entries:
        assert entry.checked(block.value(entry.name)) == entry.default
        line = next(line for line in lines if line.startswith(f"    {entry.name}: "))
        assert entry.doc in line
        assert not entry.unit or f"[{entry.unit}]" in line
