"""A motion is under way, and nodes between the plan and the robot are killed or paused.

The planner moves a NAO that is not there: by `/joint_trajectory` itself, as a controller with that
topic does, or behind the messages of a driver, by an adapter: set points of `nao_lola` and
`naoqi_driver2`, trajectories to a topic or an action of `ros2_control`. At a drawn moment, as a
motion begins, in its midst, or on one foot, the planner, the adapter or both are killed (kill -9)
or paused (SIGSTOP, for 0.5 to 5 s, then SIGCONT).

Killed: the robot rests 0.5 s later, and stays at rest; the motion ends with a reason, and where the
planner lives its diagnostics name the adapter; all that was killed is started again, and the next
motion begins. The figure is the time from the kill to the stamp of the last message of joint angles
in which one had moved; what is sent 50 times a second, takes its way through three processes and is
followed from point to point by the stand-in (0.05 s) is granted 0.2 s.

Paused: when the process continues, the robot stays or goes on with the motion, but does nothing
that was commanded before, nor anything that is commanded by what was known before; the figure is
how far it leaves that in the next 0.6 s, in which a command to hold a posture of before would have
been done.

Simulated: the robot and its driver, which is at once where it is told to be. So this shows what the
suite does, not how a robot's motors hold. The planner's arming does not matter here: nothing takes
it back.
"""

from __future__ import annotations

import signal
import time
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from typing import Literal

import numpy as np
from sensor_msgs.msg import JointState
from shoecal_msgs.action import Plan
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from reliability.live_world import Goal, World, live_tries, wait
from reliability.row import Progress, Result, Row
from reliability.tries import BrokenError
from ros.adapters.driver_messages import SCRIPT, messages_of
from ros.bodies import nao
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import time_from_ros, trajectory_from_ros
from shoecal_ros.common.renewal import TIMEOUT_S

OTHERS = "LShoulderPitch, RShoulderPitch"
ADAPTERS: dict[str, tuple[str, dict[str, object]]] = {
    "nao_lola": ("nao_lola_adapter", {}),
    "naoqi": ("naoqi_adapter", {}),
    "topic": ("controller_adapter", {"controller": "legs", "interface": "topic"}),
    "action": ("controller_adapter", {"controller": "legs", "others": OTHERS}),
}
DIRECT = "direct"
"""A robot that takes trajectories itself."""
KINDS = {
    ("planner",): (DIRECT, *ADAPTERS),
    ("adapter",): tuple(ADAPTERS),
    ("planner", "adapter"): tuple(ADAPTERS),
}
"""Of robots, by who is killed or paused."""
PHASES = ("moving", "on one foot", "beginning")
MOTIONS = {"beginning": "landmarks", "moving": "landmarks", "on one foot": "unload_right"}
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
GRANTED_S = 0.2
LASTS_S = 2.0
"""For so long after the time in which it has to come to rest the robot is watched."""
PAUSE_S = (0.5, 5.0)
BACK_S, BACK_RAD = 0.6, 2e-3
"""Within so long a hold would have pulled it back, by more than that: the planner's motions pass
0.03 rad in 0.2 s."""
WAY_STEP_S, PASSED_OVER = 0.01, 21
"""Between the postures that stand for a command, and how many stand for the way to each."""
MOVED = 1e-6
"""rad; an angle that differs by more has moved."""
BEGUN = 1e-4
"""rad; a motion has begun."""
LIFTED = 0.004
"""rad; the right ankle's way from where the motion began, by when a foot is about to be lifted."""
LONG_S = 400.0


