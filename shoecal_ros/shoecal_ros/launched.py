"""Programs as actions of `launch`; the only module that needs it."""

from __future__ import annotations

from typing import Any

from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from shoecal_ros.bringup import NodeToStart, ending_with_launch


def program(package: str, executable: str, **options: Any) -> Node:
    """The action that starts a program, which ends with launch whatever ends that.

    Args:
        package: that it is in.
        executable: its name.
        options: further ones of the action.
    """
    return Node(
        package=package,
        executable=executable,
        # In the log; else it would be that of what stands before the command line.
        exec_name=executable,
        prefix=[f"{ending_with_launch()} ", LaunchConfiguration("launch-prefix", default="")],
        output="screen",
        **options,
    )


def action(node: NodeToStart) -> Node:
    """The action that starts a node."""
    parameters = {
        name: ParameterValue(value, value_type=type(value))
        for name, value in node.parameters.items()
    }
    return program(
        "shoecal_ros",
        node.name,
        name=node.name,
        namespace=node.namespace,
        parameters=[*map(str, node.files), parameters],
        ros_arguments=node.ros_arguments,
    )
