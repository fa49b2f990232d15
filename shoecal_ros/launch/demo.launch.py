"""The simulated robot with all nodes, to play with.

    ros2 launch shoecal_ros demo.launch.py viewer:=rviz
    ros2 service call /shoe/arm std_srvs/srv/SetBool "{data: true}"
    ros2 service call /shoe/self_calibrate shoecal_msgs/srv/SelfCalibrate "{seed: -1}"
    ros2 action send_goal --feedback /shoe/diagnose shoecal_msgs/action/Diagnose "{seed: -1}"

`ros2 run shoecal_ros demo` does the whole job by itself and compares it with the truth.

Calibrations and sessions have a folder of their own, so that none of the demo's gets to a robot.
Discovery stays on this computer unless ROS_AUTOMATIC_DISCOVERY_RANGE is set before.
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
from shoecal_ros.bringup import simulated_device, simulated_robot, simulated_state
from shoecal_ros.launched import action

CONFIG = Path(get_package_share_directory("shoecal_core")) / "config"
BRINGUP = Path(get_package_share_directory("shoecal_ros")) / "launch" / "bringup.launch.py"

ARGUMENTS = {
    "robot": (str(CONFIG / "robots" / "nao.yaml"), "robot file"),
    "shoe": ("", "shoe file; empty: ROBOT_shoe.yaml in ../shoes or next to ROBOT.yaml"),
    "reality": ("", "changes to the default simulated reality; empty: none"),
    "seed": ("1", "draws robot, cells and noise"),
    "speed": ("1.0", "simulated over wall-clock time"),
    "params": (str(CONFIG / "nodes"), "folder of the nodes' parameter files"),
    "state": ("", "folder of calibrations and sessions; empty: ~/.ros/shoecal_demo/NAMESPACE"),
    "namespace": ("", "namespace of all nodes, the simulator included; /clock stays where it is"),
    "enclaves": ("false", "true gives each node its SROS2 enclave, /shoecal/NODE"),
    "viewer": ("none", "also start a viewer: rviz, foxglove, plotjuggler or none"),
}


def generate_launch_description() -> LaunchDescription:
    """Start the nodes, and the simulator whose clock and port they use."""
    return LaunchDescription(
        [
            *(SetEnvironmentVariable(*each) for each in network_environment().items()),
            *(
                DeclareLaunchArgument(name, default_value=default, description=text)
                for name, (default, text) in ARGUMENTS.items()
            ),
            OpaqueFunction(function=_simulation),
        ]
    )


def _simulation(context: LaunchContext) -> list[IncludeLaunchDescription | Node]:
    arguments = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    namespace = arguments["namespace"]
    shared = ("robot", "shoe", "params", "namespace", "enclaves", "viewer")
    return [
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource(str(BRINGUP)),
            launch_arguments={
                **{name: arguments[name] for name in shared},
                "device": simulated_device(arguments),
                "state": arguments["state"] or simulated_state(namespace),
                "use_sim_time": "true",
            }.items(),
        ),
        action(simulated_robot(arguments)),
    ]
