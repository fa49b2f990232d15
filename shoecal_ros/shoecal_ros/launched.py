"""Nodes as actions of `launch`; the only module that needs it."""

from __future__ import annotations

from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from shoecal_ros.bringup import NodeToStart


def action(node: NodeToStart) -> Node:
    """The action that starts a node."""
    parameters = {
        name: ParameterValue(value, value_type=type(value))
        for name, value in node.parameters.items()
    }
    return Node(
        package="shoecal_ros",
        executable=node.name,
        name=node.name,
        namespace=node.namespace,
        parameters=[*map(str, node.files), parameters],
        ros_arguments=node.ros_arguments,
        output="screen",
    )
