"""kill -9 of the adapter between the planner and a robot's driver, in the midst of a motion.

The planner moves a NAO that is not there, behind the messages of one of its drivers: set points by
`nao_lola` and `naoqi_driver2`, whole motions by a topic or an action of `ros2_control`. The adapter
is a process of its own and killed at a drawn moment of a motion that was asked for by `/shoe/plan`.
A robot that takes set points must have come to rest within 10 s and stay there for 2 s more, and
the motion end with a reason; a controller was sent the whole motion and nobody is left who may tell
it otherwise, so it need only be at rest that long after the motion's own end: these are counted.
The planner's diagnostics must name the adapter; and when that is started again and the robot armed,
the next motion must begin. A try is one kill with all of that.

Simulated: the robot and its driver, which is at once where it is told to be. So this shows what the
suite does, not how a robot's motors hold.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np
from sensor_msgs.msg import JointState
from shoecal_msgs.action import Plan
from std_srvs.srv import SetBool

from reliability.live_world import COMPILE_S, Goal, World, live_world
from reliability.row import Progress, Result, Row
from ros.adapters.driver_messages import SCRIPT, messages_of
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import trajectory_from_ros

OTHERS = "LShoulderPitch, RShoulderPitch"
ADAPTERS: dict[str, tuple[str, dict[str, object]]] = {
    "nao_lola": ("nao_lola_adapter", {}),
    "naoqi": ("naoqi_adapter", {}),
    "topic": ("controller_adapter", {"controller": "legs", "interface": "topic"}),
    "action": ("controller_adapter", {"controller": "legs", "others": OTHERS}),
}
CONTROLLERS = ("topic", "action")
PLANNER: dict[str, object] = {
    "stale_s": 3.0,
    "follow_late": 4.0,
    "planning.horizon": 5,
    "planning.landmark_radius": 0.012,
    "planning.com_speed": 0.03,
}
"""Shorter planning and motions, and patience on a busy machine."""
INTO_MOTION_S = (2.0, 6.0)
REST_S, LASTS_S = 10.0, 2.0
MOVED = 1e-6
"""rad; an angle that differs by more has moved."""
LONG_S = 400.0


@dataclass(frozen=True)
class Try:
    """What came of one kill.

    Attributes:
        kind: of robot.
        rest_s: until the robot stood still for good [s].
        allowed_s: in which it had to [s].
        told_s: until the planner's diagnostics named the adapter [s].
        reason: with which the motion ended.
    """

    kind: str
    rest_s: float
    allowed_s: float
    told_s: float
    reason: str

    @property
    def went_on(self) -> bool:
        """Whether a controller did what it had been sent."""
        return self.kind in CONTROLLERS and self.rest_s > REST_S

    @property
    def told(self) -> str:
        """In words."""
        return (
            f"{self.told_s:.1f} s until told, {self.rest_s:.1f} s to rest "
            f"({ADAPTERS[self.kind][0]} killed, {self.kind})"
        )


class Scene:
    """A planner, and a kind of robot behind its adapter."""

    def __init__(self, world: World, kind: str) -> None:
        self.world = world
        self.kind = kind
        self._angles: dict[str, float] = {}
        self._moved_at = 0.0
        world.node.create_subscription(JointState, "joint_states", self._hear, qos.EITHER)
        world.start("robot", {"kind": kind, "adapter": ADAPTERS[kind][0]}, script=SCRIPT)
        world.start(*ADAPTERS[kind])
        world.start("planner", PLANNER)
        world.until_reported("planner", "planning", "ready", COMPILE_S)

    def kill(self, after_s: float) -> Try:
        """Begin a motion, kill the adapter a time into it, and begin one again."""
        world, kind = self.world, self.kind
        adapter = ADAPTERS[kind][0]
        goal, begun = self._moving(adapter)
        world.until(lambda: goal.done or time.monotonic() > begun + after_s)
        assert not goal.done, goal.result().message
        world.kill(adapter)
        killed = time.monotonic()
        world.until(lambda: self._names(adapter))
        told_s = time.monotonic() - killed
        result = goal.result()
        assert kind in CONTROLLERS or not result.success, "the planner took it for done"
        ends = max(killed, begun + trajectory_from_ros(result.trajectory).duration)
        allowed_s = REST_S + (ends - killed if kind in CONTROLLERS else 0.0)
        world.until(lambda: time.monotonic() > killed + allowed_s + LASTS_S)
        rest_s = max(0.0, self._moved_at - killed)
        world.start(*ADAPTERS[kind])
        world.until(lambda: not self._names(adapter))
        self._moving(adapter)[0].cancel()
        return Try(kind, rest_s, allowed_s, told_s, str(result.message))

    def _moving(self, adapter: str) -> tuple[Goal, float]:
        """A motion that has just begun, and when it did, monotonic [s]."""
        world = self.world
        world.until_reported("planner", "joints", "come")
        world.until_reported("planner", "commands", adapter)
        world.call(SetBool, "shoe/arm", SetBool.Request(data=True))
        world.until(lambda: _said(world, adapter, "robot") == "armed")
        goal = world.goal(Plan, "shoe/plan", Plan.Goal(motion="landmarks", send=True))
        world.until(lambda: goal.done or any(f.phase == "moving" for f in goal.feedback), LONG_S)
        assert not goal.done, goal.result().message
        return goal, time.monotonic()

    def _names(self, adapter: str) -> bool:
        """Whether the planner says that an adapter has fallen silent."""
        return adapter in _said(self.world, "planner", "nodes")

    def _hear(self, message: JointState) -> None:
        angles = dict(zip(message.name, message.position, strict=True))
        known = self._angles
        if any(abs(angle - known.get(name, angle)) > MOVED for name, angle in angles.items()):
            self._moved_at = time.monotonic()
        self._angles = angles


def _said(world: World, node: str, subject: str) -> str:
    found = world.diagnosis(node, subject)
    return "" if found is None else str(found.message)


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Kills first to first + count - 1; what goes wrong ends the tries, and is the last of them."""
    found: list[Try] = []
    kind, why = "", ""
    try:
        with ExitStack() as stack:
            for robot in ADAPTERS:
                stack.enter_context(messages_of(robot))
            for index in range(first, first + count):
                kind = tuple(ADAPTERS)[index % len(ADAPTERS)]
                after_s = float(np.random.default_rng([seed, index]).uniform(*INTO_MOTION_S))
                with live_world() as world:
                    one = Scene(world, kind).kill(after_s)
                found.append(one)
                progress(len(found))
    except AssertionError as error:
        why = f"{kind}: {' '.join(str(error).split())[:150]}"
    return judged(found, why)


def judged(found: Sequence[Try], why: str) -> Result:
    """What some tries came to.

    Args:
        found: those that came to their end.
        why: what ended the next one; empty: nothing.
    """
    failed = sum(one.rest_s > one.allowed_s for one in found)
    went_on = {"controllers that did all they had been sent": sum(one.went_on for one in found)}
    if why:
        return Result(len(found) + 1, failed + 1, why, LONG_S, went_on)
    worst = max(found, key=lambda one: one.told_s)
    return Result(len(found), failed, worst.told, worst.told_s, went_on)


ROW = Row(
    key="killed-adapters",
    fault="the adapter to the robot's driver killed in a motion",
    holds="the robot comes to rest (a controller at the end of what it was sent), the planner "
    "names the adapter, a new start works",
    tries=40,
    step=4,
    run=run,
)