class Scene:
    """A planner, and the kinds of robots, with their adapters or without, in turn."""

    def __init__(
        self,
        world: World,
        *,
        victims: tuple[str, ...],
        attempt: Literal["kill", "pause"],
        granted_s: float,
    ) -> None:
        self.world = world
        self._granted_s = granted_s
        self._victims = victims
        self.attempt = self.kill if attempt == "kill" else self.pause
        self._angles = np.zeros(0)
        self._names: tuple[str, ...] = ()
        self._moved_at = 0.0
        self._seen: list[tuple[float, FloatArray]] = []
        self._sent: list[tuple[float, JointTrajectory]] = []
        world.node.create_subscription(JointState, "joint_states", self._hear, qos.EITHER)
        world.node.create_subscription(
            JointTrajectoryMsg, "joint_trajectory", self._note, qos.COMMAND
        )

    def kill(self, number: int, rng: np.random.Generator) -> float:
        """Kill nodes in a motion; time until the robot rests [s]."""
        victims = self._victims
        kind, phase = drawn(victims, number)
        nodes = self._begin(kind)
        goal = self._until_moving(nodes, phase, rng)
        killed_at = time.time()
        for victim in victims:
            self.world.processes[nodes[victim]].kill()
        for victim in victims:
            self.world.kill(nodes[victim])
        wait(self.world, TIMEOUT_S + self._granted_s + LASTS_S)
        rest_s = max(0.0, self._moved_at - killed_at)
        if rest_s > TIMEOUT_S + self._granted_s:
            raise BrokenError(f"{kind}, {' and '.join(victims)}, {phase}: {rest_s:.2f} s to rest")
        if "planner" not in victims:
            self.world.until(lambda: nodes["adapter"] in self._reported("planner", "nodes"))
            if goal.result().success:
                raise BrokenError(f"{kind}: the planner took the motion for done")
        self._start(kind, nodes, victims)
        self._until_moving(nodes, "beginning", rng).cancel()
        self._end(nodes)
        return rest_s

    def pause(self, number: int, rng: np.random.Generator) -> float:
        """Pause nodes in a motion; how far the robot leaves its course afterwards [rad]."""
        victims = self._victims
        kind, phase = drawn(victims, number)
        nodes = self._begin(kind)
        goal = self._until_moving(nodes, phase, rng)
        paused_s = float(rng.uniform(*PAUSE_S))
        last = self._sent[-1][1]
        self._sent.clear()
        for victim in victims:
            self.world.processes[nodes[victim]].send_signal(signal.SIGSTOP)
        wait(self.world, paused_s)
        resumed_at = time.time()
        for victim in victims:
            self.world.processes[nodes[victim]].send_signal(signal.SIGCONT)
        wait(self.world, BACK_S)
        own = sorted({*last.names} & {*self._names})
        sent = [(at, on_its_way(one, own)) for at, one in self._sent]
        columns = [self._names.index(name) for name in own]
        seen = [(at, angles[columns]) for at, angles in self._seen]
        way = on_its_way(last, own)
        off = off_course(seen, way, sent, resumed_at, planner_slept="planner" in victims)
        if off > BACK_RAD:
            raise BrokenError(
                f"{kind}, {' and '.join(victims)}, {phase}: {off:.4f} rad off after "
                f"{paused_s:.1f} s"
            )
        goal.cancel()
        goal.result()
        self._end(nodes)
        return off

    def _begin(self, kind: str) -> dict[str, str]:
        """Start a robot and what moves it; names of nodes by part."""
        nodes = {"planner": "planner"}
        knows = "planner"
        if kind != DIRECT:
            nodes["adapter"] = knows = ADAPTERS[kind][0]
        self.world.start("robot", {"kind": kind, "adapter": knows}, script=SCRIPT)
        self._start(kind, nodes, tuple(nodes))
        return nodes

    def _start(self, kind: str, nodes: dict[str, str], parts: tuple[str, ...]) -> None:
        if "adapter" in parts:
            self.world.start(*ADAPTERS[kind])
        if "planner" in parts:
            self.world.start("planner", PLANNER)
        self.world.until_reported("planner", "planning", "ready")
        self.world.until_reported("planner", "joints", "come")
        listener = nodes.get("adapter", "robot")
        self.world.until_reported("planner", "commands", listener)
        self.world.until(lambda: listener not in self._reported("planner", "nodes"))

    def _until_moving(self, nodes: dict[str, str], phase: str, rng: np.random.Generator) -> Goal:
        """Arm, ask for a motion, and wait for a phase of it."""
        world = self.world
        world.call(SetBool, "shoe/arm", SetBool.Request(data=True))
        if "adapter" in nodes:
            world.until(lambda: self._reported(nodes["adapter"], "robot") == "armed")
        goal = world.goal(Plan, "shoe/plan", Plan.Goal(motion=MOTIONS[phase], send=True))
        world.until(lambda: goal.done or any(f.phase == "moving" for f in goal.feedback), LONG_S)
        assert not goal.done, goal.result().message
        first, self._seen = self._angles, []

        def moved() -> FloatArray:
            return np.abs(self._angles - first)

        # A motion begins with standing.
        world.until(lambda: goal.done or moved().max() > BEGUN)
        if phase == "on one foot":
            ankle = self._names.index("RAnkleRoll")
            world.until(lambda: goal.done or moved()[ankle] > LIFTED)
        if phase != "beginning":
            wait(world, float(rng.uniform(0.5, 3.0)))
        assert not goal.done, goal.result().message
        return goal

    def _end(self, nodes: dict[str, str]) -> None:
        for node in nodes.values():
            self.world.stop(node)
        # The stand-in's threads may wait for a goal's end for ever; it is not under test.
        self.world.kill("robot")

    def _hear(self, message: JointState) -> None:
        known = nao().joint_names
        names = tuple(name for name in message.name if name in known)
        angles = np.array(
            [
                angle
                for name, angle in zip(message.name, message.position, strict=True)
                if name in known
            ]
        )
        now = time_from_ros(message.header.stamp) / 1e9
        angles = np.nan_to_num(angles)
        if names != self._names or np.abs(angles - self._angles).max() > MOVED:
            self._moved_at = now
        self._names, self._angles = names, angles
        self._seen.append((now, angles))

    def _note(self, message: JointTrajectoryMsg) -> None:
        now, trajectory = time.time(), trajectory_from_ros(message)
        # What the pause kept on its way is of before by its stamp, and no robot follows it.
        if time_from_ros(message.header.stamp) / 1e9 + trajectory.duration > now:
            self._sent.append((now, trajectory))

    def _reported(self, node: str, subject: str) -> str:
        found = self.world.diagnosis(node, subject)
        return "" if found is None else str(found.message)


