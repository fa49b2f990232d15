"""What every launch file does before it starts anything."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

LAUNCH = Path(__file__).parents[2] / "shoecal_ros/launch"
FILES = sorted(LAUNCH.glob("*.py"))


def called(node: ast.AST, name: str) -> bool:
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == name


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_discovery_stays_on_this_computer(file: Path) -> None:
    tree = ast.parse(file.read_text())
    (description,) = (node for node in ast.walk(tree) if called(node, "LaunchDescription"))
    assert isinstance(description, ast.Call)
    (actions,) = description.args
    assert isinstance(actions, ast.List)
    reported = ast.unparse(actions.elts[0])
    assert reported == "*(SetEnvironmentVariable(*each) for each in network_environment().items())"


def test_the_simulated_robots_driver_reads_the_cells_of_its_shoe_file() -> None:
    tree = ast.parse((LAUNCH / "demo.launch.py").read_text())
    handed_on = {
        ast.unparse(key): ast.unparse(value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Dict)
        for key, value in zip(node.keys, node.values, strict=True)
        if key is not None
    }
    assert handed_on["'device'"] == "simulated_device(arguments)"


def test_there_are_launch_files() -> None:
    names = ["bringup.launch.py", "demo.launch.py", "view.launch.py"]
    assert [file.name for file in FILES] == names
