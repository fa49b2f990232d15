"""Bags of a robot with six-axis ankles, as a lab would record them, in every format."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer
from rosbags.interfaces import Connection
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from core.recording import samples
from core.shoe.shoes import ROOT
from shoecal_core.arrays import FloatArray

FORMATS = ("ros1", "mcap", "sqlite3")
START_S = 1_700_000_000.0
SECONDS = 2.0
SENSOR = """<link name="{side}_sensor"/><joint name="{side}_sensor_mount" type="fixed">
    <parent link="{side}_flat"/><child link="{side}_sensor"/>
    <origin xyz="0 0 0" rpy="{rpy}"/></joint>
    <link name="{side}_flat"/><joint name="{side}_flat_mount" type="fixed">
    <parent link="{side}_sole"/><child link="{side}_flat"/>
    <origin xyz="0 0 0" rpy="0 -1.5707963267948966 0"/></joint>"""
TURNED = {"left": "0 0 1.5707963267948966", "right": "3.141592653589793 0 0"}
"""Axes of the left sensor are turned by a quarter about z, those of the right one reversed."""


def robot_files(folder: Path) -> tuple[Path, Path]:
    """Robot and shoe file of a robot with a sensor frame in each foot."""
    config = ROOT / "config/robots"
    sensors = "".join(SENSOR.format(side=side, rpy=rpy) for side, rpy in TURNED.items())
    urdf = (config / "wren.urdf").read_text().replace("</robot>", f"{sensors}</robot>")
    (folder / "wren.urdf").write_text(urdf)
    robot, shoe = folder / "wren.yaml", folder / "ankles.yaml"
    robot.write_bytes((config / "wren.yaml").read_bytes())
    shoe.write_text(samples.ANKLE_YAML)
    return robot, shoe


def angles(times: FloatArray, joint: int) -> FloatArray:
    """Of one joint [rad]."""
    return 0.1 * np.sin(2.0 * times + joint)


def force(times: FloatArray) -> FloatArray:
    """(T, 3) that both feet feel, in the sole's frame [N]."""
    return np.column_stack([5.0 + 0.0 * times, 10.0 * np.sin(times), 150.0 + 20.0 * np.cos(times)])


class BagWriter:
    """Writes messages into a bag of one of FORMATS."""

    def __init__(self, folder: Path, name: str, kind: str) -> None:
        self.path = folder / (f"{name}.bag" if kind == "ros1" else name)
        self.ros1 = kind == "ros1"
        self.store: Typestore = get_typestore(
            Stores.ROS1_NOETIC if self.ros1 else Stores.ROS2_JAZZY
        )
        self.compression: CompressionMode | None = None
        self._messages: list[tuple[float, str, Any]] = []
        self._plugin = StoragePlugin.SQLITE3 if kind == "sqlite3" else StoragePlugin.MCAP

    def make(self, kind: str, **fields: Any) -> Any:
        """A message of a type such as `sensor_msgs/msg/Imu`."""
        return self.store.types[kind](**fields)

    def header(self, time: float | None, frame: str = "") -> Any:
        """Header stamped `time` after the start [s]; None: not stamped."""
        nanoseconds = 0 if time is None else round(1e9 * (START_S + time))
        seconds, rest = divmod(nanoseconds, 10**9)
        stamp = self.make("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)
        counter = {"seq": 0} if self.ros1 else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **counter)

    def vector(self, values: Any) -> Any:
        return self.make(
            "geometry_msgs/msg/Vector3", **dict(zip("xyz", map(float, values), strict=True))
        )

    def quaternion(self, values: Any) -> Any:
        return self.make(
            "geometry_msgs/msg/Quaternion", **dict(zip("xyzw", map(float, values), strict=True))
        )

    def add(self, received: float, topic: str, message: Any) -> None:
        """One message, received so long after the start [s]."""
        self._messages.append((received, topic, message))

    def joint_state(
        self, time: float | None, names: list[str], position: Any, effort: Any = ()
    ) -> Any:
        return self.make(
            "sensor_msgs/msg/JointState",
            header=self.header(time),
            name=names,
            position=np.asarray(position, dtype=np.float64),
            velocity=np.zeros(0),
            effort=np.asarray(effort, dtype=np.float64),
        )

    def joints(
        self, time: float, names: Sequence[str], angles: Any = 0.0, topic: str = "/joint_states"
    ) -> None:
        """Angles of joints, one each or one for all, received when stamped."""
        self.add(time, topic, self.joint_state(time, [*names], np.full(len(names), angles)))

    def feet(self, time: float, sides: Sequence[str] = ("left", "right")) -> None:
        """50 N on `/left` and `/right` in their sensors' frames, received when stamped."""
        for side in sides:
            self.add(time, f"/{side}", self.wrench(time, f"{side}_sensor", [0.0, 0.0, 50.0]))

    def wrench(self, time: float, frame: str, values: Any) -> Any:
        wrench = self.make(
            "geometry_msgs/msg/Wrench",
            force=self.vector(values),
            torque=self.vector(0.1 * np.asarray(values)),
        )
        return self.make(
            "geometry_msgs/msg/WrenchStamped", header=self.header(time, frame), wrench=wrench
        )

    def imu(self, time: float, frame: str) -> Any:
        return self.make(
            "sensor_msgs/msg/Imu",
            header=self.header(time, frame),
            orientation=self.quaternion([0, 0, 0, 1]),
            orientation_covariance=np.zeros(9),
            angular_velocity=self.vector([0.1, 0.2, 0.3]),
            angular_velocity_covariance=np.zeros(9),
            linear_acceleration=self.vector([0, 0, 9.81]),
            linear_acceleration_covariance=np.zeros(9),
        )

    def odometry(self, time: float, child: str, position: Any, quaternion: Any) -> Any:
        point = dict(zip("xyz", map(float, position), strict=True))
        pose = self.make(
            "geometry_msgs/msg/Pose",
            position=self.make("geometry_msgs/msg/Point", **point),
            orientation=self.quaternion(quaternion),
        )
        still = self.make(
            "geometry_msgs/msg/Twist", linear=self.vector(np.zeros(3)), angular=self.vector([0] * 3)
        )
        covariance = np.zeros(36)
        return self.make(
            "nav_msgs/msg/Odometry",
            header=self.header(time, "odom"),
            child_frame_id=child,
            pose=self.make(
                "geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance
            ),
            twist=self.make(
                "geometry_msgs/msg/TwistWithCovariance", twist=still, covariance=covariance
            ),
        )

    def prefix_frames(self, prefix: str) -> None:
        """Put a prefix before every frame that a message names."""
        for _, _, message in self._messages:
            if frame := getattr(getattr(message, "header", None), "frame_id", ""):
                message.header.frame_id = f"{prefix}{frame}"
            if hasattr(message, "child_frame_id"):
                message.child_frame_id = f"{prefix}{message.child_frame_id}"

    def close(self) -> Path:
        """Write the file."""
        connections: dict[str, Connection] = {}
        writer: Any = (
            Writer1(self.path)
            if self.ros1
            else Writer2(self.path, version=9, storage_plugin=self._plugin)
        )
        if self.compression is not None:
            writer.set_compression(self.compression, CompressionFormat.ZSTD)
        serialise = self.store.serialize_ros1 if self.ros1 else self.store.serialize_cdr
        with writer:
            for received, topic, message in sorted(self._messages, key=lambda one: one[0]):
                kind = message.__msgtype__
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=self.store)
                stamp = round(1e9 * (START_S + received))
                writer.write(connections[topic], stamp, serialise(message, kind))
        return self.path


