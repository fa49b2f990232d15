"""kill -9 of any node at any time of a self-calibration.

All five nodes run as processes of their own, the robot and its serial device simulated. A
self-calibration is begun and at a drawn moment a drawn node is killed: while supports are drawn,
one is reached or a motion planned, as these begin; up to 6 s into a motion, which begins with 1.5 s
of standing; near a motion's end; while solving; as what was found is checked to be applied (two
supports are too few for that, as a rule), or just after. Within 10 s the robot must have come to
rest, for most of the kills long before the motion that it was sent ends by itself, and stay there
for 2 s more (with the simulator there is no robot left; nothing hangs on the model, so the job goes
on and is ended by disarming, from when these times count); within 5 s another node's diagnostics
must name the one that is gone; the job must end, with a reason where it is not done; and when that
node is started again, the next self-calibration must come as far as the next try needs it. A try is
one kill with all of that.

As all of it may share two cores with whatever else they do, inputs count as stale after 2 s
(`stale_s`; default 0.5) and the robot as not following after 4 s (`follow_late`; default 1). How
soon a silence is told with the defaults is shown by `stale-inputs`, not here. The simulator takes
trajectories itself; adapters to robots' drivers are killed by `killed-adapters`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from sensor_msgs.msg import JointState
from shoecal_msgs.action import Calibrate
from std_srvs.srv import SetBool

from reliability.live_world import COMPILE_S, Goal, World, live_world
from reliability.row import Progress, Result, Row
from ros.bodies import NAO, NAO_SHOE, nao_shoe
from shoecal_ros.calibrator.calibration_job import DRAW_SHARE, SOLVE_SHARE
from shoecal_ros.calibrator.run_series import PLAN_SHARE, REACH_SHARE
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import time_from_ros
from shoecal_ros.demo import write_device
from shoecal_ros.inputs.stillness import Stillness

NODES = ("planner", "calibrator", "shoe_driver", "model", "simulator")
STAGES = ("drawing", "reaching", "planning", "moving", "moving", "moving")
ENDING = "near the end of moving"
LATE_EVERY, LATE_STAGES = 12, ("solving", ENDING, "applying")
"""Of so many tries one waits for one of these stages, in turn; they come after a whole motion."""
SPEED = 1.0
"""Of a real robot: a faster simulation waits for whoever listens, the dead too."""
INTO_MOTION_S = (0.0, 6.0)
"""A motion begins with 1.5 s of standing."""
NEAR_END = 0.95
"""Of a motion."""
SUPPORTS = 2
REST_S, LASTS_S, TOLD_S = 10.0, 2.0, 5.0
BITS = 24
LONG_S = 400.0


@dataclass(frozen=True)
class Try:
    """What came of one kill.

    Attributes:
        node, stage: what was killed, and when.
        rest_s: until the robot stood still for good [s]; 0 where it did, or is gone.
        told_s: until another node's diagnostics named it [s].
        reason: with which the job ended.
    """

    node: str
    stage: str
    rest_s: float
    told_s: float
    reason: str

    @property
    def failed(self) -> bool:
        """Whether it took too long."""
        return self.rest_s > REST_S or self.told_s > TOLD_S

    @property
    def told(self) -> str:
        """In words."""
        return (
            f"{self.rest_s:.1f} s to rest, {self.told_s:.1f} s until told "
            f"({self.node} killed while {self.stage})"
        )


class Suite:
    """All nodes, and what the robot does."""

    def __init__(self, world: World) -> None:
        self.world = world
        self._port, self._device = world.folder / "port", world.folder / "device.yaml"
        write_device(self._device, nao_shoe(), self._port, BITS)
        self._still = Stillness(0.01, 0.5, 0.004)
        self._moved_at = 0.0
        world.node.create_subscription(JointState, "joint_states", self._hear, qos.EITHER)
        for node in ("simulator", "shoe_driver", "model", "planner", "calibrator"):
            self.start(node)

    def start(self, node: str) -> None:
        """Start a node with what it needs."""
        world = self.world
        files: dict[str, object] = {"robot_file": NAO, "shoe_file": NAO_SHOE}
        simulated: dict[str, object] = {**files, "use_sim_time": True, "stale_s": 2.0}
        folders = {name: world.folder / name for name in ("state_dir", "sessions_dir")}
        parameters: dict[str, dict[str, object]] = {
            "simulator": {**files, "speed": SPEED, "port": self._port},
            "shoe_driver": {"use_sim_time": True, "config_file": self._device},
            "model": simulated,
            "planner": {**simulated, "follow_late": 4.0},
            "calibrator": {**simulated, **folders},
        }
        world.start(node, parameters[node])

    def calibrate(self, seed: int) -> Goal:
        """Begin a self-calibration once all is ready."""
        world = self.world
        for subject, told in (("joints", "joints come"), ("voltages", "voltages come")):
            world.until_reported("calibrator", subject, told)
        world.until(lambda: _level(world, "nodes") == 0)
        world.until_reported("planner", "planning", "ready", COMPILE_S)
        world.until_reported("planner", "joints", "come")
        self.arm(armed=True)
        goal = Calibrate.Goal(supports=SUPPORTS, train=SUPPORTS, seed=seed)
        return world.goal(Calibrate, "shoe/calibrate", goal)

    def arm(self, *, armed: bool) -> None:
        """Arm or disarm."""
        self.world.call(SetBool, "shoe/arm", SetBool.Request(data=armed))

    def kill_at(self, node: str, stage: str, after_s: float, seed: int) -> Try:
        """Calibrate, kill a node at a stage, see that all comes to rest, start it again."""
        world = self.world
        goal = self.calibrate(seed)
        stage = self._moment(goal, stage, after_s)
        self.world.kill(node)
        killed = time.monotonic()
        others = [name for name in NODES if name != node]
        world.until(lambda: any(_names(world, name, node) for name in others))
        told_s = time.monotonic() - killed
        ends = killed
        if node == "model":
            ends = time.monotonic()
            self.arm(armed=False)
        reason = "killed with it" if node == "calibrator" else str(goal.result().message)
        rest_s = 0.0 if node == "simulator" else self._rest(ends)
        self.start(node)
        world.until(lambda: not any(_names(world, name, node) for name in others))
        return Try(node, stage, rest_s, told_s, reason)

    def _moment(self, goal: Goal, stage: str, after_s: float) -> str:
        """Wait for a moment of a calibration; the stage that it is then in."""
        if stage == "applying":  # which is soon done
            self.world.until(lambda: goal.done or _in(goal, stage), LONG_S)
            if not _in(goal, stage):  # what it told last may come after its result
                end = time.monotonic() + LASTS_S
                self.world.until(lambda: _in(goal, stage) or time.monotonic() > end)
            assert _in(goal, stage), goal.result().message
            return stage
        if stage == ENDING:
            self._until(
                goal, lambda: _in(goal, "moving") and of_motion(goal.feedback[-1]) > NEAR_END
            )
            return stage
        self._until(goal, lambda: _in(goal, stage))
        end = time.monotonic() + after_s
        self._until(goal, lambda: time.monotonic() > end or not _in(goal, stage))
        return str(goal.feedback[-1].stage)

    def _rest(self, since: float) -> float:
        """After what time from a moment on the robot did not move any more [s]."""
        self.world.until(lambda: time.monotonic() > since + REST_S + LASTS_S)
        return max(0.0, self._moved_at - since)

    def _until(self, goal: Goal, condition: Callable[[], object]) -> None:
        """Wait for something in the course of a calibration."""
        self.world.until(lambda: goal.done or condition(), LONG_S)
        assert not goal.done, goal.result().message

    def _hear(self, message: JointState) -> None:
        angles = np.array(message.position)
        self._still.add(time_from_ros(message.header.stamp), angles)
        if not self._still.still:
            self._moved_at = time.monotonic()


def _in(goal: Goal, stage: str) -> bool:
    """Whether a stage is what was told last."""
    return bool(goal.feedback) and goal.feedback[-1].stage == stage


def of_motion(told: Calibrate.Feedback) -> float:
    """How much of the motion under way is done, from what the calibrator tells of all it does."""
    of_runs = (told.progress - DRAW_SHARE) / (1.0 - DRAW_SHARE - SOLVE_SHARE)
    of_run = SUPPORTS * of_runs - (told.support - 1)
    before: float = REACH_SHARE + PLAN_SHARE
    return float((of_run - before) / (1.0 - before))


def _names(world: World, listener: str, node: str) -> bool:
    """Whether a node's diagnostics say that another one has fallen silent."""
    found = world.diagnosis(listener, "nodes")
    return found is not None and found.level != b"\x00" and node in found.message


