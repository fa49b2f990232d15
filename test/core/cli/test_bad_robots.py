"""Robots that cannot be planned with: one line that names file, field and cure, and no motion."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
import yaml

from core.cli.conftest import ROOT, WREN, WREN_SHOE, Run
from core.shoe import mutations
from core.shoe.mutations import Key


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


def test_a_bad_robot_file(folder: Path, shoecal: Run) -> None:
    place: tuple[Key, ...] = ("feet", "left", "sensing_polygon_m", 0)
    robot = mutations.write_edited(folder / WREN.name, WREN, (place, [0.09, -0.022]))
    problem = "wren.yaml: feet.left.sensing_polygon_m: lies partly outside 'outline_m'; shrink it"
    assert problem in planned(shoecal, robot)


def test_legs_that_the_planner_cannot_use(folder: Path, shoecal: Run) -> None:
    """A robot file may name them; planning needs more."""
    place: tuple[Key, ...] = ("legs",)
    robot = mutations.write_edited(folder / WREN.name, WREN, (place, lambda legs: legs[:7]))
    assert "wren.yaml: legs: 7 joints cannot move" in planned(shoecal, robot)


def test_a_motor_without_torque(folder: Path, shoecal: Run) -> None:
    urdf = folder / "wren.urdf"
    text, count = re.subn(
        r'(name="left_knee".*?effort=)"2.5"', r'\1"0"', urdf.read_text(), count=1, flags=re.DOTALL
    )
    assert count == 1
    urdf.write_text(text)
    line = planned(shoecal, folder / WREN.name)
    assert "wren.urdf: joint left_knee: the effort limit is 0; give its motor's" in line


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


def narrow(folder: Path) -> Path:
    """The known robot, to stand in one double support alone."""
    span = yaml.safe_load(WREN.read_text())["support_range"]
    for row, place in zip(span.values(), (0.0, -0.13, 0.0), strict=True):
        row.update(lower=place, upper=place, neutral=place)
    return mutations.write_edited(folder / WREN.name, WREN, (("support_range",), span))


@pytest.mark.parametrize(
    ("joint", "change", "said"),
    [
        ("_", (r'effort="[^"]*"', 'effort="0.2"'),
         r"_\w+ would need [0-9.]+ N m more than torque_share of its 0\.2 N m; see that"),
        ("_hip_sway", (r'lower="[^"]*" upper="[^"]*"', 'lower="-0.06" upper="0.06"'),
         r"_sway would turn [0-9.]+ rad beyond its limits and their margins; see that"),
    ],
)  # fmt: skip
def test_the_bound_that_rules_a_stance_out(
    joint: str, change: tuple[str, str], said: str, folder: Path, shoecal: Run
) -> None:
    """Motors that are too weak; hips that do not turn far enough to stand wide."""
    urdf = folder / "wren.urdf"
    parts = re.split(r"(?=<joint name=)", urdf.read_text())
    chosen = [re.match(rf'<joint name="(left|right){joint}', part) for part in parts]
    assert sum(map(bool, chosen)) >= 2
    urdf.write_text(
        "".join(re.sub(*change, part) if named else part
                for part, named in zip(parts, chosen, strict=True))
    )  # fmt: skip
    line = planned(shoecal, narrow(folder))
    assert re.search(rf"with the .*{said}", line), line


def test_feet_without_ankle_roll(folder: Path, shoecal: Run) -> None:
    """Drafted with a word of warning; planning refuses them before it looks for anything."""
    urdf = folder / "wren.urdf"
    parts = re.split(r"(?=<joint name=)", urdf.read_text())
    stiff = [
        part.replace('type="revolute"', 'type="fixed"', 1) if "_ankle_sway" in part[:40] else part
        for part in parts
    ]
    urdf.write_text("".join(stiff))
    robot = folder / "stiff.yaml"
    code, said, _ = shoecal("new", "robot", urdf, "-o", robot)
    assert code == 0
    assert "legs: The feet have no ankle roll: while both soles stay flat, the CoP cannot" in said
    shoe = folder / "stiff_shoe.yaml"
    code, _, error = shoecal("plan", robot, "--shoe", shoe, "--out", folder / "out")
    assert code == 1
    (line,) = (one for one in error.splitlines() if "]" not in one)
    assert "cannot move the CoP sideways (the feet have no ankle roll); list every joint" in line
