"""kill -9 of any node, or of several at once, at any time of a self-calibration.

All five nodes run as processes of their own, the robot and its serial device simulated. A
self-calibration is begun and at a drawn moment a drawn node is killed, or planner and calibrator,
or all but the robot: while supports are drawn, one is reached or a motion planned, as these begin;
up to 6 s into a motion, which begins with 1.5 s of standing; near a motion's end; while solving; as
what was found is checked to be applied (two supports are too few for that, as a rule), or just
after. Where the planner is killed the robot must rest 0.5 s later, as what it was sent ends then;
where it lives, it has to notice first (below). It stays at rest for 2 s more (with the simulator
there is no robot left; nothing hangs on the model, so the job goes on and is ended by disarming,
from when these times count); within 5 s another node's diagnostics must name the one that is gone;
the job must end, with a reason where it is not done; and when that node is started again, the next
self-calibration must begin. A try is one kill with all of that.

As all of it may share two cores with whatever else they do, inputs count as stale after 2 s
(`stale_s`; default 0.5) and the robot as not following after 4 s (`follow_late`; default 1). How
soon a silence is reported with the defaults is shown by `stale-inputs`, not here. The simulator
takes trajectories itself; adapters to robots' drivers are killed by `stopped_motion`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from sensor_msgs.msg import JointState
from shoecal_msgs.action import Calibrate
from std_srvs.srv import SetBool

from reliability.live_world import Goal, World, is_well, live_tries
from reliability.row import Row
from reliability.tries import BrokenError
from ros.bodies import NAO, NAO_SHOE, nao_shoe
from shoecal_ros.calibrator.calibration_job import DRAW_SHARE, SOLVE_SHARE
from shoecal_ros.calibrator.run_series import PLAN_SHARE, REACH_SHARE
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import time_from_ros
from shoecal_ros.common.renewal import TIMEOUT_S
from shoecal_ros.inputs.stillness import Stillness
from shoecal_ros.simulator.device_file import write_device

NODES = ("planner", "calibrator", "shoe_driver", "model", "simulator")
VICTIMS = (
    *((node,) for node in NODES),
    ("planner", "calibrator"),
    ("planner", "calibrator", "shoe_driver", "model"),
)
STAGES = ("drawing", "reaching", "planning", "moving", "moving", "moving")
ENDING, APPLYING = "near the end of moving", "applying"
LATE_EVERY, LATE_STAGES = 12, ("solving", ENDING, APPLYING)
"""Of so many tries one waits for one of these stages, in turn; they come after a whole motion."""
SPEED = 1.0
"""Of a real robot: a faster simulation waits for whoever listens, the dead too."""
INTO_MOTION_S = (0.0, 6.0)
"""A motion begins with 1.5 s of standing."""
NEAR_END = 0.95
"""Of a motion."""
SUPPORTS = 2
STILL_S = 0.5
"""Over so long a time it must have stood still to be seen at rest."""
STALE_S = 2.0
REST_S = {True: TIMEOUT_S + STILL_S + 0.3, False: STALE_S + 2.0 * STILL_S + 0.5}
"""With the planner killed, and without, in which it notices after STALE_S and stops within half a
second; 0.3 and 0.5 s are granted to messages. In the simulation's time, in which pieces last: on a
busy machine it passes more slowly."""
LASTS_S, REPORTED_S = 4.0, 5.0
BITS = 24
LONG_S = 400.0


class Scene:
    """All nodes, and when the robot last moved."""

    def __init__(self, world: World) -> None:
        self.world = world
        port, device = world.folder / "port", world.folder / "device.yaml"
        write_device(device, nao_shoe(), port, BITS)
        files: dict[str, object] = {"robot_file": NAO, "shoe_file": NAO_SHOE}
        clocked: dict[str, object] = {**files, "use_sim_time": True, "stale_s": STALE_S}
        folders = {name: world.folder / name for name in ("state_dir", "sessions_dir")}
        self._parameters: dict[str, dict[str, object]] = {
            "simulator": {**files, "speed": SPEED, "port": port},
            "shoe_driver": {"use_sim_time": True, "config_file": device},
            "model": clocked,
            "planner": {**clocked, "follow_late": 4.0},
            "calibrator": {**clocked, **folders},
        }
        self._still = Stillness(0.01, STILL_S, 0.004)
        self._now = self._moved_at = 0.0
        world.node.create_subscription(JointState, "joint_states", self._hear, qos.EITHER)
        for node, parameters in self._parameters.items():
            world.start(node, parameters)

    def attempt(self, number: int, rng: np.random.Generator) -> float:
        """Kill nodes; time until the robot is at rest [s]."""
        nodes, stage, after_s = draw(number, rng)
        rest_s, reported_s = self.kill(nodes, stage, after_s, number)
        what = f"{' and '.join(nodes)} killed while {stage}"
        if rest_s > REST_S["planner" in nodes]:
            raise BrokenError(f"{what}: {rest_s:.1f} s to rest")
        if reported_s > REPORTED_S:
            raise BrokenError(f"{what}: {reported_s:.1f} s until reported")
        return rest_s

    def kill(
        self, nodes: Sequence[str], stage: str, after_s: float, seed: int
    ) -> tuple[float, float]:
        """Kill nodes at a stage of a calibration and start them again.

        Returns:
            Time until the robot is at rest, 0 where it is or is gone [s of the simulation], and
            until another node reports those that are gone [s].
        """
        world = self.world
        goal = self._calibrate(seed)
        self._until_stage(goal, stage, after_s)
        killed, ends = time.monotonic(), self._now
        for node in nodes:
            world.processes[node].kill()
        for node in nodes:
            world.kill(node)
        world.until(lambda: all(self._reported(node) for node in nodes))
        reported_s = time.monotonic() - killed
        if nodes == ("model",):
            ends = self._now
            self._arm(armed=False)
        if "calibrator" not in nodes:
            result = goal.result()
            if not (result.success or result.message):
                raise BrokenError(f"{nodes} killed while {stage}: the job ended without a reason")
        rest_s = 0.0
        if "simulator" not in nodes:
            world.until(lambda: self._now > ends + REST_S[False] + LASTS_S)
            rest_s = max(0.0, self._moved_at - ends)
        for node in nodes:
            world.start(node, self._parameters[node])
        world.until(lambda: not any(self._reported(node) for node in nodes))
        again = self._calibrate(seed)
        again.cancel()
        again.result()
        return rest_s, reported_s

    def _calibrate(self, seed: int) -> Goal:
        """Begin a self-calibration once all is ready."""
        world = self.world
        for subject in ("joints", "voltages"):
            world.until_reported("calibrator", subject, f"{subject} come")
        world.until(lambda: is_well(world, "calibrator", "nodes"))
        world.until_reported("planner", "planning", "ready")
        world.until_reported("planner", "joints", "come")
        self._arm(armed=True)
        goal = Calibrate.Goal(supports=SUPPORTS, train=SUPPORTS, seed=seed)
        return world.goal(Calibrate, "shoe/calibrate", goal)

    def _arm(self, *, armed: bool) -> None:
        self.world.call(SetBool, "shoe/arm", SetBool.Request(data=armed))

    def _until_stage(self, goal: Goal, stage: str, after_s: float) -> None:
        """Wait for a time [s] into a stage of a calibration, or until that ends."""
        if stage == APPLYING:  # soon done: its feedback may come after the result
            self.world.until(lambda: goal.done or _is_in(goal, stage), LONG_S)
            end = time.monotonic() + LASTS_S
            self.world.until(lambda: _is_in(goal, stage) or time.monotonic() > end)
            assert _is_in(goal, stage), goal.result().message
        elif stage == ENDING:
            self._until(
                goal, lambda: _is_in(goal, "moving") and of_motion(goal.feedback[-1]) > NEAR_END
            )
        else:
            self._until(goal, lambda: _is_in(goal, stage))
            end = time.monotonic() + after_s
            self._until(goal, lambda: time.monotonic() > end or not _is_in(goal, stage))

    def _until(self, goal: Goal, condition: Callable[[], object]) -> None:
        """Wait for something in the course of a calibration."""
        self.world.until(lambda: goal.done or condition(), LONG_S)
        assert not goal.done, goal.result().message

    def _reported(self, node: str) -> bool:
        """Whether diagnostics of another node say that this one has fallen silent."""
        found = [self.world.diagnosis(name, "nodes") for name in NODES if name != node]
        return any(one and one.level != b"\x00" and node in one.message for one in found)

    def _hear(self, message: JointState) -> None:
        stamp_ns = time_from_ros(message.header.stamp)
        self._still.add(stamp_ns, np.array(message.position))
        self._now = stamp_ns / 1e9
        if not self._still.still:
            self._moved_at = self._now


def _is_in(goal: Goal, stage: str) -> bool:
    """Whether a stage is in the last feedback."""
    return bool(goal.feedback) and goal.feedback[-1].stage == stage


def of_motion(feedback: Calibrate.Feedback) -> float:
    """Share of the motion under way that is done, from the progress of the whole calibration."""
    of_runs = (feedback.progress - DRAW_SHARE) / (1.0 - DRAW_SHARE - SOLVE_SHARE)
    of_run = SUPPORTS * of_runs - (feedback.support - 1)
    before: float = REACH_SHARE + PLAN_SHARE
    return float((of_run - before) / (1.0 - before))


def draw(number: int, rng: np.random.Generator) -> tuple[tuple[str, ...], str, float]:
    """Nodes, stage, and time into the stage [s] of a try."""
    stage = STAGES[rng.integers(len(STAGES))]
    turn, left = divmod(number, LATE_EVERY)
    if left == LATE_EVERY - 1:
        stage = LATE_STAGES[turn % len(LATE_STAGES)]
    after_s = float(rng.uniform(*INTO_MOTION_S)) if stage == "moving" else 0.0
    return VICTIMS[number % len(VICTIMS)], stage, after_s


ROW = Row(
    key="killed-nodes",
    fault="any node, planner and calibrator, or all but the robot killed during self-calibration",
    holds=(
        "the robot rests within 0.5 s (planner killed) or stale_s and 0.5 s, the rest reports it "
        "within 5 s, a new start works"
    ),
    tries=98,
    step=7,
    run=partial(live_tries, Scene, worst="{:.1f} s to rest"),
)