def _level(world: World, subject: str) -> int:
    found = world.diagnosis("calibrator", subject)
    return 3 if found is None else int.from_bytes(found.level, "little")


def draw(index: int, seed: int) -> tuple[str, str, float]:
    """Node, stage, and time into the stage [s] of a try."""
    rng = np.random.default_rng([seed, index])
    stage = STAGES[int(rng.integers(len(STAGES)))]
    turn, left = divmod(index, LATE_EVERY)
    if left == LATE_EVERY - 1:
        stage = LATE_STAGES[turn % len(LATE_STAGES)]
    after_s = float(rng.uniform(*INTO_MOTION_S)) if stage == "moving" else 0.0
    return NODES[index % len(NODES)], stage, after_s


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Kills first to first + count - 1; what goes wrong ends the tries, and is the last of them."""
    found: list[Try] = []
    node, stage, _ = draw(first, seed)
    why = ""
    try:
        with live_world() as world:
            suite = Suite(world)
            for index in range(first, first + count):
                node, stage, after_s = draw(index, seed)
                found.append(suite.kill_at(node, stage, after_s, index))
                progress(len(found))
            suite.calibrate(first).cancel()
    except AssertionError as error:
        why = f"{node} killed while {stage}: {' '.join(str(error).split())[:150]}"
    return judged(found, count, why)


def judged(found: Sequence[Try], count: int, why: str) -> Result:
    """What some tries came to.

    Args:
        found: those that came to their end.
        count: tries that were asked for.
        why: what ended the next one, or else the calibration after the last; empty: nothing.
    """
    failed = {number for number, one in enumerate(found) if one.failed}
    worst = max(found, key=lambda one: (one.failed, one.rest_s), default=None)
    if why or worst is None:
        # Where all came to their end, no new start worked after the last.
        last = min(len(found), count - 1)
        return Result(last + 1, len(failed | {last}), why, LONG_S)
    return Result(len(found), len(failed), worst.told, worst.rest_s)


ROW = Row(
    key="killed-nodes",
    fault="any node killed at any time during self-calibration",
    holds="the robot comes to rest within 10 s, the rest reports it within 5 s, a new start works",
    tries=100,
    step=5,
    run=run,
)
