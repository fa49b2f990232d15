"""A session of the simulated robot, without ROS: as fast as the machine allows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.commands.simulated_walk import walk
from shoecal_core.files import write_yaml
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_core.model.robot import Robot
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.steps import Stepper
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.session import Session
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.simulation.drawn import draw
from shoecal_core.simulation.reality import Reality
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.samples import Samples, run

START_NS = 1_000_000_000
"""Stamp of the first sample: simulated time has no epoch, but 0 means unset in ROS."""
HOLD_S = 1.0


@dataclass(frozen=True)
class SimulationPlan:
    """What to simulate.

    Attributes:
        robot, shoe: as the estimator knows them.
        reality: how the simulated ones differ.
        settings: of planning.
        supports: where to move, one run each.
        motion: name on the planner's menu.
        rate: samples a second [Hz].
        seed: draws the noise.
        robot_seed: draws robot and cells: the same ones for the same number.
        own_steps: whether it walks from support to support, instead of being placed.
    """

    robot: Robot
    shoe: Shoe
    reality: Reality
    settings: PlannerSettings
    supports: Sequence[DoubleSupport]
    motion: str
    rate: float
    seed: int
    robot_seed: int
    own_steps: bool = False


def simulate_session(
    plan: SimulationPlan, out: Path, progress: Callable[[str, float], None]
) -> Session:
    """Draw the robot, move it in each double support, record.

    Steps from one to the next are no runs.

    The truth goes to `truth/`, the drawn reality to `truth/reality.yaml`: nothing that
    calibrates opens either.

    Args:
        progress: told what is being done and the share done (0 to 1).

    Raises:
        ShoecalError: when a support or a motion cannot be had, or the robot falls.
    """
    robot, shoe = plan.robot, plan.shoe
    supports = plan.supports
    drawn = draw(plan.reality, robot, shoe, plan.robot_seed)
    simulated = SimulatedRobot(robot, shoe, drawn, np.random.default_rng([plan.seed, 1]))
    planner = Planner(robot, plan.settings)
    stepper = Stepper(planner)
    session = Session.create(out, robot.path, robot.urdf, shoe.path, seed=plan.seed)
    clock_ns = START_NS
    for index, support in enumerate(supports):
        share = index / len(supports)
        if plan.own_steps and index > 0:
            progress(f"stepping to run {index + 1} of {len(supports)}", share)
            walk(simulated, stepper, support)
        else:
            simulated.place(planner.stance(support))
        progress(f"planning run {index + 1} of {len(supports)}", share)
        motion = planner.plan_from(simulated.joints().angles, plan.motion)
        progress(f"moving in run {index + 1} of {len(supports)}", share + 0.5 / len(supports))
        trajectory = JointTrajectory(motion.joint_names, motion.time, motion.positions)
        samples = run(simulated, trajectory, plan.rate, hold=HOLD_S)
        _record(session, plan, support, motion, samples, clock_ns)
        clock_ns += round(1e9 * (samples.time[-1] - samples.time[0] + HOLD_S))
    write_yaml(session.truth_path(1).parent / "reality.yaml", drawn.record())
    progress("done", 1.0)
    return session


def _record(
    session: Session,
    plan: SimulationPlan,
    support: DoubleSupport,
    motion: Motion,
    samples: Samples,
    start_ns: int,
) -> None:
    robot, shoe = plan.robot, plan.shoe
    stamps = start_ns + np.rint(1e9 * (samples.time - samples.time[0])).astype(np.int64)
    with session.new_run(plan.motion, support) as writer:
        command_ns = start_ns + round(1e9 * HOLD_S)
        commanded = messages.joint_trajectory(
            command_ns, motion.joint_names, motion.time, motion.positions
        )
        pending = [(command_ns, schemas.JOINT_TRAJECTORY, commanded)]
        for index, stamp in enumerate(map(int, stamps)):
            while pending and pending[0][0] <= stamp:
                sent, topic, message = pending.pop()
                writer.write(topic, message, sent)
            joints = messages.joint_state(
                stamp,
                robot.joint_names,
                samples.joints.angles[index],
                samples.joints.efforts[index],
            )
            writer.write(schemas.JOINT_STATES, joints, stamp)
            voltages = messages.shoe_voltages(
                stamp, index, shoe.names, samples.readings.voltages[index],
                samples.readings.status[index],
            )  # fmt: skip
            writer.write(schemas.VOLTAGES, voltages, stamp)
    with session.new_truth(writer.info) as truth:
        for index, stamp in enumerate(map(int, stamps)):
            truth.write(
                stamp,
                samples.truth.cop[index],
                samples.truth.foot_cop[index],
                samples.truth.foot_force[index, :, 2],
            )
