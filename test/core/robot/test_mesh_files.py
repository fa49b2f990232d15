"""Meshes that are not where a URDF says, as descriptions are published."""

from __future__ import annotations

from pathlib import Path

import pytest

from shoecal_core.robot.mesh_files import find_mesh


def put(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(name)


@pytest.mark.parametrize(
    ("there", "named"),
    [
        ("robots/meshes/foot.stl", "package:///foot.stl"),
        ("robots/foot.stl", "package:///foot.stl"),
        ("robots/meshes/foot.stl", "package://another_name/meshes/foot.stl"),
        ("meshes/legs/foot.stl", "package://gone/meshes/legs/foot.stl"),
        ("robots/meshes/foot.stl", "meshes/foot.stl"),
        ("robots/meshes/foot.stl", r"meshes\foot.stl"),
        ("robots/meshes/a[1]*.stl", "package:///a[1]*.stl"),
    ],
)
def test_near_the_urdf(tmp_path: Path, there: str, named: str) -> None:
    put(tmp_path, there, "robots/robot.urdf", "robots/meshes/hand.stl")
    assert find_mesh(tmp_path / "robots/robot.urdf", named) == tmp_path / there


def test_where_the_urdf_says_comes_first(tmp_path: Path) -> None:
    put(tmp_path, "arm/meshes/foot.stl", "arm/urdf/r.urdf", "arm/urdf/foot.stl", "given/foot.stl")
    urdf = tmp_path / "arm/urdf/r.urdf"
    assert find_mesh(urdf, "package://arm/meshes/foot.stl", tmp_path / "given") == (
        tmp_path / "arm/meshes/foot.stl"
    )


def test_the_folder_that_is_given_comes_before_what_is_near(tmp_path: Path) -> None:
    put(tmp_path, "a/b/urdf/r.urdf", "a/b/urdf/foot.stl", "far/off/meshes/foot.stl")
    found = find_mesh(tmp_path / "a/b/urdf/r.urdf", "package://gone/foot.stl", tmp_path / "far")
    assert found == tmp_path / "far/off/meshes/foot.stl"


def test_of_several_the_one_that_ends_most_like_its_name(tmp_path: Path) -> None:
    put(tmp_path, "r.urdf", "meshes/coarse/foot.stl", "meshes/fine/foot.stl")
    found = find_mesh(tmp_path / "r.urdf", "package://gone/fine/foot.stl")
    assert found == tmp_path / "meshes/fine/foot.stl"


def test_what_is_not_there(tmp_path: Path) -> None:
    put(tmp_path, "a/r.urdf", "other/foot.stl")
    for named in ("package:///foot.stl", "file:///nowhere/foot.stl", "/nowhere/foot.stl"):
        assert find_mesh(tmp_path / "a/r.urdf", named) is None
