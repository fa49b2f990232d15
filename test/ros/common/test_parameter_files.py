from __future__ import annotations

from pathlib import Path

import pytest
from rcl_interfaces.srv import GetParameters

from ros.world import World
from shoecal_core.workspace import config_dir
from shoecal_ros.common.parameter_files import ParameterFiles, UnusedFileError, given_files


def written(folder: Path, text: str) -> Path:
    path = folder / "nodes.yaml"
    path.write_text(text)
    return path


def parameter(world: World, node: str, name: str) -> float:
    request = GetParameters.Request(names=[name])
    (value,) = world.call(GetParameters, f"{node}/get_parameters", request).values
    return float(value.double_value)


def test_files_are_those_among_the_ros_arguments() -> None:
    arguments = ["node", "--params-file", "no", "--ros-args", "--params-file", "a", "-p", "x:=1"]
    assert given_files([*arguments, "--params-file", "b", "--", "--params-file", "no"]) == [
        Path("a"), Path("b"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "full_name", "key"),
    [
        ("planner: {ros__parameters: {a: 1}}", "/left/planner", "/**/planner"),
        ("planner: {ros__parameters: {a: 1}}", "/mine", "/**/mine"),
        ("plannner: {ros__parameters: {a: 1}}", "/planner", "/**/planner"),
        # The second section alone would be dropped in silence.
        (
            "/**: {ros__parameters: {a: 1}}\nplanner: {ros__parameters: {b: 1}}",
            "/left/planner",
            "/**/planner",
        ),
    ],
)
def test_a_file_that_does_not_reach_its_node(
    tmp_path: Path, text: str, full_name: str, key: str
) -> None:
    files = ParameterFiles(["--ros-args", "--params-file", str(written(tmp_path, text))])
    with pytest.raises(UnusedFileError, match="do not reach this node") as caught:
        files.check(full_name, "planner")
    assert f"name their key {key}" in str(caught.value)


def test_a_file_for_all_nodes_may_set_what_this_one_does_not_have(tmp_path: Path) -> None:
    text = "/**: {ros__parameters: {a: 1, b: 2}}\n/**/planner: {ros__parameters: {b: 3}}"
    files = ParameterFiles(["--ros-args", "--params-file", str(written(tmp_path, text))])
    files.check("/left/planner", "planner")
    assert files.shared("/left/planner") == {"a"}


def test_limits_are_in_force_in_every_namespace_and_under_every_name(
    world: World, tmp_path: Path
) -> None:
    for key, renamed, full_name in (
        ("/**/model", ["__ns:=/left"], "left/model"),
        ("/**/mine", ["__node:=mine"], "mine"),
    ):
        file = written(tmp_path, f"{key}: {{ros__parameters: {{stale_s: 0.7}}}}")
        arguments = [part for each in renamed for part in ("-r", each)]
        world.start("model", {}, "--params-file", str(file), *arguments)
        assert parameter(world, full_name, "stale_s") == 0.7
        assert world.stop("model") == 0


def test_the_configuration_reaches_its_nodes_in_a_namespace(world: World) -> None:
    file = config_dir() / "nodes" / "model.yaml"
    world.start("model", {}, "--params-file", str(file), "-r", "__ns:=/far/left")
    assert parameter(world, "far/left/model", "stale_s") == 0.5


def test_what_is_meant_for_other_nodes_does_not_end_this_one(world: World, tmp_path: Path) -> None:
    text = "/**: {ros__parameters: {stale_s: 0.7, robot_description: text}}"
    world.start("model", {}, "--params-file", str(written(tmp_path, text)))
    world.until_logged("model", "robot_description: is given to all nodes")
    assert parameter(world, "model", "stale_s") == 0.7


@pytest.mark.parametrize(
    ("text", "reported"),
    [
        ("model: {ros__parameters: {stale_s: 0.7}}", "model, which do not reach this node"),
        ("/**/model: {ros__parameters: {stale: 0.7}}", "has no such parameter (perhaps stale_s)"),
        ("/**/model: {ros__parameters: {stale_s: ", "not valid YAML at line"),
        ("", "No such file or directory"),
    ],
)
def test_a_bad_file_ends_a_node_with_one_line(
    world: World, tmp_path: Path, text: str, reported: str
) -> None:
    file = written(tmp_path, text) if text else tmp_path / "missing.yaml"
    world.start("model", {}, "--params-file", str(file), "-r", "__ns:=/left")
    assert world.ended("model") == 1
    (line,) = [each for each in world.output("model").splitlines() if "[" not in each[:1]]
    assert line.startswith("model: ")
    assert reported in line


@pytest.mark.parametrize("arguments", [("-r", "__ns:=bad-ns"), ("--unknown",), ("-p", "a:=[")])
def test_bad_ros_arguments_end_a_node_with_one_line(
    world: World, arguments: tuple[str, ...]
) -> None:
    world.start("model", {}, *arguments)
    assert world.ended("model") == 1
    own = [line for line in world.output("model").splitlines() if line.startswith("model: ")]
    assert len(own) == 1
    assert own[0].endswith("correct the command line")
    assert "Traceback" not in world.output("model")
