"""A NAO that is not there, behind the messages of one of its drivers; a process of its own.

It moves at once to where it is told to be, and tells so as that driver does. Where it is told which
adapter is to move it, it begins once that one knows it, so that no command is lost.
"""

from __future__ import annotations

import faulthandler
import importlib
import math
import signal
import sys
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

import rclpy
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from ros.bodies import nao
from ros.introduction import Introduction
from shoecal_ros.common.process import DEADLINE_S

PERIOD_S = 0.02
ASKED_TO_END = threading.Event()
HANDS = ("LHand", "RHand")
LOLA = (
    "HeadYaw", "HeadPitch", "LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll",
    "LWristYaw", "LHipYawPitch", "LHipRoll", "LHipPitch", "LKneePitch", "LAnklePitch",
    "LAnkleRoll", "RHipRoll", "RHipPitch", "RKneePitch", "RAnklePitch", "RAnkleRoll",
    "RShoulderPitch", "RShoulderRoll", "RElbowYaw", "RElbowRoll", "RWristYaw", "LHand", "RHand",
)  # fmt: skip
"""The order that nao_lola documents, written down here once more: the adapter's is under test."""


class StandIn(Node):
    """A robot that tells its joints."""

    def __init__(self, left_out: tuple[str, ...] = (), untold: tuple[str, ...] = ()) -> None:
        super().__init__("robot")
        self.angles = dict(zip(nao().joint_names, nao().posture.tolist(), strict=True))
        self._left_out, self._untold = left_out, untold
        self._joints = self.create_publisher(JointState, "joint_states", 10)
        self._introduction: Introduction | None = None
        self.create_timer(PERIOD_S, self.tell)

    def meet(self, adapter: str) -> None:
        """Make oneself known, everything else being made."""
        self._introduction = Introduction(self, adapter)

    def tell(self) -> None:
        if self._introduction is not None and not self._introduction.done:
            return
        message = JointState()
        message.header.stamp = self.get_clock().now().to_msg()
        message.name = [name for name in self.angles if name not in self._left_out]
        message.position = [
            math.nan if name in self._untold else self.angles[name] for name in message.name
        ]
        self._joints.publish(message)

    def move(self, angles: Mapping[str, float]) -> None:
        """Be where it is told; both hips turn with the left one's motor."""
        self.angles.update(angles)
        self.angles["RHipYawPitch"] = self.angles["LHipYawPitch"]


def foreign(package: str, kind: str, name: str) -> Any:
    return getattr(importlib.import_module(f"{package}.{kind}"), name)


def nao_lola() -> StandIn:
    robot = StandIn(left_out=("RHipYawPitch",))
    heat = foreign("nao_lola_sensor_msgs", "msg", "JointTemperatures")
    temperatures = robot.create_publisher(heat, "sensors/joint_temperatures", 10)

    def take(message: Any) -> None:
        reported = zip(message.indexes, message.positions, strict=True)
        robot.move({LOLA[index]: position for index, position in reported})

    robot.create_subscription(
        foreign("nao_lola_command_msgs", "msg", "JointPositions"),
        "effectors/joint_positions",
        take,
        1,
    )
    robot.create_timer(
        0.1, lambda: temperatures.publish(heat(temperatures=[30.0 + k for k in range(25)]))
    )
    return robot


def naoqi() -> StandIn:
    robot = StandIn(untold=HANDS)

    def take(message: Any) -> None:
        assert message.relative == 0
        assert 0.0 < message.speed <= 1.0
        # NAOqi knows no joint of its follower's name.
        assert "RHipYawPitch" not in message.joint_names
        robot.move(dict(zip(message.joint_names, message.joint_angles, strict=True)))

    robot.create_subscription(
        foreign("naoqi_bridge_msgs", "msg", "JointAnglesWithSpeed"), "joint_angles", take, 10
    )
    return robot


def _waited(until_s: float, stopped: Callable[[], bool]) -> bool:
    """Whether that moment came before anything ended the motion."""
    while time.monotonic() < until_s:
        if stopped() or ASKED_TO_END.wait(0.002):
            return False
    return True


def _followed(
    robot: StandIn, message: JointTrajectory, stopped: Callable[[], bool], pace: float = 1.0
) -> bool:
    """Go from point to point, in so many times what is due; whether the end was reached.

    Stamps are honoured as by ros2_control's joint_trajectory_controller: points that are past are
    left out, and nothing is done that has ended.
    """
    stamp = message.header.stamp
    age = 0.0
    if stamp.sec:
        age = max(0.0, time.time() - stamp.sec - stamp.nanosec * 1e-9)
    begun = time.monotonic() - age
    for point in message.points:
        due = pace * (point.time_from_start.sec + point.time_from_start.nanosec * 1e-9)
        if due < age:
            continue
        if not _waited(begun + due, stopped):
            return False
        robot.move(dict(zip(message.joint_names, point.positions, strict=True)))
    return True


