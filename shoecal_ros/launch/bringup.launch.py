"""The nodes started with a robot: shoe_driver, model, planner, calibrator, if needed an adapter.

    ros2 launch shoecal_ros bringup.launch.py robot:=ROBOT.yaml shoe:=SHOE.yaml device:=DEVICE.yaml

Arguments, files and packages are checked before the first node starts. Discovery stays on this
computer unless ROS_AUTOMATIC_DISCOVERY_RANGE is set before.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    IncludeLaunchDescription,
    OpaqueFunction,
    SetEnvironmentVariable,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from shoecal_core.workspace import network_environment
from shoecal_ros.bringup import robot_nodes
from shoecal_ros.launched import action

VIEW = Path(get_package_share_directory("shoecal_ros")) / "launch" / "view.launch.py"
CONFIG = Path(get_package_share_directory("shoecal_core")) / "config"

ARGUMENTS = {
    "robot": (str(CONFIG / "robots" / "nao.yaml"), "robot file"),
    "shoe": ("", "shoe file; empty: ROBOT_shoe.yaml in ../shoes or next to ROBOT.yaml"),
    "device": (
        str(CONFIG / "nodes" / "shoe_driver.yaml"),
        "device file: port, mode, which channel is which cell",
    ),
    "port": ("", "serial port; empty: the one in the device file"),
    "params": (str(CONFIG / "nodes"), "folder of the nodes' parameter files"),
    "state": ("", "folder of calibrations and sessions; empty: those of calibrator.yaml"),
    "adapter": ("none", "also start an adapter: nao_lola, naoqi, controller or none"),
    "namespace": ("", "namespace of all nodes"),
    "enclaves": ("false", "true gives each node its SROS2 enclave, /shoecal/NODE"),
    "use_sim_time": ("false", "true where a simulator owns /clock"),
    "viewer": ("none", "also start a viewer: rviz, foxglove, plotjuggler or none"),
    "left_sole_frame": ("l_sole", "fixed frame of the viewer: the left sole's, with its prefix"),
}


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments, check them, and start the nodes."""
    return LaunchDescription(
        [
            *(SetEnvironmentVariable(*each) for each in network_environment().items()),
            *(
                DeclareLaunchArgument(name, default_value=default, description=text)
                for name, (default, text) in ARGUMENTS.items()
            ),
            OpaqueFunction(function=_nodes),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(str(VIEW)),
                launch_arguments={
                    "viewer": LaunchConfiguration("viewer"),
                    "namespace": LaunchConfiguration("namespace"),
                    "left_sole_frame": LaunchConfiguration("left_sole_frame"),
                    "use_sim_time": LaunchConfiguration("use_sim_time"),
                }.items(),
            ),
        ]
    )


def _nodes(context: LaunchContext) -> list[Node]:
    arguments = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    return [action(node) for node in robot_nodes(arguments)]
