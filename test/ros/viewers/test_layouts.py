"""Layouts show topics, types and fields that the real nodes have; what is missing is told."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from ros.viewers.fit import misfits
from ros.viewers.layouts import shown_by
from ros.world import World
from shoecal_core.errors import FileError, ShoecalError
from shoecal_ros.placed_layout import placed_layout

ROS = Path(__file__).parents[3] / "shoecal_ros"
LAYOUTS = (
    ROS / "rviz/shoecal.rviz",
    ROS / "foxglove/shoecal.json",
    ROS / "plotjuggler/shoecal.xml",
)
POINT = ("geometry_msgs/msg/PointStamped",)


def foxglove(folder: Path, *paths: str) -> Path:
    file = folder / "layout.json"
    plot = {"foxglovePanelTitle": "Plot", "paths": [{"value": path} for path in paths]}
    file.write_text(json.dumps({"configById": {"Plot!1": plot}}))
    return file


def plotjuggler(folder: Path, *names: str) -> Path:
    file = folder / "layout.xml"
    curves = "".join(f'<curve name="{name}"/>' for name in names)
    file.write_text(f'<root><DockArea name="Plot"><plot>{curves}</plot></DockArea></root>')
    return file


def test_layouts_fit_the_real_nodes(world: World) -> None:
    port = {"port": world.folder / "port"}
    folders = {"state_dir": world.folder / "state", "sessions_dir": world.folder / "sessions"}
    world.start("simulator", port)
    world.start("shoe_driver", {**port, "use_sim_time": True})
    world.start("model", {"use_sim_time": True})
    world.start("planner", {"use_sim_time": True})
    world.start("calibrator", {"use_sim_time": True, **folders})

    def found() -> list[str]:
        topics = {
            name: kinds
            for name, kinds in world.node.get_topic_names_and_types()
            if world.node.count_publishers(name)
        }
        return [line for file in LAYOUTS for line in misfits(file, topics)]

    try:
        world.until(lambda: not found())
    except AssertionError as error:
        raise AssertionError("\n".join(found())) from error


@pytest.mark.parametrize("file", LAYOUTS, ids=lambda file: file.suffix)
def test_each_layout_shows_markers_or_lines_of_both_feet(file: Path) -> None:
    topics = {one.topic for one in shown_by(file)}
    assert any("/shoe/markers" in topic or "/shoe/left/grf" in topic for topic in topics)
    assert any("/shoe/cop" in topic for topic in topics)
    assert any("/shoe/model/cop" in topic for topic in topics)


@pytest.mark.parametrize("file", LAYOUTS, ids=lambda file: file.suffix)
def test_layouts_follow_namespace_and_frame(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert placed_layout(file, "/", "l_sole") == file
    new = placed_layout(file, "lab/two", "one/left_shoe")
    before = [one.topic.replace("/shoe/", "/lab/two/shoe/") for one in shown_by(file)]
    assert [one.topic for one in shown_by(new)] == before
    text = new.read_text()
    assert not re.search(r"\bl_sole\b", text)
    assert text.count("one/left_shoe") == len(re.findall(r"\bl_sole\b", file.read_text()))


@pytest.mark.parametrize("names", [("a b", "l_sole"), ("lab", "l sole"), ("lab", "")])
def test_names_that_are_none_are_refused(names: tuple[str, str]) -> None:
    with pytest.raises(ShoecalError, match="for example"):
        placed_layout(LAYOUTS[0], *names)


def test_foxglove_panels_are_those_of_its_arrangement() -> None:
    layout = json.loads(LAYOUTS[1].read_text())

    def placed(node: object) -> list[str]:
        if isinstance(node, dict):
            return placed(node["first"]) + placed(node["second"])
        return [str(node)]

    assert sorted(placed(layout["layout"])) == sorted(layout["configById"])


def test_a_missing_topic_is_told_with_what_looks_like_it(tmp_path: Path) -> None:
    file = foxglove(tmp_path, "/shoe/copp.point.x", "/elsewhere.data")
    near, none = misfits(file, {"/shoe/cop": POINT})
    assert near.endswith("copp.point.x: no node publishes this topic; perhaps /shoe/cop")
    assert none.endswith("Plot: /elsewhere.data: no node publishes this topic")


@pytest.mark.parametrize(
    ("path", "reported"),
    [
        ("/shoe/cop.point.x", ""),
        ("/shoe/cop.header.stamp.sec", ""),
        ("/shoe/state.feet[1].status[0]", ""),
        ("/shoe/cop.point.w", "geometry_msgs/Point has no field 'w'; it has x, y, z"),
        ("/shoe/cop.point.x.more", "double has no field 'more'"),
        ("/shoe/state.feet[0].force", "shoecal_msgs/FootState has no field 'force'"),
    ],
)
def test_fields_are_looked_up_in_the_messages(tmp_path: Path, path: str, reported: str) -> None:
    topics = {"/shoe/cop": POINT, "/shoe/state": ("shoecal_msgs/msg/ShoeState",)}
    found = misfits(foxglove(tmp_path, path), topics)
    assert (reported in found[0]) if reported else not found


def test_plotjuggler_writes_topics_and_fields_alike(tmp_path: Path) -> None:
    topics = {"/shoe/left/cop": POINT, "/shoe/left": POINT}
    good = plotjuggler(tmp_path, "/shoe/left/cop/point/x", "/shoe/left/point/y")
    assert not misfits(good, topics)
    (reported,) = misfits(plotjuggler(tmp_path, "/shoe/left/cop/points/x"), topics)
    assert "has no field 'points'" in reported
    (gone,) = misfits(plotjuggler(tmp_path, "/other/point/x"), topics)
    assert "no node publishes this topic" in gone


def test_a_display_of_another_type_is_told(tmp_path: Path) -> None:
    (reported,) = (
        line for line in misfits(LAYOUTS[0], {"/shoe/markers": POINT}) if "drawn as" in line
    )
    assert (
        "is geometry_msgs/msg/PointStamped, drawn as visualization_msgs/msg/MarkerArray" in reported
    )


@pytest.mark.parametrize(
    ("name", "content", "reported"),
    [
        ("layout.txt", "", "is no layout: expected"),
        ("layout.json", "{", "is no layout of its viewer"),
        ("layout.json", "[]", "is no layout of its viewer"),
        ("layout.json", '{"configById": {}}', "shows no topic"),
        ("layout.xml", "<root>", "is no layout of its viewer"),
        ("layout.rviz", "Displays: 3", "is no layout of its viewer"),
        ("layout.rviz", "\0", "is no layout of its viewer"),
    ],
)
def test_files_that_are_no_layout(tmp_path: Path, name: str, content: str, reported: str) -> None:
    file = tmp_path / name
    file.write_text(content)
    with pytest.raises(FileError, match=reported):
        shown_by(file)
