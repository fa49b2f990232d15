"""Waiting for a robot to come to rest."""

from __future__ import annotations

import numpy as np
from sensor_msgs.msg import JointState

from ros.world import World
from shoecal_ros.common.conversions import time_from_ros
from shoecal_ros.inputs.stillness import Stillness


def until_still(world: World) -> None:
    joints = world.receive(JointState, "joint_states")
    stillness, taken = Stillness(0.01, 0.5, 0.004), len(joints)

    def still() -> bool:
        nonlocal taken
        for one in joints.messages[taken:]:
            stillness.add(time_from_ros(one.header.stamp), np.array(one.position))
        taken = len(joints)
        return stillness.still

    world.until(still)
