"""`shoecal new robot`."""

from __future__ import annotations

import json
from pathlib import Path

import mujoco
import pytest
import shapely
import yaml

from core.cli.conftest import ROOT, Run
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe_file import load_shoe

URDF = ROOT / "config/robots/wren.urdf"


def test_a_draft_can_be_planned_with(tmp_path: Path, shoecal: Run) -> None:
    robot, shoe = tmp_path / "robots/little.yaml", tmp_path / "robots/little_shoe.yaml"
    code, told, _ = shoecal("new", "robot", URDF, "-o", robot, "--json", tmp_path / "told.json")
    assert code == 0
    assert "Check: weigh the robot" in told
    assert f"Then: shoecal plan {robot} --shoe {shoe}" in told
    figures = json.loads((tmp_path / "told.json").read_text())
    assert figures["legs"][0] == "left_hip_turn"
    assert {row["file"] for row in figures["check"]} == {str(robot), str(shoe)}
    # The shoe beside it is taken where none is named.
    code, told, error = shoecal("plan", robot, "--supports", 1, "--out", tmp_path / "plan")
    assert code == 0, error
    assert f"{robot} with {shoe}" in told
    assert "landmarks reached" in told
    session = tmp_path / "session"
    words = ["simulate", robot, shoe]
    words += ["--reality", figures["reality"], "--supports", 1, "--out", session]
    code, _, error = shoecal(*words)
    assert code == 0, error
    drawn = yaml.safe_load((session / "truth" / "reality.yaml").read_text())
    assert drawn["reality"] == "little"


def test_files_that_are_there_stay(tmp_path: Path, shoecal: Run) -> None:
    robot = tmp_path / "robot.yaml"
    robot.write_text("by hand")
    code, _, error = shoecal("new", "robot", URDF, "-o", robot)
    assert code == 1
    assert "robot.yaml: is there already; name another one, or replace it with --force" in error
    assert robot.read_text() == "by hand"
    assert shoecal("new", "robot", URDF, "-o", robot, "--force")[0] == 0
    assert robot.read_text().startswith("# Draft of robot")


def test_a_urdf_that_is_none(tmp_path: Path, shoecal: Run) -> None:
    nothing = tmp_path / "robot.urdf"
    for content, message in ((None, "robot.urdf: "), ("<xml/>", "robot.urdf: not a URDF")):
        if content is not None:
            nothing.write_text(content)
        code, told, error = shoecal("new", "robot", nothing, "-o", tmp_path / "robot.yaml")
        assert code == 1
        assert message in error
        assert error.startswith("shoecal new: ")
        assert not told
    assert not (tmp_path / "robot.yaml").exists()


def test_a_robot_in_mjcf_is_drafted_as_from_its_urdf(shoecal: Run, tmp_path: Path) -> None:
    """As published: with a free base. What motors can do MJCF does not say: that is told."""
    spec = mujoco.MjSpec.from_file(str(URDF))
    spec.compiler.fusestatic = False
    spec.worldbody.first_body().add_freejoint()
    spec.compile()
    mjcf = tmp_path / "wren.xml"
    mjcf.write_text(spec.to_xml())
    drafted = []
    for description in (URDF, mjcf):
        out = tmp_path / description.suffix[1:] / "wren.yaml"
        code, told, error = shoecal("new", "robot", description, "-o", out)
        assert (code, error) == (0, "")
        drafted.append(load_robot(out, load_shoe(out.with_name("wren_shoe.yaml"))))
    assert "MJCF has no speeds of motors" in " ".join(told.split())
    one, other = drafted
    assert other.weight == pytest.approx(one.weight, rel=1e-6)
    assert set(other.model.names) == set(one.model.names)
    for mine, theirs in zip(one.feet, other.feet, strict=True):
        both = [shapely.Polygon(foot.outline) for foot in (mine, theirs)]
        assert both[0].symmetric_difference(both[1]).area < 1e-3 * both[0].area
    assert shoecal("new", "robot", mjcf, "-o", tmp_path / "xml/other.yaml")[0] == 0
    code, _, error = shoecal("new", "robot", mjcf, "-o", tmp_path / "xml/wren.yaml")
    assert code == 1
    assert "is there already" in error
    text = out.read_text().replace("wren.urdf", "../wren.xml")
    out.write_text(text)
    code, _, error = shoecal("plan", out, "--out", tmp_path / "plan")
    assert code == 1
    assert "is an MJCF; make a URDF and a robot file of it with `shoecal new robot`" in error
