"""Topics of a recording as ROS types."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from geometry_msgs.msg import PoseStamped, WrenchStamped
from sensor_msgs.msg import Imu, JointState, Temperature
from shoecal_msgs.msg import ShoeVoltages
from trajectory_msgs.msg import JointTrajectory

from shoecal_core.recording import schemas

TYPES: Mapping[str, type[Any]] = MappingProxyType(
    {
        "sensor_msgs/msg/JointState": JointState,
        "trajectory_msgs/msg/JointTrajectory": JointTrajectory,
        "shoecal_msgs/msg/ShoeVoltages": ShoeVoltages,
        "geometry_msgs/msg/PoseStamped": PoseStamped,
        "geometry_msgs/msg/WrenchStamped": WrenchStamped,
        "sensor_msgs/msg/Imu": Imu,
        "sensor_msgs/msg/Temperature": Temperature,
    }
)

RAW_TOPICS: Mapping[str, type[Any]] = MappingProxyType(
    {topic: TYPES[kind] for topic, kind in schemas.RUN_TOPICS.items()}
)
"""Every topic that a run may hold, by its name in the recording."""


def relative(topic: str) -> str:
    """The name to subscribe to, so that namespaces and remapping work."""
    return topic.removeprefix("/")
