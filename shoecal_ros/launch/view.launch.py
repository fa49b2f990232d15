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
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo, SetEnvironmentVariable
from launch.conditions import IfCondition
from launch.substitutions import EqualsSubstitution, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from shoecal_core.workspace import network_environment

SHARE = Path(get_package_share_directory("shoecal_ros"))
RVIZ = str(SHARE / "rviz" / "shoecal.rviz")
FOXGLOVE = str(SHARE / "foxglove" / "shoecal.json")
PLOTJUGGLER = str(SHARE / "plotjuggler" / "shoecal.xml")

ARGUMENTS = {
    "viewer": ("rviz", "rviz, foxglove, plotjuggler or none"),
    "use_sim_time": ("false", "true where a simulator owns /clock"),
}


def generate_launch_description() -> LaunchDescription:
    """Start the one viewer that is asked for."""
    bridge = {"address": "127.0.0.1", "port": 8765}
    return LaunchDescription(
        [
            *(SetEnvironmentVariable(*each) for each in network_environment().items()),
            *(
                DeclareLaunchArgument(name, default_value=default, description=text)
                for name, (default, text) in ARGUMENTS.items()
            ),
            _viewer("rviz", "rviz2", "rviz2", ["-d", RVIZ]),
            _viewer("plotjuggler", "plotjuggler", "plotjuggler", ["--layout", PLOTJUGGLER]),
            _viewer("foxglove", "foxglove_bridge", "foxglove_bridge", [], bridge),
            LogInfo(
                msg=f"Foxglove: connect to ws://localhost:8765 and open the layout {FOXGLOVE}",
                condition=_asked("foxglove"),
            ),
        ]
    )


def _asked(viewer: str) -> IfCondition:
    return IfCondition(EqualsSubstitution(LaunchConfiguration("viewer"), viewer))


def _viewer(
    viewer: str,
    package: str,
    executable: str,
    arguments: list[str],
    parameters: dict[str, object] | None = None,
) -> Node:
    sim_time = ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool)
    return Node(
        package=package,
        executable=executable,
        arguments=arguments,
        parameters=[{**(parameters or {}), "use_sim_time": sim_time}],
        output="screen",
        condition=_asked(viewer),
    )
