"""Stand-in robots behind their adapters."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from std_msgs.msg import Bool
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from ros.adapters.driver_messages import SCRIPT, NoMessagesError, messages_of
from ros.world import World
from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import trajectory_to_ros

Begin = Callable[..., "Adapted"]


class Adapted:
    """A stand-in robot, an adapter, and what somebody who moves it says."""

    def __init__(
        self,
        world: World,
        kind: str,
        adapter: str,
        *,
        armed_by_test: bool = True,
        **parameters: object,
    ) -> None:
        self.world = world
        self._adapter = adapter
        world.start("robot", {"kind": kind, "adapter": adapter}, script=SCRIPT)
        world.start(adapter, parameters)
        if armed_by_test:
            self._armed = world.publisher(Bool, "shoe/armed", qos.ARMED)
            self._commands = world.publisher(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
        world.until_told(adapter, "robot", "not armed")
        self.settle()

    def arm(self, *changes: bool) -> None:
        """Arm, or say something else, or one thing just after the other."""
        for armed in changes or (True,):
            self._armed.publish(Bool(data=armed))
        self.settle()

    def settle(self) -> None:
        """Wait until the adapter has taken what was said and sent."""
        self.world.until_known_to(self._adapter)

    def send(self, trajectory: JointTrajectory) -> None:
        self._commands.publish(trajectory_to_ros(trajectory))


@pytest.fixture
def begin(world: World) -> Iterator[Begin]:
    """Starts a stand-in robot and its adapter, not armed."""
    with ExitStack() as stack:

        def start(kind: str, adapter: str, **parameters: Any) -> Adapted:
            try:
                stack.enter_context(messages_of(kind))
            except NoMessagesError as error:
                pytest.skip(str(error))
            return Adapted(world, kind, adapter, **parameters)

        yield start
