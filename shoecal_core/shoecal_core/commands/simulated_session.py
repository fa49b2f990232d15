"""A session of the simulated robot, without ROS: as fast as the machine allows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.commands.simulated_recording import record_run
from shoecal_core.commands.simulated_walk import walk
from shoecal_core.files import write_yaml
from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_core.model.robot import Robot
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.standard import PlannedRun
from shoecal_core.planning.steps import Stepper
from shoecal_core.recording.session import Session
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.simulation.drawn import draw
from shoecal_core.simulation.reality import Reality
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.samples import run

START_NS = 1_000_000_000
"""Stamp of the session's first instant: simulated time has no epoch, but 0 means unset in ROS."""
HOLD_S = 1.0


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
    """

    robot: Robot
    shoe: Shoe
    reality: Reality
    settings: PlannerSettings
    runs: Sequence[PlannedRun]
    rate: float
    seed: int
    robot_seed: int
    own_steps: bool = False


def simulate_session(
    plan: SimulationPlan, out: Path, progress: Callable[[str, float], None]
) -> Session:
    """Draw the robot, let it do each run in its double support, record.

    Steps from one to the next are no runs.

    The truth goes to `truth/`, the drawn reality to `truth/reality.yaml`: nothing that
    calibrates opens either.

    Args:
        progress: told what is being done and the share done (0 to 1).

    Raises:
        ShoecalError: when a support or a motion cannot be had, or the robot falls.
    """
    robot, shoe = plan.robot, plan.shoe
    drawn = draw(plan.reality, robot, shoe, plan.robot_seed)
    simulated = SimulatedRobot(robot, shoe, drawn, np.random.default_rng([plan.seed, 1]))
    planner = Planner(robot, plan.settings)
    stepper = Stepper(planner)
    session = Session.create(out, robot.path, robot.urdf, shoe.path, seed=plan.seed)
    count = len(plan.runs)
    for index, planned in enumerate(plan.runs):
        share = index / count
        if plan.own_steps and index > 0:
            progress(f"stepping to run {index + 1} of {count}", share)
            walk(simulated, stepper, planned.support)
        else:
            simulated.place(planner.stance(planned.support))
        progress(f"planning run {index + 1} of {count}", share)
        motion = planner.plan_from(simulated.joints().angles, planned.motion)
        progress(f"moving in run {index + 1} of {count}", share + 0.5 / count)
        trajectory = JointTrajectory(motion.joint_names, motion.time, motion.positions)
        start_ns = START_NS + round(1e9 * simulated.session_time)
        samples = run(simulated, trajectory, plan.rate, hold=HOLD_S)
        record_run(session, simulated, planned, trajectory, samples, start_ns=start_ns, hold=HOLD_S)
    write_yaml(session.truth_path(1).parent / "reality.yaml", drawn.record())
    progress("done", 1.0)
    return session
