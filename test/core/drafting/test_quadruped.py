"""Robots that are no humanoids on two legs."""

from __future__ import annotations

from pathlib import Path

import pytest

from shoecal_core.drafting.body import read_body
from shoecal_core.drafting.legs import find_legs
from shoecal_core.errors import FileError

LINK = """<link name="{name}"><inertial><mass value="1"/><origin xyz="0 0 -0.1"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>"""
JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="{xyz}"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="9" velocity="9"/></joint>"""


def robot(folder: Path, roots: dict[str, str], joints: int) -> Path:
    """A trunk with straight limbs of some joints each."""
    parts = [LINK.format(name="trunk")]
    for limb, place in roots.items():
        parent = "trunk"
        for number in range(joints):
            child = f"{limb}_{number}"
            parts.append(LINK.format(name=child))
            xyz = place if number == 0 else "0 0 -0.2"
            parts.append(JOINT.format(name=f"{child}_j", parent=parent, child=child, xyz=xyz))
            parent = child
    file = folder / "robot.urdf"
    file.write_text(f'<robot name="limbs">{"".join(parts)}</robot>')
    return file


def refused(file: Path) -> str:
    with pytest.raises(FileError) as error:
        find_legs(read_body(file))
    return error.value.problem


def test_four_legs(tmp_path: Path) -> None:
    roots = {f"{end}_{side}": f"{x} {y} 0" for end, x in (("fore", 0.3), ("hind", -0.3))
             for side, y in (("l", 0.1), ("r", -0.1))}  # fmt: skip
    assert "has more than two feet" in refused(robot(tmp_path, roots, 4))


def test_an_arm(tmp_path: Path) -> None:
    assert "no two chains of joints" in refused(robot(tmp_path, {"only": "0 0 0"}, 6))


def test_arms_alone(tmp_path: Path) -> None:
    roots = {"arm_l": "0 0.2 0", "arm_r": "0 -0.2 0"}
    assert "are arms" in refused(robot(tmp_path, roots, 6))


def test_too_few_motors(tmp_path: Path) -> None:
    roots = {"leg_l": "0 0.1 0", "leg_r": "0 -0.1 0"}
    assert "its legs have 6 motors" in refused(robot(tmp_path, roots, 3))


def test_legs_of_unlike_length(tmp_path: Path) -> None:
    file = robot(tmp_path, {"leg_l": "0 0.1 0", "leg_r": "0 -0.1 0.3"}, 4)
    assert "no two chains of joints" in refused(file)