def topic_controller(topic: str = "legs/joint_trajectory") -> StandIn:
    """A new trajectory takes the place of the last."""
    robot = StandIn()
    newest: list[JointTrajectory] = []

    def take(message: JointTrajectory) -> None:
        newest[:] = [message]
        threading.Thread(
            target=_followed, args=(robot, message, lambda: newest[0] is not message), daemon=True
        ).start()

    robot.create_subscription(JointTrajectory, topic, take, 10)
    return robot


def action_controller(
    pace: float = 1.0,
    cancel: Callable[[Any], CancelResponse] = lambda _: CancelResponse.ACCEPT,
    *,
    stuck: bool = False,
    settling_s: float = 0.0,
) -> StandIn:
    """Refuses goals without the arms, as a controller of all joints does.

    One that is stuck agrees to end a goal, and never does. At the end of a goal it may settle for
    a while: as long the goal goes on.
    """
    robot = StandIn()
    kind = foreign("control_msgs", "action", "FollowJointTrajectory")
    newest: list[Any] = [None]

    def judge(request: Any) -> GoalResponse:
        complete = "LShoulderPitch" in request.trajectory.joint_names
        return GoalResponse.ACCEPT if complete else GoalResponse.REJECT

    def ends(goal: Any) -> bool:
        return (goal.is_cancel_requested and not stuck) or newest[0] is not goal

    def execute(goal: Any) -> Any:
        newest[0] = goal
        result = kind.Result()
        if any(abs(point.positions[0]) > 0.9 for point in goal.request.trajectory.points):
            goal.abort()
            result.error_code = kind.Result.PATH_TOLERANCE_VIOLATED
            result.error_string = "too far"
        elif _followed(robot, goal.request.trajectory, lambda: ends(goal), pace) and _waited(
            time.monotonic() + settling_s, lambda: ends(goal)
        ):
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return result

    # Kept by the node.
    robot.server = ActionServer(  # type: ignore[attr-defined]
        robot,
        kind,
        "legs/follow_joint_trajectory",
        execute,
        goal_callback=judge,
        cancel_callback=cancel,
        callback_group=ReentrantCallbackGroup(),
    )
    return robot


def refusing_controller(settling_s: float = math.inf) -> StandIn:
    """Cancels nothing before it is told to give in, and settles meanwhile."""
    accepts_cancel = threading.Event()
    robot = action_controller(
        cancel=lambda _: (
            CancelResponse.ACCEPT if accepts_cancel.is_set() else CancelResponse.REJECT
        ),
        settling_s=settling_s,
    )

    def accept_cancel(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        accepts_cancel.set()
        response.success = True
        return response

    robot.create_service(Trigger, "robot/accept_cancel", accept_cancel)
    return robot


def hanging_controller() -> StandIn:
    """Never answers the first who wants something cancelled."""
    hung = threading.Event()

    def cancel(_: Any) -> CancelResponse:
        if hung.is_set():
            return CancelResponse.ACCEPT
        hung.set()
        ASKED_TO_END.wait()
        return CancelResponse.REJECT

    return action_controller(cancel=cancel)


KINDS = {
    "nao_lola": nao_lola,
    "naoqi": naoqi,
    "topic": topic_controller,
    "direct": lambda: topic_controller("joint_trajectory"),
    "action": action_controller,
    "slow_action": lambda: action_controller(40.0),
    "refusing_action": refusing_controller,
    "settling_action": lambda: refusing_controller(settling_s=4.0),
    "hanging_action": hanging_controller,
    "stuck_action": lambda: action_controller(stuck=True, settling_s=math.inf),
}


def main() -> None:
    # The threads leave before the middleware does.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGINT, lambda *_: ASKED_TO_END.set())
    words = dict(word.split(":=") for word in sys.argv if ":=" in word)
    robot = KINDS[words["kind"].strip('"')]()
    if "adapter" in words:
        robot.meet(words["adapter"].strip('"'))
    executor = MultiThreadedExecutor(4)
    executor.add_node(robot)
    while not ASKED_TO_END.is_set():
        executor.spin_once(timeout_sec=0.1)
    # The middleware may hang in its destructors, see `middleware_failed`.
    faulthandler.dump_traceback_later(DEADLINE_S, exit=True)
    executor.shutdown()
    robot.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
