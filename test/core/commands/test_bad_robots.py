"""Robots that cannot be planned with: one line that names file, field and cure, and no motion."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from core.commands.conftest import ROOT, WREN, WREN_SHOE
from core.sensing import mutations
from core.sensing.mutations import DELETE, Key

Run = Callable[..., tuple[int, str, str]]

LEFT: tuple[Key, ...] = ("feet", "left")
KNEE = r'(name="left_knee".*?<limit )lower="-0.03" upper="2.2" effort="2.5" velocity="5.5"'


def planned(shoecal: Run, robot: Path, *words: object) -> str:
    """The one line with which planning refuses."""
    out = robot.parent / "out"
    code, told, error = shoecal(
        "plan", robot, "--shoe", WREN_SHOE, "--supports", "1", "--out", out, *words
    )
    assert code == 1
    assert "motion_" not in told
    assert not out.exists()
    *progress, line = error.splitlines()
    assert all("] looking for double supports" in one for one in progress)
    return line


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for path in (WREN, WREN.with_suffix(".urdf")):
        shutil.copy(path, tmp_path)
    return tmp_path


BAD: dict[str, tuple[tuple[Key, ...], object, str]] = {
    "crossed range": (
        ("support_range", "dx_m", "lower"), 0.2,
        "wren.yaml: support_range.dx_m.lower: 0.2 is above 'upper' (0.06)",
    ),
    "feet that overlap": (
        ("support_range", "dy_m"), {"lower": -0.12, "upper": -0.07, "step": 0.01, "neutral": -0.07},
        "wren.yaml: support_range.dy_m.neutral: the outlines of the feet overlap",
    ),
    "a dent": (
        (*LEFT, "sensing_polygon_m"), lambda corners: [*corners, [0.0, 0.0]],
        "wren.yaml: feet.left.sensing_polygon_m: is not convex; list its convex hull",
    ),
    "beyond the sole": (
        (*LEFT, "sensing_polygon_m", 0), [0.09, -0.022],
        "wren.yaml: feet.left.sensing_polygon_m: lies partly outside 'outline_m'; shrink it",
    ),
    "a hollow capsule": (
        ("capsules", 0, "radius_m"), -0.03, "wren.yaml: capsules[0].radius_m: must be above 0",
    ),
    "a pair of strangers": (
        ("collision_pairs", 0, "a"), "left_wing",
        "wren.yaml: collision_pairs[0].a: 'left_wing' is not one of: left_thigh, ",
    ),
    "legs that reach one foot": (
        ("legs",), lambda legs: legs[:6], "wren.yaml: legs: none of them moves the right foot",
    ),
    "one motor of the right leg alone": (
        ("legs",), lambda legs: legs[:7], "wren.yaml: legs: 7 joints cannot move",
    ),
    "no legs": (("legs",), DELETE, "wren.yaml: legs: 0 joints cannot keep two feet in place"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_robot_files(name: str, folder: Path, shoecal: Run) -> None:
    place, value, message = BAD[name]
    robot = mutations.write_edited(folder / WREN.name, WREN, (place, value))
    assert message in planned(shoecal, robot)


BAD_LIMITS = {
    "crossed": (
        'lower="2.2" upper="-0.03" effort="2.5" velocity="5.5"',
        "joint left_knee: limits 2.2 to -0.03 are missing or crossed; give lower < upper",
    ),
    "no range": ('effort="2.5" velocity="5.5"', "joint left_knee: limits 0 to 0 are missing"),
    "no effort": (
        'lower="-0.03" upper="2.2" velocity="5.5"', 'joint left_knee: effort="" of its <limit>'
    ),
    "no torque": (
        'lower="-0.03" upper="2.2" effort="0" velocity="5.5"',
        "joint left_knee: the effort limit is 0; give its motor's",
    ),
    "no speed": (
        'lower="-0.03" upper="2.2" effort="2.5" velocity="0"',
        "joint left_knee: the velocity limit is 0; give its motor's",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD_LIMITS)
def test_bad_joint_limits(name: str, folder: Path, shoecal: Run) -> None:
    limits, message = BAD_LIMITS[name]
    urdf = folder / "wren.urdf"
    text, count = re.subn(KNEE, rf"\1{limits}", urdf.read_text(), count=1, flags=re.DOTALL)
    assert count == 1
    urdf.write_text(text)
    line = planned(shoecal, folder / WREN.name)
    assert "wren.urdf: " in line
    assert message in line


def test_a_horizon_below_two(folder: Path, shoecal: Run) -> None:
    parameters = ROOT / "config/nodes/planner.yaml"
    place: tuple[Key, ...] = ("/**/planner", "ros__parameters", "planning", "horizon")
    spoiled = mutations.write_edited(folder / "planner.yaml", parameters, (place, 1))
    line = planned(shoecal, folder / WREN.name, "--settings", spoiled)
    assert line.endswith(
        "planner.yaml: /**/planner.ros__parameters.planning.horizon: must be at least 2 and at "
        "most 100 states, got 1 states"
    )


def test_a_range_that_no_foot_fits_into(folder: Path, shoecal: Run) -> None:
    """Every pose of the range but the neutral one has overlapping feet."""
    span = yaml.safe_load(WREN.read_text())["support_range"]
    span["dy_m"].update(lower=-0.079, upper=-0.05, neutral=-0.079)
    robot = mutations.write_edited(folder / WREN.name, WREN, (("support_range",), span))
    assert "0 of 1 double supports found where the feet neither collide" in planned(shoecal, robot)
