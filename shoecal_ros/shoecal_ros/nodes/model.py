"""Node `model`: joint angles -> CoM, modelled CoP and the sole frames."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

from geometry_msgs.msg import PointStamped, TransformStamped
from sensor_msgs.msg import JointState

from shoecal_core.settings import Settings, setting
from shoecal_ros import qos
from shoecal_ros.body import Body, BodyPose
from shoecal_ros.conversions import BASE_LINK, SOLES, header_to_ros, point_to_ros
from shoecal_ros.health import Level
from shoecal_ros.joints import JointInput
from shoecal_ros.robot_files import RobotFiles
from shoecal_ros.runtime import ShoecalNode, run

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


class Model(ShoecalNode):
    """Publishes what the joint angles say of the body."""

    def __init__(self) -> None:
        super().__init__("model")
        files = self.settings(RobotFiles)
        settings = self.settings(ModelSettings)
        robot = files.load_robot()
        self._body = Body(robot)
        self._joints = JointInput(robot, settings.stale_s)
        self._com = self.create_publisher(PointStamped, "shoe/model/com", qos.LIVE)
        self._cop = self.create_publisher(PointStamped, "shoe/model/cop", qos.LIVE)
        self._tf = TFMessage and self.create_publisher(TFMessage, "/tf", qos.TRANSFORMS)
        self.subscribe(JointState, "joint_states", self._hear, qos.RAW)

    def watch(self) -> None:
        """Tell whether joint angles come."""
        problem = self._joints.problem
        self.health.tell(
            "joints", Level.ERROR if problem else Level.OK, problem or "joint angles come"
        )
        super().watch()

    def _hear(self, messages: list[Any]) -> None:
        batch = self._joints.take(messages)
        if batch is None:
            return
        poses = [self._body.pose(angles) for angles in batch.angles]
        for stamp_ns, pose in zip(batch.stamp_ns.tolist(), poses, strict=True):
            self._com.publish(point_to_ros(stamp_ns, BASE_LINK, pose.com))
            self._cop.publish(point_to_ros(stamp_ns, SOLES[0], pose.cop))
        if self._tf is not None:
            # The newest is enough: listeners interpolate.
            self._tf.publish(_transforms(int(batch.stamp_ns[-1]), poses[-1]))


def _transforms(stamp_ns: int, pose: BodyPose) -> Any:
    transforms = []
    for frame, translation, quaternion in zip(
        SOLES, pose.translation.tolist(), pose.quaternion.tolist(), strict=True
    ):
        transform = TransformStamped(
            header=header_to_ros(stamp_ns, BASE_LINK), child_frame_id=frame
        )
        place, turn = transform.transform.translation, transform.transform.rotation
        place.x, place.y, place.z = translation
        turn.x, turn.y, turn.z, turn.w = quaternion
        transforms.append(transform)
    return TFMessage(transforms=transforms)


def main() -> None:
    """Run the node."""
    sys.exit(run(Model))


if __name__ == "__main__":
    main()
