"""The simulated robot with all nodes, to play with.

    ros2 launch shoecal_ros demo.launch.py viewer:=rviz
    ros2 service call /shoe/arm std_srvs/srv/SetBool "{data: true}"
    ros2 service call /shoe/self_calibrate shoecal_msgs/srv/SelfCalibrate "{seed: -1}"
    ros2 action send_goal --feedback /shoe/diagnose shoecal_msgs/action/Diagnose "{seed: -1}"

`ros2 run shoecal_ros demo` does the whole job by itself and compares it with the truth.

Discovery stays on this computer unless ROS_AUTOMATIC_DISCOVERY_RANGE is set before.
"""

import tempfile
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, SetEnvironmentVariable
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from shoecal_core.workspace import network_environment

CONFIG = Path(get_package_share_directory("shoecal_core")) / "config"
BRINGUP = Path(get_package_share_directory("shoecal_ros")) / "launch" / "bringup.launch.py"
PORT = str(Path(tempfile.gettempdir()) / "shoecal_shoes")

ARGUMENTS = {
    "robot": (str(CONFIG / "robots" / "nao.yaml"), "robot file"),
    "shoe": ("", "shoe file; empty: ROBOT_shoe.yaml in ../shoes or beside ROBOT.yaml"),
    "reality": ("", "changes to the default simulated reality; empty: none"),
    "seed": ("1", "draws robot, cells and noise"),
    "speed": ("1.0", "simulated over wall-clock time"),
    "viewer": ("none", "also start a viewer: rviz, foxglove, plotjuggler or none"),
}


def generate_launch_description() -> LaunchDescription:
    """Start the simulator, and the nodes on its clock and its port."""
    return LaunchDescription(
        [
            *(SetEnvironmentVariable(*each) for each in network_environment().items()),
            *(
                DeclareLaunchArgument(name, default_value=default, description=text)
                for name, (default, text) in ARGUMENTS.items()
            ),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(str(BRINGUP)),
                launch_arguments={
                    "robot": LaunchConfiguration("robot"),
                    "shoe": LaunchConfiguration("shoe"),
                    "port": PORT,
                    "use_sim_time": "true",
                    "viewer": LaunchConfiguration("viewer"),
                }.items(),
            ),
            Node(
                package="shoecal_ros",
                executable="simulator",
                name="simulator",
                parameters=[
                    str(CONFIG / "nodes" / "simulator.yaml"),
                    {
                        "robot_file": _value("robot", str),
                        "shoe_file": _value("shoe", str),
                        "reality_file": _value("reality", str),
                        "seed": _value("seed", int),
                        "speed": _value("speed", float),
                        "port": PORT,
                    },
                ],
                output="screen",
            ),
        ]
    )


def _value(argument: str, kind: type) -> ParameterValue:
    return ParameterValue(LaunchConfiguration(argument), value_type=kind)
