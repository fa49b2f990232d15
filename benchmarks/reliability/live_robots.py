"""What most rows with real nodes share: a robot, and a calibrator with a calibration in force."""

from __future__ import annotations

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.task import Future
from shoecal_msgs.action import ReachSupport
from shoecal_msgs.srv import SetCalibration
from std_msgs.msg import Bool

from reliability.live_world import World
from ros.bodies import calibration, nao, nao_shoe
from ros.standing_robot import StandingRobot
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_ros.calibrator.calibrator_base import REACH_ACTION
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import calibration_to_ros

PERIOD_NS = 10_000_000
SUPPORT = DoubleSupport(0.0, -0.112, 0.0)


class WaitedForRobot(StandingRobot):
    """Publishes joints and voltages at 100 Hz, is armed, and never reaches a support.

    Attributes:
        armed: publishes whether it is.
        waited_for: goals that it has taken.
    """

    def __init__(self, world: World) -> None:
        super().__init__(world, SUPPORT, period_ns=PERIOD_NS)
        self.armed = world.node.create_publisher(Bool, "shoe/armed", qos.LATCHED)
        self.armed.publish(Bool(data=True))
        self.waited_for = 0
        self._server = ActionServer(
            world.node, ReachSupport, REACH_ACTION, self._reach,
            cancel_callback=lambda _: self._canceled(),
        )  # fmt: skip
        self._end = Future()

    def _canceled(self) -> CancelResponse:
        self._end.set_result(None)
        return CancelResponse.ACCEPT

    async def _reach(self, goal: ServerGoalHandle) -> ReachSupport.Result:
        self.waited_for += 1
        self._end = Future()
        await self._end
        goal.canceled()
        return ReachSupport.Result(error_code=ReachSupport.Result.CANCELED)


def put_in_force(
    world: World, identity: str = "made-1", *, simulated: bool = False
) -> SetCalibration.Request:
    """Give the calibrator a calibration of these robots, of simulated time or not; the request."""
    made = calibration_to_ros(calibration(nao(), nao_shoe(), identity))
    made.simulated_time = simulated
    request = SetCalibration.Request(calibration=made)
    answer = world.call(SetCalibration, "shoe/set_calibration", request)
    assert answer.success, answer.message
    return request


def start_calibrator(world: World, **parameters: object) -> None:
    """Start a calibrator with folders of the world, and put a calibration in force."""
    folders = {name: world.folder / name for name in ("state_dir", "sessions_dir")}
    world.start("calibrator", {**folders, **parameters})
    put_in_force(world, simulated=bool(parameters.get("use_sim_time")))
