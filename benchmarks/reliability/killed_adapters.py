"""kill -9 of the adapter between the planner and a robot's driver, in the midst of a motion.

The planner moves a NAO that is not there, behind the messages of one of its drivers: set points by
`nao_lola` and `naoqi_driver2`, whole motions by a topic or an action of `ros2_control`. The adapter
is a process of its own and killed at a drawn moment of a motion that was asked for by `/shoe/plan`.
The robot must have come to rest within 2 s (a controller has at most half a second to go on with)
and stay there for 2 s more, and the motion end with a reason. The planner's diagnostics must name
the adapter; and when that is started again and the robot armed, the next motion must begin. A try
is one kill with all of that.

Simulated: the robot and its driver, which is at once where it is told to be. So this shows what the
suite does, not how a robot's motors hold.
"""

from __future__ import annotations

import time
from contextlib import ExitStack

import numpy as np
from sensor_msgs.msg import JointState
from shoecal_msgs.action import Plan
from std_srvs.srv import SetBool

from reliability.live_world import Goal, World, live_tries
from reliability.row import Progress, Result, Row
from reliability.tries import BrokenError
from ros.adapters.driver_messages import SCRIPT, messages_of
from shoecal_ros.common import qos

OTHERS = "LShoulderPitch, RShoulderPitch"
ADAPTERS: dict[str, tuple[str, dict[str, object]]] = {
    "nao_lola": ("nao_lola_adapter", {}),
    "naoqi": ("naoqi_adapter", {}),
    "topic": ("controller_adapter", {"controller": "legs", "interface": "topic"}),
    "action": ("controller_adapter", {"controller": "legs", "others": OTHERS}),
}
PLANNER: dict[str, object] = {
    "tilt_required": False,
    "load_required": False,
    "stale_s": 3.0,
    "follow_late": 4.0,
    "planning.horizon": 5,
    "planning.landmark_radius": 0.012,
    "planning.com_speed": 0.03,
}
"""Neither an IMU nor shoes, shorter planning and motions, and patience on a busy machine."""
INTO_MOTION_S = (2.0, 6.0)
REST, LASTS = 100, 100
"""Of the robot's own messages, 50 a second: a machine that stands still for a moment sends none."""
MOVED = 1e-6
"""rad; an angle that differs by more has moved."""
LONG_S = 400.0


class Scene:
    """A planner, and the kinds of robots behind their adapters in turn."""

    def __init__(self, world: World) -> None:
        self.world = world
        self._angles: dict[str, float] = {}
        self._heard = self._moved_at = 0
        world.node.create_subscription(JointState, "joint_states", self._hear, qos.EITHER)

    def attempt(self, number: int, rng: np.random.Generator) -> float:
        """Kill an adapter; time until the planner reports it [s]."""
        kind = tuple(ADAPTERS)[number % len(ADAPTERS)]
        adapter = ADAPTERS[kind][0]
        self.world.start("robot", {"kind": kind, "adapter": adapter}, script=SCRIPT)
        self.world.start(*ADAPTERS[kind])
        self.world.start("planner", PLANNER)
        self.world.until_reported("planner", "planning", "ready")
        reported_s = self._kill(kind, adapter, float(rng.uniform(*INTO_MOTION_S)))
        self.world.start(*ADAPTERS[kind])
        self.world.until(lambda: adapter not in self._reported("planner", "nodes"))
        goal, _ = self._begin_motion(adapter)
        goal.cancel()
        for node in ("planner", adapter, "robot"):
            self.world.stop(node)
        return reported_s

    def _kill(self, kind: str, adapter: str, after_s: float) -> float:
        """Kill the adapter a time into a motion; time until the planner reports it [s]."""
        goal, begun = self._begin_motion(adapter)
        self.world.until(lambda: goal.done or time.monotonic() > begun + after_s)
        assert not goal.done, goal.result().message
        self.world.kill(adapter)
        killed, rest_by = time.monotonic(), self._heard + REST
        self.world.until(lambda: adapter in self._reported("planner", "nodes"))
        reported_s = time.monotonic() - killed
        if goal.result().success:
            raise BrokenError(f"{kind}: the planner took the motion for done")
        self.world.until(lambda: self._heard > rest_by + LASTS)
        if self._moved_at > rest_by:
            late = self._moved_at - rest_by
            raise BrokenError(f"{kind}: moved {late} messages later than it may after the kill")
        return reported_s

    def _begin_motion(self, adapter: str) -> tuple[Goal, float]:
        """A motion that has just begun, and when it did, monotonic [s]."""
        world = self.world
        world.until_reported("planner", "joints", "come")
        world.until_reported("planner", "commands", adapter)
        world.call(SetBool, "shoe/arm", SetBool.Request(data=True))
        world.until(lambda: self._reported(adapter, "robot") == "armed")
        goal = world.goal(Plan, "shoe/plan", Plan.Goal(motion="landmarks", send=True))
        world.until(lambda: goal.done or any(f.phase == "moving" for f in goal.feedback), LONG_S)
        assert not goal.done, goal.result().message
        return goal, time.monotonic()

    def _hear(self, message: JointState) -> None:
        angles = dict(zip(message.name, message.position, strict=True))
        known = self._angles
        self._heard += 1
        if any(abs(angle - known.get(name, angle)) > MOVED for name, angle in angles.items()):
            self._moved_at = self._heard
        self._angles = angles

    def _reported(self, node: str, subject: str) -> str:
        found = self.world.diagnosis(node, subject)
        return "" if found is None else str(found.message)


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Kills first to first + count - 1, with the messages of all drivers."""
    with ExitStack() as stack:
        for kind in ADAPTERS:
            stack.enter_context(messages_of(kind))
        return live_tries(Scene, first, count, seed, progress, "{:.1f} s until reported")


ROW = Row(
    key="killed-adapters",
    fault="the adapter to the robot's driver killed in a motion",
    holds="the robot comes to rest within 2 s, the planner names the adapter, a new start works",
    tries=40,
    step=4,
    run=run,
)
