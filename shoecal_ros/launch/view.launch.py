"""A viewer with shoecal's layout, for nodes that run already.

    ros2 launch shoecal_ros view.launch.py viewer:=rviz
    ros2 launch shoecal_ros view.launch.py viewer:=plotjuggler
    ros2 launch shoecal_ros view.launch.py viewer:=foxglove

    ros2 launch shoecal_ros view.launch.py viewer:=rviz namespace:=lab left_sole_frame:=one/l_sole

Foxglove runs elsewhere: this starts its bridge, on this computer alone (ws://localhost:8765), and
says which file to open there as a layout. The viewers are packages of their own:
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
from shoecal_ros.launched import program
from shoecal_ros.placed_layout import placed_layout

SHARE = Path(get_package_share_directory("shoecal_ros"))
LAYOUTS = {
    "rviz": SHARE / "rviz" / "shoecal.rviz",
    "plotjuggler": SHARE / "plotjuggler" / "shoecal.xml",
    "foxglove": SHARE / "foxglove" / "shoecal.json",
}
OPTIONS = {"rviz": "-d", "plotjuggler": "--layout"}
PARAMETERS = {"foxglove": {"address": "127.0.0.1", "port": 8765}}

ARGUMENTS = {
    "viewer": ("rviz", "rviz, foxglove, plotjuggler or none"),
    "namespace": ("", "namespace of the nodes that are shown"),
    "left_sole_frame": ("l_sole", "fixed frame of the view: the left sole's, with its prefix"),
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
    layout = placed_layout(
        LAYOUTS[viewer],
        LaunchConfiguration("namespace").perform(context),
        LaunchConfiguration("left_sole_frame").perform(context),
    )
    sim_time = ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool)
    node = program(
        VIEWERS[viewer],
        VIEWERS[viewer],
        arguments=[OPTIONS[viewer], str(layout)] if viewer in OPTIONS else [],
        parameters=[{**PARAMETERS.get(viewer, {}), "use_sim_time": sim_time}],
    )
    if viewer != "foxglove":
        return [node]
    hint = f"Foxglove: connect to ws://localhost:8765 and open the layout {layout}"
    return [node, LogInfo(msg=hint)]
