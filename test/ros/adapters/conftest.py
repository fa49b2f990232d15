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
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.adapters.adapter import NOT_HEARD
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import trajectory_to_ros
from shoecal_ros.common.health import Level

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
        self._kind = kind
        self._adapter = adapter
        self._parameters = parameters
        self._sent = 0
        self.start_robot()
        self.start_adapter()
        if armed_by_test:
            self._armed = world.publisher(Bool, "shoe/armed", qos.ARMED)
            self._armed.publish(Bool(data=False))
            self._commands = world.publisher(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
        world.until(lambda: self._is_ready(heard=armed_by_test), waited_for="a ready adapter")
        self.settle()

    def start_robot(self) -> None:
        """It knows the adapter, once that is there, before it tells its joints."""
        parameters = {"kind": self._kind, "adapter": self._adapter}
        self.world.start("robot", parameters, script=SCRIPT)

    def start_adapter(self) -> None:
        self._sent = 0
        self.world.start(self._adapter, self._parameters)

    def kill_adapter(self) -> None:
        self.world.kill(self._adapter)

    @property
    def reported(self) -> Any:
        """What the adapter last told of the robot; none before there was something."""
        return self.world.diagnosis(self._adapter, "robot")

    def until_reported(self, text: str) -> Any:
        """Wait until the adapter tells that of the robot."""
        return self.world.until_reported(self._adapter, "robot", text)

    def until_well(self, state: str) -> None:
        """Wait until the adapter tells nothing but whether it is armed."""
        self.world.until(
            lambda: (reported := self.reported) and reported.message == state,
            waited_for=f"the diagnostic '{state}' of {self._adapter}",
        )

    def arm(self, *changes: bool) -> None:
        """Arm, or say something else, or one thing just after the other."""
        for armed in changes or (True,):
            self.say(armed=armed)
        self.settle()

    def say(self, *, armed: bool) -> None:
        """Whoever hears that."""
        self._armed.publish(Bool(data=armed))

    def settle(self) -> None:
        """Wait until the adapter has taken what was said and sent."""
        self.world.until_discovered_by(self._adapter)

    def send(self, trajectory: JointTrajectory, stamp_ns: int = 0) -> None:
        """Send it once, to begin at a stamp [ns]; it may be refused."""
        self._sent += 1
        self._commands.publish(trajectory_to_ros(trajectory, stamp_ns))

    def command(self, trajectory: JointTrajectory) -> None:
        """Send it again and again until the adapter has accepted it."""
        self.settle()
        self.world.until(self._has_answered, waited_for="answers to earlier trajectories")
        before = self._count("accepted")

        def accepted() -> bool:
            if not self._has_answered():
                return False
            if self._count("accepted") > before:
                return True
            self.send(trajectory)
            return False

        self.world.until(accepted, waited_for="a trajectory to be accepted")

    def _has_answered(self) -> bool:
        """Whether the adapter has accepted or refused each trajectory since it was started."""
        if self.reported is None:
            return False
        return self._count("accepted") + self._count("refused") == self._sent

    def _count(self, answer: str) -> int:
        values = {value.key: value.value for value in self.reported.values}
        return int(values[f"trajectories_{answer}"])

    def _is_ready(self, *, heard: bool) -> bool:
        """Whether it reports no error, and has heard that the robot is not armed."""
        reported = self.reported
        if reported is None or reported.level >= bytes([Level.ERROR]):
            return False
        return not heard or reported.message != NOT_HEARD


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
