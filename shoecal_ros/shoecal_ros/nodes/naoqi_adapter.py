"""Node `naoqi_adapter`: trajectories to the joint angles that naoqi_driver2 takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from shoecal_core.arrays import FloatArray
from shoecal_core.settings import Settings, setting
from shoecal_ros.adapters.foreign import foreign
from shoecal_ros.adapters.streaming_adapter import StreamingAdapter, unheard
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import header_to_ros
from shoecal_ros.common.process import run


@dataclass(frozen=True)
class NaoqiSettings(Settings):
    """How angles are sent."""

    rate: float = setting(
        20.0, "Hz", "set points a second; each is one call of NAOqi", minimum=2.0, maximum=100.0
    )
    speed: float = setting(
        0.2,
        "",
        "share of its largest speed at which a joint goes to each set point; more than motions "
        "need, or it trails",
        minimum=0.01,
        maximum=1.0,
    )


class NaoqiAdapter(StreamingAdapter):
    """`joint_states` need no adapter: naoqi_driver2 names joints as the NAO's URDF does."""

    def __init__(self) -> None:
        super().__init__("naoqi_adapter")
        self._settings = self.settings(NaoqiSettings)
        self._angles = foreign("naoqi_bridge_msgs", "msg", "JointAnglesWithSpeed")
        self._publisher = self.create_publisher(self._angles, "joint_angles", qos.COMMAND)
        self.send_at(self._settings.rate)

    @property
    def missing(self) -> str:
        """Why no node takes joint angles; empty where one does."""
        return unheard(self._publisher, "naoqi_driver2")

    def send(self, names: Sequence[str], angles: FloatArray) -> None:
        """Publish set points (k,) [rad] of the joints that have a motor of their own."""
        followers = {self.robot.joint_names[motor.joint] for motor in self.robot.shared}
        reported = {
            name: angle
            for name, angle in zip(names, angles.tolist(), strict=True)
            if name not in followers
        }
        self._publisher.publish(
            self._angles(
                header=header_to_ros(self.now_ns, ""),
                joint_names=list(reported),
                joint_angles=list(reported.values()),
                speed=self._settings.speed,
                relative=0,
            )
        )


def main() -> None:
    """Run the node."""
    run(NaoqiAdapter)


if __name__ == "__main__":
    main()
