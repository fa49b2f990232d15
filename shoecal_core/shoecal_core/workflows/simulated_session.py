"""A session of the simulated robot, without ROS: as fast as the machine allows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from shoecal_core.files import write_yaml
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.motion_sets import PlannedRun
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.posture import UnreachableError
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.steps import Stepper, require_steps_left
from shoecal_core.planning.supports.draw import other_supports
from shoecal_core.progress import Progress
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.sampled_robot import draw
from shoecal_core.simulation.samples import HOLD_S, run
from shoecal_core.workflows.simulated_recording import record_run

SETTLE_S = 1.0
"""InitialStance still after a step, before joint angles are measured for the next one [s]."""
PERIOD_S = 0.02
"""How often the robot is looked at while it steps [s]."""

Watch = Callable[[Motion, float], None]
"""Called with the step and the time since its start [s], every PERIOD_S."""


def walk(
    simulated: SimulatedRobot,
    stepper: Stepper,
    goal: DoubleSupport,
    watch: Watch = lambda *_: None,
) -> list[Motion]:
    """Step until the feet stand in a double support, by the robot's own encoders.

    Args:
        simulated: stands on both feet.
        stepper: plans its steps.
        goal: where to go.
        watch: looks on.

    Returns:
        The steps that were taken; none where it stood there before.

    Raises:
        StepError: when no step, or too many, lead there.
        RobotFellError: when it falls.
        StartError: when it no longer stands as a step must start.
    """
    taken: list[Motion] = []
    while (motion := stepper.step(simulated.joints().angles, goal)) is not None:
        require_steps_left(len(taken), goal)
        take(simulated, motion, watch)
        taken.append(motion)
    return taken


def take(simulated: SimulatedRobot, motion: Motion, watch: Watch = lambda *_: None) -> None:
    """Let the robot follow a motion, and then stand still.

    Raises:
        RobotFellError: when it falls.
    """
    start = simulated.time
    simulated.command(JointTrajectory(motion.joint_names, motion.time, motion.positions))
    for index in range(1, round((motion.duration + SETTLE_S) / PERIOD_S) + 1):
        simulated.step_to(start + index * PERIOD_S)
        simulated.check_upright()
        watch(motion, index * PERIOD_S)


START_NS = 1_000_000_000
"""Stamp of the session's first instant: simulated time has no epoch, but 0 means unset in ROS."""


@dataclass(frozen=True)
class SimulationPlan:
    """What to simulate.

    Attributes:
        robot, shoe: as the estimator knows them.
        reality: how the simulated ones differ.
        settings: of planning.
        runs: what to do where, one after another.
        rate: samples a second [Hz].
        seed: draws the noise.
        robot_seed: draws robot and cells: the same ones for the same number.
        own_steps: whether it walks from support to support, instead of being placed.
        drawn: whether the double supports were drawn. A motion may ask for more than to stand in
            one of them, as to stand on one foot; then another one is drawn for its run.
    """

    robot: Robot
    shoe: Shoe
    reality: PlantVariation
    settings: PlannerSettings
    runs: Sequence[PlannedRun]
    rate: float
    seed: int
    robot_seed: int
    own_steps: bool = False
    drawn: bool = False


def simulate_session(plan: SimulationPlan, out: Path, progress: Progress) -> Session:
    """Draw the robot, let it do each run in its double support, record.

    Steps from one to the next are no runs.

    The truth goes to `truth/`, the drawn reality to `truth/reality.yaml`: nothing that
    calibrates opens either.

    Args:
        progress: see `Progress`.

    Raises:
        ShoecalError: when a support or a motion cannot be had, or the robot falls.
    """
    robot, shoe = plan.robot, plan.shoe
    drawn = draw(plan.reality, robot, shoe, plan.robot_seed)
    simulated = SimulatedRobot(robot, shoe, drawn, np.random.default_rng([plan.seed, 1]))
    starts = _Starts(plan, simulated, progress)
    session = Session.create(out, robot.path, robot.urdf, shoe.path, seed=plan.seed)
    count = len(plan.runs)
    for index in range(count):
        planned, motion = starts.of_run(index)
        progress(f"moving in run {index + 1} of {count}", (index + 0.5) / count)
        trajectory = JointTrajectory(motion.joint_names, motion.time, motion.positions)
        start_ns = START_NS + round(1e9 * simulated.session_time)
        samples = run(simulated, trajectory, plan.rate)
        record_run(session, simulated, planned, trajectory, samples, start_ns=start_ns, hold=HOLD_S)
    write_yaml(session.truth_path(1).parent / "reality.yaml", drawn.record())
    progress("done", 1.0)
    return session


class _Starts:
    """Brings the simulated robot to where its runs start, and plans what it does there."""

    def __init__(self, plan: SimulationPlan, simulated: SimulatedRobot, progress: Progress) -> None:
        self._plan, self._simulated, self._progress = plan, simulated, progress
        self._planner = Planner(plan.robot, plan.settings)
        self._stepper = Stepper(self._planner)
        taken = [planned.support for planned in plan.runs]
        self._others = other_supports(plan.robot, plan.settings, taken, plan.seed)

    def of_run(self, index: int) -> tuple[PlannedRun, Motion]:
        """The run as planned, or in another double support, and its motion.

        Raises:
            UnreachableError: that of the run as planned, when no other double support does.
        """
        planned = self._plan.runs[index]
        try:
            return planned, self._motion(index, planned)
        except UnreachableError:
            for other in self._others if self._plan.drawn else ():
                count = len(self._plan.runs)
                self._progress(
                    f"run {index + 1} of {count} cannot be done there; trying another double "
                    f"support: {other}",
                    index / count,
                )
                planned = replace(planned, support=other)
                with suppress(UnreachableError):
                    return planned, self._motion(index, planned)
            raise

    def _motion(self, index: int, planned: PlannedRun) -> Motion:
        simulated, count = self._simulated, len(self._plan.runs)
        if self._plan.own_steps and index > 0:
            self._progress(f"stepping to run {index + 1} of {count}", index / count)
            walk(simulated, self._stepper, planned.support)
        else:
            simulated.place(self._planner.stance(planned.support))
        self._progress(f"planning run {index + 1} of {count}", index / count)
        return self._planner.plan_from(simulated.joints().angles, planned.motion)
