"""Type of each recorded topic, the type's definition and its hash."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

import yaml
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from shoecal_core.shoe.shoe import FEET

JOINT_STATES = "/joint_states"
JOINT_TRAJECTORY = "/joint_trajectory"
VOLTAGES = "/shoe/voltages"
BASE_POSE = "/base_pose"
IMU = "/imu"
SHOE_TEMPERATURE = "/shoe/temperature"
JOINT_TEMPERATURES = "/joint_temperatures"
"""One message a motor: header.frame_id is the joint's name."""
FORCE_TORQUE = tuple(f"/ft/{foot}" for foot in FEET)
TRUTH_COP = "/truth/cop"
TRUTH_GRF = "/truth/grf"
TRUTH_FOOT_COP = tuple(f"/truth/{foot}/cop" for foot in FEET)
TRUTH_FOOT_GRF = tuple(f"/truth/{foot}/grf" for foot in FEET)

SHOE_VOLTAGES_TYPE = "shoecal_msgs/msg/ShoeVoltages"

RUN_TOPICS: Mapping[str, str] = MappingProxyType(
    {
        JOINT_STATES: "sensor_msgs/msg/JointState",
        JOINT_TRAJECTORY: "trajectory_msgs/msg/JointTrajectory",
        VOLTAGES: SHOE_VOLTAGES_TYPE,
        BASE_POSE: "geometry_msgs/msg/PoseStamped",
        IMU: "sensor_msgs/msg/Imu",
        SHOE_TEMPERATURE: "sensor_msgs/msg/Temperature",
        JOINT_TEMPERATURES: "sensor_msgs/msg/Temperature",
        **dict.fromkeys(FORCE_TORQUE, "geometry_msgs/msg/WrenchStamped"),
    }
)
"""Topics of a run, with their types."""

TRUTH_TOPICS: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys((TRUTH_COP, *TRUTH_FOOT_COP), "geometry_msgs/msg/PointStamped"),
        **dict.fromkeys((TRUTH_GRF, *TRUTH_FOOT_GRF), "geometry_msgs/msg/WrenchStamped"),
    }
)
"""Topics of the simulated truth, with their types."""

SHOE_VOLTAGES_DEFINITION = """\
# Raw readings of one device frame, any subset of the cells.
uint8 GOOD=0
uint8 SATURATED=1      # at an end of the converter's range
uint8 NO_DATA=2        # the converter gave nothing: voltage is NaN
uint8 FAULT=3          # the device says this cell is broken

std_msgs/Header header # stamp: sampling time
uint32 sequence        # device counter, counts every frame
string[] cell          # for example left/front_left
float64[] voltage      # V (or the device's unit), raw, NaN where the cell gave none
uint8[] status         # 0 good, see the constants
float64 temperature    # degC, NaN where there is no sensor
"""
"""ShoeVoltages.msg: recordings are written where shoecal_msgs is not installed."""

GOOD = 0
SATURATED = 1
NO_DATA = 2
FAULT = 3
"""Constants of ShoeVoltages that readings of other sources need too."""


@cache
def typestore() -> Typestore:
    """Types of ROS 2 Jazzy and ShoeVoltages."""
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(SHOE_VOLTAGES_DEFINITION, SHOE_VOLTAGES_TYPE))
    return store


@cache
def schema_text(type_name: str) -> bytes:
    """Definition of a type with all it depends on, as MCAP's `ros2msg` encoding wants it."""
    return typestore().generate_msgdef(type_name, ros_version=2)[0].encode()


@cache
def type_hash(type_name: str) -> str:
    """RIHS01 hash of a type."""
    return typestore().hash_rihs01(type_name)


@cache
def channel_metadata(type_name: str) -> Mapping[str, str]:
    """What rosbag2 keeps with a channel: quality of service for playing back, and type hash."""
    return {"offered_qos_profiles": _QOS, "topic_type_hash": type_hash(type_name)}


_FOREVER = {"sec": 9223372036, "nsec": 854775807}
_QOS = yaml.safe_dump(
    [
        {
            "history": "keep_last",
            "depth": 10,
            "reliability": "reliable",
            "durability": "volatile",
            "deadline": _FOREVER,
            "lifespan": _FOREVER,
            "liveliness": "automatic",
            "liveliness_lease_duration": _FOREVER,
            "avoid_ros_namespace_conventions": False,
        }
    ],
    sort_keys=False,
)