def walk(
    folder: Path, name: str, kind: str, joints: tuple[str, ...], *, prefix: str = ""
) -> BagWriter:
    """Two seconds of every signal, each topic with jittered times of its own.

    Joints bear a prefix; wrenches are what the turned sensors feel.
    """
    bag = BagWriter(folder, name, kind)
    generator = np.random.default_rng(1)

    def times(rate: float) -> FloatArray:
        count = int(SECONDS * rate)
        return (np.arange(count) + generator.uniform(0.0, 0.4, count)) / rate

    names = [f"{prefix}{joint}" for joint in joints]
    for time in times(100.0):
        position = [angles(time, place) for place in range(len(joints))]
        effort = np.arange(len(joints))
        bag.add(time + 0.002, "/joint_states", bag.joint_state(time, names, position, effort))
        bag.add(time, "/controller/desired", bag.joint_state(time, names, position))
    for side, turn in (("left", [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]), ("right", [1, -1, -1])):
        rotation = np.diag(turn) if side == "right" else np.array(turn)
        moments = times(200.0)
        for time, row in zip(moments, force(moments) @ rotation.T, strict=True):
            bag.add(time + 0.001, f"/{side}_ankle/wrench", bag.wrench(time, f"{side}_sensor", row))
    for time in times(50.0):
        half = 0.5 * 0.2 * time
        turned = [0.0, 0.0, np.sin(half), np.cos(half)]
        bag.add(time, "/odom", bag.odometry(time, "body", [time, 0.0, 0.8], turned))
        bag.add(time, "/imu/data", bag.imu(time, "body"))
        bag.add(time, "/left_hand/wrench", bag.wrench(time, "left_forearm", [1.0, 2.0, 3.0]))
    bag.add(0.0, "/chatter", bag.make("std_msgs/msg/String", data="not of interest"))
    return bag


def rewritten(
    source: Path,
    target: Path,
    *,
    profile: str = "ros2",
    encoding: str = "",
    undefined: str = "",
    **options: Any,
) -> Path:
    """An MCAP file with the same bytes, written by other options of `mcap`.

    Args:
        source, target: the file, and the new one; they may be one.
        profile: of the new one.
        encoding: of all its messages; empty: as they are.
        undefined: package whose definitions are left out; empty: none.
        options: of the writer.
    """
    content = BytesIO(source.read_bytes())
    with target.open("wb") as written:
        writer, ids = Writer(written, **options), dict[int, int]()
        writer.start(profile=profile)
        for schema, channel, message in make_reader(content).iter_messages():
            assert schema is not None
            if channel.id not in ids:
                kept = not undefined or not schema.name.startswith(undefined)
                given = (schema.encoding, schema.data) if kept else ("", b"")
                ids[channel.id] = writer.register_channel(
                    channel.topic,
                    encoding or channel.message_encoding,
                    writer.register_schema(schema.name, *given),
                    channel.metadata,
                )
            writer.add_message(
                ids[channel.id], message.log_time, message.data, message.publish_time
            )
        writer.finish()
    return target
