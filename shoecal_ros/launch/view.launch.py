"""A viewer with shoecal's layout, beside nodes that run already.

    ros2 launch shoecal_ros view.launch.py viewer:=rviz
    ros2 launch shoecal_ros view.launch.py viewer:=plotjuggler
    ros2 launch shoecal_ros view.launch.py viewer:=foxglove

Foxglove runs elsewhere: this starts its bridge, on this computer alone (ws://localhost:8765); open
share/shoecal_ros/foxglove/shoecal.json there as a layout. The viewers are packages of their own:
ros-jazzy-rviz2, ros-jazzy-plotjuggler-ros, ros-jazzy-foxglove-bridge.

Discovery stays on this computer unless ROS_AUTOMATIC_DISCOVERY_RANGE is set before.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction, SetEnvironmentVariable
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from shoecal_core.workspace import network_environment
from shoecal_ros.bringup import VIEWERS, check_viewer

SHARE = Path(get_package_share_directory("shoecal_ros"))
FOXGLOVE = str(SHARE / "foxglove" / "shoecal.json")
LAYOUT_ARGUMENTS = {
    "rviz": ["-d", str(SHARE / "rviz" / "shoecal.rviz")],
    "plotjuggler": ["--layout", str(SHARE / "plotjuggler" / "shoecal.xml")],
    "foxglove": [],
}
PARAMETERS = {"foxglove": {"address": "127.0.0.1", "port": 8765}}

ARGUMENTS = {
    "viewer": ("rviz", "rviz, foxglove, plotjuggler or none"),
    "use_sim_time": ("false", "true where a simulator owns /clock"),
}


def generate_launch_description() -> LaunchDescription:
    """Start the one viewer that is asked for."""
    return LaunchDescription(
        [
            *(SetEnvironmentVariable(*each) for each in network_environment().items()),
            *(
                DeclareLaunchArgument(name, default_value=default, description=text)
                for name, (default, text) in ARGUMENTS.items()
            ),
            OpaqueFunction(function=_viewer),
        ]
    )


def _viewer(context: LaunchContext) -> list[Node | LogInfo]:
    viewer = check_viewer(LaunchConfiguration("viewer").perform(context))
    if not viewer:
        return []
    sim_time = ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool)
    node = Node(
        package=VIEWERS[viewer],
        executable=VIEWERS[viewer],
        arguments=LAYOUT_ARGUMENTS[viewer],
        parameters=[{**PARAMETERS.get(viewer, {}), "use_sim_time": sim_time}],
        output="screen",
    )
    if viewer != "foxglove":
        return [node]
    hint = f"Foxglove: connect to ws://localhost:8765 and open the layout {FOXGLOVE}"
    return [node, LogInfo(msg=hint)]
