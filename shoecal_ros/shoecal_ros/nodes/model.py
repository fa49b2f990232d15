"""Node `model`: joint angles -> CoM, modelled CoP, the sole frames, and markers for viewers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from geometry_msgs.msg import PointStamped, TransformStamped
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import JointState

from shoecal_core.robot.kinematics import BodyStates, Kinematics
from shoecal_core.settings import Settings, setting
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import header_to_ros, point_to_ros
from shoecal_ros.common.frames import Frames, FrameSettings
from shoecal_ros.common.health import Condition
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.common.process import run
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.inputs.joints import JointInput
from shoecal_ros.model.marker_publisher import MarkerPublisher

try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # not part of every installation of ROS
    TFMessage = None


@dataclass(frozen=True)
class ModelSettings(Settings):
    """Of the node alone."""

    stale_s: float = setting(
        0.5, "s", "without joint angles for that long they are stale", minimum=0.01
    )
    publish_tf: bool = setting(
        True,
        "",
        "publishes the sole frames on /tf, but none that is a link of the URDF, which the robot's "
        "own driver publishes; false where another node publishes them",
    )


class ModelNode(ShoecalNode):
    """Publishes what the joint angles say of the body."""

    def __init__(self) -> None:
        super().__init__("model")
        files = self.settings(RobotFiles)
        settings = self.settings(ModelSettings)
        robot = files.load_robot()
        self._frames = self.settings(FrameSettings).frames(robot)
        self._markers = MarkerPublisher(self, robot, files.load_shoe(), self._frames.soles)
        self._kinematics = Kinematics(robot)
        senders = self.peers.expect_one_sender("joint_states")
        self._joints = JointInput(robot, settings.stale_s, senders=senders)
        self._com = self.create_publisher(PointStamped, "shoe/model/com", qos.LIVE)
        self._cop = self.create_publisher(PointStamped, "shoe/model/cop", qos.LIVE)
        self.peers.alone |= {self._com.topic_name, self._cop.topic_name}
        self._tf = None
        if TFMessage is not None and settings.publish_tf and not all(self._frames.links):
            self._tf = self.create_publisher(TFMessage, "/tf", qos.TRANSFORMS)
        self.subscribe(JointState, "joint_states", self._hear, qos.RAW)

    def watch(self) -> None:
        """Report whether joint angles come."""
        figures = self._joints.heard.figures()
        reported = Condition.of(self._joints.problem, "joint angles come", figures)
        self.health.note("joints", reported)
        self._markers.watch(None if self._joints.silent else self._joints.latest)
        super().watch()

    def _hear(self, messages: list[Any]) -> None:
        batch = self._joints.take(messages)
        if batch is None:
            return
        states = self._kinematics.states(batch.angles)
        for stamp_ns, com, cop in zip(
            batch.stamp_ns.tolist(), states.com_in_base, states.cop[:, 0], strict=True
        ):
            self._com.publish(point_to_ros(stamp_ns, self._frames.base, com))
            self._cop.publish(point_to_ros(stamp_ns, self._frames.soles[0], cop))
        if self._tf is not None:
            # The newest is enough: listeners interpolate.
            self._tf.publish(_transforms(int(batch.stamp_ns[-1]), states, self._frames))


def _transforms(stamp_ns: int, states: BodyStates, frames: Frames) -> Any:
    """The soles that are no links of the URDF, in the base, as the last sample has them."""
    turn, place = states.left_rotation[-1], states.left_translation[-1]
    poses = (
        (place, turn),
        (place + turn @ states.translation[-1], turn @ states.rotation[-1]),
    )
    transforms = []
    for frame, link, (translation, rotation) in zip(frames.soles, frames.links, poses, strict=True):
        if link:
            continue
        transform = TransformStamped(
            header=header_to_ros(stamp_ns, frames.base), child_frame_id=frame
        )
        where, how = transform.transform.translation, transform.transform.rotation
        where.x, where.y, where.z = translation.tolist()
        how.x, how.y, how.z, how.w = Rotation.from_matrix(rotation).as_quat().tolist()
        transforms.append(transform)
    return TFMessage(transforms=transforms)


def main() -> None:
    """Run the node."""
    run(ModelNode)


if __name__ == "__main__":
    main()