def drawn(victims: tuple[str, ...], number: int) -> tuple[str, str]:
    """Kind of robot and phase of the motion of a try."""
    kinds = KINDS[victims]
    return kinds[number % len(kinds)], PHASES[number // len(kinds) % len(PHASES)]


def on_its_way(command: JointTrajectory, names: Sequence[str]) -> FloatArray:
    """(k, m) postures of some of its joints on the way of a command [rad]."""
    steps = 1 + round(command.duration / WAY_STEP_S)
    angles: FloatArray = command.at(np.linspace(command.times[0], command.times[-1], steps))
    return angles[:, [command.names.index(name) for name in names]]


def off_course(
    seen: Sequence[tuple[float, FloatArray]],
    last: FloatArray,
    sent: Sequence[tuple[float, FloatArray]],
    resumed_at: float,
    *,
    planner_slept: bool,
) -> float:
    """By how much a robot leaves what it may do after a pause [rad].

    It may stay, go on with what it was doing, and go to what was sent since the pause began. Of
    that the planner, where it slept, may have sent nothing that begins elsewhere than on that way.

    Args:
        seen: times [s] and joint angles (m,) [rad], in order.
        last: (k, m) postures on the way of the command that was being done as the pause began.
        sent: of those since, times [s] and postures (k, m) [rad] on the way of each command.
        resumed_at: from when on it counts [s].
        planner_slept: or else the adapter alone.
    """
    rest = [angles for at, angles in seen if at <= resumed_at][-1]
    # What lies before where it rests would be a way back.
    nearest = int(np.argmin(np.abs(last - rest).max(axis=1)))
    allowed, off = np.vstack([rest, _passed_over(rest, last[nearest:])]), 0.0
    for at, postures in sent:
        if planner_slept and at > resumed_at:
            off = max(off, _from(allowed, postures[0]))
        allowed = np.vstack([allowed, _passed_over(rest, postures)])
    return max([off, *(_from(allowed, angles) for at, angles in seen if at > resumed_at)])


def _passed_over(rest: FloatArray, postures: FloatArray) -> FloatArray:
    """(K, m) on the straight ways from rest (m,) to postures (k, m), as adapters pass over."""
    shares = np.linspace(0.0, 1.0, PASSED_OVER)[:, None, None]
    found: FloatArray = (rest + shares * (postures - rest)).reshape(-1, len(rest))
    return found


def _from(allowed: FloatArray, posture: FloatArray) -> float:
    return float(np.abs(allowed - posture).max(axis=1).min())


def run(
    victims: tuple[str, ...],
    do: Literal["kill", "pause"],
    first: int,
    count: int,
    seed: int,
    progress: Progress,
    granted_s: float = GRANTED_S,
) -> Result:
    """Tries first to first + count - 1, with the messages of all drivers.

    `granted_s` [s]: for messages on their way; more of it on a machine that does other work.
    """
    worst = {"kill": "{:.2f} s to rest", "pause": "{:.4f} rad off"}[do]
    scene = partial(Scene, victims=victims, attempt=do, granted_s=granted_s)
    with ExitStack() as stack:
        for driver in ADAPTERS:
            stack.enter_context(messages_of(driver))
        return live_tries(scene, first, count, seed, progress, worst)


def _row(do: Literal["kill", "pause"], victims: tuple[str, ...]) -> Row:
    done = {"kill": "killed", "pause": "paused"}[do]
    holds = {
        "kill": "the robot rests within 0.5 s (0.2 s granted to messages), a new start works",
        "pause": "the robot does nothing that was commanded before the pause",
    }[do]
    kinds = len(KINDS[victims])
    return Row(
        key=f"{done}-in-motion-{'-'.join(victims)}",
        fault=f"{' and '.join(victims)} {done} in a motion",
        holds=holds,
        tries=kinds * len(PHASES) * {"kill": 1, "pause": 3}[do],
        step=kinds,
        run=partial(run, victims, do),
    )


ROWS = (
    *(_row("kill", victims) for victims in KINDS),
    *(_row("pause", victims) for victims in KINDS),
)
