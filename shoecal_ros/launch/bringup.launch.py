"""The nodes beside a robot: shoe_driver, model, planner, calibrator.

    ros2 launch shoecal_ros bringup.launch.py robot:=ROBOT.yaml shoe:=SHOE.yaml port:=/dev/ttyUSB0

Discovery stays on this computer unless ROS_AUTOMATIC_DISCOVERY_RANGE is set before.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, SetEnvironmentVariable
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from shoecal_core.workspace import network_environment

VIEW = Path(get_package_share_directory("shoecal_ros")) / "launch" / "view.launch.py"
CONFIG = Path(get_package_share_directory("shoecal_core")) / "config"

ARGUMENTS = {
    "robot": (str(CONFIG / "robots" / "nao.yaml"), "robot file"),
    "shoe": ("", "shoe file; empty: ROBOT_shoe.yaml in ../shoes or beside ROBOT.yaml"),
    "device": (
        str(CONFIG / "nodes" / "shoe_driver.yaml"),
        "device file: port, mode, which channel is which cell",
    ),
    "port": ("", "serial port; empty: the one in the device file"),
    "params": (str(CONFIG / "nodes"), "folder of the nodes' parameter files"),
    "namespace": ("", "namespace of all nodes"),
    "use_sim_time": ("false", "true where a simulator owns /clock"),
    "viewer": ("none", "also start a viewer: rviz, foxglove, plotjuggler or none"),
}


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments and start the four nodes."""
    robot = {
        "robot_file": ParameterValue(LaunchConfiguration("robot"), value_type=str),
        "shoe_file": ParameterValue(LaunchConfiguration("shoe"), value_type=str),
    }
    device = {
        "config_file": ParameterValue(LaunchConfiguration("device"), value_type=str),
        "port": ParameterValue(LaunchConfiguration("port"), value_type=str),
    }
    planner_file = PathJoinSubstitution([LaunchConfiguration("params"), "planner.yaml"])
    same_planning = {"planner_file": ParameterValue(planner_file, value_type=str)}
    return LaunchDescription(
        [
            *(SetEnvironmentVariable(*each) for each in network_environment().items()),
            *(
                DeclareLaunchArgument(name, default_value=default, description=text)
                for name, (default, text) in ARGUMENTS.items()
            ),
            _node("shoe_driver", [device]),
            _node("model", [_file("model"), robot]),
            _node("planner", [_file("planner"), robot]),
            _node("calibrator", [_file("calibrator"), robot, same_planning]),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(str(VIEW)),
                launch_arguments={
                    "viewer": LaunchConfiguration("viewer"),
                    "use_sim_time": LaunchConfiguration("use_sim_time"),
                }.items(),
            ),
        ]
    )


def _node(name: str, parameters: list[object]) -> Node:
    sim_time = ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool)
    return Node(
        package="shoecal_ros",
        executable=name,
        name=name,
        namespace=LaunchConfiguration("namespace"),
        parameters=[*parameters, {"use_sim_time": sim_time}],
        output="screen",
    )


def _file(name: str) -> PathJoinSubstitution:
    return PathJoinSubstitution([LaunchConfiguration("params"), f"{name}.yaml"])
